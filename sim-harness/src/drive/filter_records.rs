//! Translates a node's events into records; no other code does.

use amiro_ipf::filter::Outcome;
use amiro_ipf::geometry::{Point, Pose, Rotation};
use amiro_ipf::model::{Gain, Reading, Sample};
use amiro_ipf::node::{Config, Event, Particles, StepBegun};

use super::{PointOutcome, RangeScan, Record, Return};
use crate::geometry::{Pose2, Vector};

/// Translates the events of a node, on a board or on the host, into records.
///
/// A step gives its pose, one scan of all eight sensors, and the outcomes of its
/// particles that count (paper equation 3): survivors past the gate as occupied, rejected
/// ones in view as free. Outcomes of a step whose beginning was lost are dropped: their
/// pose is unknown.
#[derive(Clone, Debug)]
pub struct FilterRecords {
    config: Config,
    /// The lowest bits of the index of the step whose outcomes follow.
    step: Option<u8>,
    position: Point,
    rotation: Rotation,
}

impl FilterRecords {
    /// A translator for the sensors of a configuration.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: *config,
            step: None,
            position: Point::default(),
            rotation: Rotation::by(0.0),
        }
    }

    /// Passes on the records that an event gives: none, one or two.
    pub fn translate(&mut self, event: &Event, take: &mut dyn FnMut(&Record)) {
        match event {
            Event::StepBegun(step) => self.begin_step(step, take),
            Event::Particles(particles) if self.step == Some(particles.step) => {
                take(&Record::Outcomes(self.outcomes(particles)));
            }
            Event::OdometryReset { stamp_us } => take(&Record::OdometryReset {
                stamp_us: *stamp_us,
            }),
            _ => {}
        }
    }

    fn begin_step(&mut self, step: &StepBegun, take: &mut dyn FnMut(&Record)) {
        self.step = Some(step.index as u8);
        self.position = step.pose.position;
        self.rotation = Rotation::by(step.pose.heading.radians());
        let records = scan_records(&self.config, step.stamp_us, step.pose, &step.samples);
        records.iter().for_each(take);
    }

    fn outcomes(&self, particles: &Particles) -> Vec<PointOutcome> {
        let outcome = |is_occupied, position: Point| PointOutcome {
            place: Vector::from(self.position + position.rotated(self.rotation)),
            is_occupied,
        };
        particles
            .outcomes
            .iter()
            .filter_map(|event| match event.outcome() {
                Outcome::SurvivedPastGate => Some(outcome(true, event.position())),
                Outcome::RejectedFree => Some(outcome(false, event.position())),
                Outcome::SurvivedBelowGate | Outcome::RejectedUnobserved => None,
            })
            .collect()
    }
}

/// The records of a step: the pose, and one scan of all eight sensors.
pub(crate) fn scan_records(
    config: &Config,
    stamp_us: u64,
    pose: Pose,
    samples: &[Sample],
) -> [Record; 2] {
    let world_from_body = Pose2::from(pose);
    let scan = RangeScan {
        stamp_us,
        world_from_body,
        mounts: 0..samples.len(),
        returns: returns(config, samples),
        signals: signals(config, samples),
    };
    let pose = Record::Pose {
        stamp_us,
        world_from_body,
    };
    [pose, Record::Scan(scan)]
}

/// The returns of infrared samples, each by the law of its own sensor.
fn returns(config: &Config, samples: &[Sample]) -> Vec<Return> {
    let law = |gain| config.photometry.with_gain(gain);
    let measured = |(sample, gain): (&Sample, &Gain)| match law(*gain).read(*sample) {
        Reading::Range(echo) => Return::Echo {
            range_m: f64::from(echo.range_m),
            sigma_m: f64::from(echo.sigma_m),
        },
        Reading::NothingInRange(limit) => Return::NoEcho {
            limit_m: f64::from(limit.range_m),
            sigma_m: f64::from(limit.sigma_m),
        },
        Reading::TooClose => Return::TooClose,
        Reading::Faulty => Return::Invalid,
    };
    samples.iter().zip(&config.gains).map(measured).collect()
}

