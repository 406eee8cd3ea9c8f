//! When the node steps the filter, and the events of a step.

use super::batch::Batch;
use super::{Event, Fault, Node, Obstacle, StepBegun, StepDone, StepRule};
use crate::filter::Tally;
use crate::geometry::Pose;
use crate::math;
use crate::model::{SENSORS, Sample, SensorMask};

/// When and where the newest readings were taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampled {
    stamp_us: u64,
    pose: Pose,
}

impl<const N: usize> Node<'_, N> {
    /// Finds the pose at which the samples were taken, and steps if a step is due.
    pub(super) fn on_proximity(
        &mut self,
        stamp_us: u64,
        samples: [Sample; SENSORS],
        emit: &mut impl FnMut(&Event),
    ) -> Result<(), Fault> {
        let last = self.last_sampled;
        if last.is_some_and(|last| stamp_us < last.stamp_us) {
            return Err(Fault::StampBackward);
        }
        let pose = self.odometry.pose_at(&self.config.drive, stamp_us)?;
        let travel_m = last.map(|last| last.pose.motion_to(&pose).travel());
        let sampled = Sampled { stamp_us, pose };
        self.last_sampled = Some(sampled);
        self.samples.take(stamp_us, &samples);
        if self.is_step_due(travel_m) {
            return self.step(&sampled, emit);
        }
        Ok(())
    }

    /// The sample-per-speed rule: a step at the first reading, then one per distance.
    fn is_step_due(&mut self, travel_m: Option<f32>) -> bool {
        match (self.config.step_rule, travel_m) {
            (StepRule::PerTick { .. }, _) => false,
            (StepRule::PerDistance { .. }, None) => true,
            (StepRule::PerDistance { step_m }, Some(travel_m)) => {
                self.trigger.advance(travel_m, step_m)
            }
        }
    }

    /// Steps at the newest readings under [`StepRule::PerTick`].
    pub(super) fn on_tick(&mut self, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        let sampled = self.last_sampled.ok_or(Fault::NoReading)?;
        if let StepRule::PerTick { .. } = self.config.step_rule {
            return self.step(&sampled, emit);
        }
        Ok(())
    }

    /// Steps the filter and emits the events of the step.
    ///
    /// Refused when no sensor has counts: without an observation no particle would be
    /// rejected, and all would pass the gate.
    fn step(&mut self, sampled: &Sampled, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        let samples = self.samples.select(self.config.choice);
        let samples = in_use(self.config.sensors, samples);
        let without = without_counts(&samples);
        self.status.without = without.0;
        if without == SensorMask::ALL {
            return Err(Fault::NoSensor);
        }
        self.samples.begin_window();
        let index = self.status.steps;
        let motion = self
            .last_step
            .map(|last| last.motion_to(&sampled.pose))
            .unwrap_or_default();
        let readings = samples.map(|sample| self.model.photometry().read(sample));
        emit(&Event::StepBegun(StepBegun {
            index,
            stamp_us: sampled.stamp_us,
            pose: sampled.pose,
            samples,
        }));
        let mut batch = Batch::new(index, emit);
        let tally = self
            .filter
            .step(&self.model, &motion, &readings, |position, outcome| {
                batch.push(position, outcome);
            });
        batch.flush();
        let digest = self.filter.digest();
        emit(&Event::StepDone(step_done(index, digest, &tally)));
        self.last_step = Some(sampled.pose);
        self.status.steps = index.wrapping_add(1);
        self.status.obstacle = tally.nearest.map(|position| Obstacle {
            range_m: position.norm(),
            bearing_rad: math::coarse_atan2(position.y, position.x),
        });
        Ok(())
    }
}

/// The samples of the sensors in use; the others are missing.
fn in_use(sensors: SensorMask, mut samples: [Sample; SENSORS]) -> [Sample; SENSORS] {
    for (sensor, sample) in samples.iter_mut().enumerate() {
        if !sensors.contains(sensor) {
            *sample = Sample::Missing;
        }
    }
    samples
}

/// The sensors whose sample is missing or saturated.
fn without_counts(samples: &[Sample; SENSORS]) -> SensorMask {
    (0..SENSORS)
        .zip(samples)
        .filter(|(_, sample)| !matches!(sample, Sample::Counts(_)))
        .fold(SensorMask::NONE, |mask, (sensor, _)| mask.with(sensor))
}

fn step_done(index: u32, digest: u32, tally: &Tally) -> StepDone {
    let count = |count: u32| u16::try_from(count).unwrap_or(u16::MAX);
    StepDone {
        index,
        digest,
        past_gate: count(tally.past_gate),
        below_gate: count(tally.below_gate),
        free: count(tally.free),
        unobserved: count(tally.unobserved),
        departed: count(tally.departed),
        degenerate: tally.live > 0 && tally.weight_sum == 0,
    }
}