/// The counts of samples above the dark value of the sensors, as a sensor of the gain 1
/// would measure them: (s - beta) / gain.
fn signals(config: &Config, samples: &[Sample]) -> Vec<Option<f64>> {
    let beta_counts = f64::from(config.photometry.beta_counts);
    let signal = |(sample, gain): (&Sample, &Gain)| match sample {
        Sample::Counts(counts) => {
            Some((f64::from(*counts) - beta_counts) / f64::from(gain.ratio()))
        }
        Sample::Saturated | Sample::Missing => None,
    };
    samples.iter().zip(&config.gains).map(signal).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::model::{Photometry, SENSORS};
    use amiro_ipf::node::ParticleEvent;

    fn begun(index: u32) -> Event {
        Event::StepBegun(StepBegun {
            index,
            stamp_us: 7,
            pose: Pose::new(1.0, 2.0, core::f32::consts::FRAC_PI_2),
            samples: [Sample::Missing; SENSORS],
        })
    }

    fn particles(step: u8, outcomes: &[Outcome]) -> Event {
        let mut particles = Particles {
            step,
            ..Particles::default()
        };
        for outcome in outcomes {
            // 100 mm ahead, 5 mm left, in units of 1/64 mm.
            let event = ParticleEvent::new((6400, 320), *outcome);
            particles.outcomes.push(event).unwrap();
        }
        Event::Particles(particles)
    }

    fn records(events: &[Event]) -> Vec<Record> {
        let mut translator = FilterRecords::new(&Config::default());
        let mut records = Vec::new();
        for event in events {
            translator.translate(event, &mut |record| records.push(record.clone()));
        }
        records
    }

    #[test]
    fn outcomes_are_placed_in_the_world_and_two_of_four_count() {
        let all = [
            Outcome::SurvivedPastGate,
            Outcome::SurvivedBelowGate,
            Outcome::RejectedFree,
            Outcome::RejectedUnobserved,
        ];
        let records = records(&[begun(3), particles(3, &all)]);
        let [
            Record::Pose { .. },
            Record::Scan(scan),
            Record::Outcomes(outcomes),
        ] = &records[..]
        else {
            panic!("{records:?}");
        };
        assert_eq!(scan.returns, [Return::Invalid; SENSORS]);
        let kinds: Vec<_> = outcomes.iter().map(|found| found.is_occupied).collect();
        assert_eq!(kinds, [true, false]);
        // The robot looks along +y: ahead is up, left is towards -x.
        for found in outcomes {
            let off = found.place - Vector::new(0.995, 2.1);
            assert!(off.norm() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn outcomes_without_the_beginning_of_their_step_are_dropped() {
        let one = [Outcome::SurvivedPastGate];
        assert_eq!(records(&[particles(0, &one)]), []);
        let records = records(&[begun(3), particles(4, &one)]);
        assert_eq!(records.len(), 2, "{records:?}");
    }

    #[test]
    fn readings_become_echoes_and_limits() {
        let samples = [Sample::Counts(361), Sample::Counts(-16), Sample::Saturated];
        let [
            Return::Echo { range_m, .. },
            Return::NoEcho { limit_m, .. },
            Return::TooClose,
        ] = returns(&Config::default(), &samples)[..]
        else {
            panic!("{samples:?}");
        };
        assert!((range_m - 0.05).abs() < 1e-4, "{range_m}");
        assert!((limit_m - 0.2).abs() < 1e-6, "{limit_m}");
    }

    #[test]
    fn signals_are_counts_above_the_dark_value_and_need_a_measured_sample() {
        let samples = [Sample::Counts(361), Sample::Saturated, Sample::Missing];
        let mut config = Config::default();
        let dark = f64::from(Photometry::VCNL4020.beta_counts);
        assert_eq!(signals(&config, &samples), [Some(361.0 - dark), None, None]);
        config.gains[0] = Gain::of(0.5).unwrap();
        let doubled = 2.0 * (361.0 - dark);
        assert_eq!(signals(&config, &samples), [Some(doubled), None, None]);
    }
}
