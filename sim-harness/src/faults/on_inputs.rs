//! Faults on the inputs of a recording.

use std::collections::VecDeque;

use amiro_ipf::board::proximity_sensor::DEFAULT_OFFSET;
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::Input;
use amiro_ipf::random::{Generator, uniform};

use super::window::micros;
use super::{ActiveFaults, Component, Faults, Kind};
use crate::bus::Outages;

/// Keeps the noise of recordings apart from all other: "input".
const INPUT_STREAM: u64 = 0x69_6e70_7574;
/// A loose sensor is missing for a round or not: 8 ms.
const SLOT_NS: u64 = 8_000_000;

/// A fault without an effect on inputs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{fault}\" cannot be seen in a recording's inputs: they take off, stuck, garbage, wrong, \
     saturated and intermittent of a sensor, off, wrong, delayed and intermittent of can; \
     `simulate --fault` has the rest"
)]
pub struct NotOnInputs {
    fault: String,
}

impl Faults {
    /// The inputs as a robot with these faults would have recorded them: times count from
    /// the first input with a stamp.
    ///
    /// A sensor that is `stuck` repeats its first counts of that time, one that is
    /// `garbage` gives 16 random bits above the default offset. Odometry that is
    /// `delayed` comes later and is stamped when it comes, as on the robot. Wheel speeds
    /// cannot be `wrong`.
    ///
    /// # Errors
    /// The first fault of a part that has no meaning on inputs; faults of the line are ignored.
    pub fn on_inputs(&self, seed: u64, inputs: &[Input]) -> Result<Vec<Input>, NotOnInputs> {
        let faulty = self.on_stream(seed, inputs.iter().copied())?;
        Ok(faulty.collect())
    }

    /// The same one after another, for inputs of any number.
    ///
    /// Memory: the odometry that is delayed.
    ///
    /// # Errors
    /// As [`on_inputs`](Self::on_inputs).
    pub fn on_stream<I>(&self, seed: u64, inputs: I) -> Result<FaultyInputs<I>, NotOnInputs> {
        self.check_on_inputs()?;
        Ok(FaultyInputs {
            inputs,
            first_us: None,
            is_at_end: false,
            broken: Broken {
                faults: self.active(seed),
                stuck: [None; SENSORS],
                late: VecDeque::new(),
                output: VecDeque::new(),
            },
        })
    }

    /// Checks that each fault of a part has a meaning on inputs.
    ///
    /// # Errors
    /// The first that has none; faults of the line are ignored.
    pub fn check_on_inputs(&self) -> Result<(), NotOnInputs> {
        match self.parts.iter().find(|fault| !is_on_inputs(fault)) {
            Some(fault) => Err(NotOnInputs {
                fault: fault.to_string(),
            }),
            None => Ok(()),
        }
    }
}

/// Inputs with faults, one after another.
pub struct FaultyInputs<I> {
    inputs: I,
    /// Stamp of the first input that has one.
    first_us: Option<u64>,
    is_at_end: bool,
    broken: Broken,
}

impl<I: Iterator<Item = Input>> Iterator for FaultyInputs<I> {
    type Item = Input;

    fn next(&mut self) -> Option<Input> {
        loop {
            if let Some(input) = self.broken.output.pop_front() {
                return Some(input);
            }
            if self.is_at_end {
                return None;
            }
            let Some(input) = self.inputs.next() else {
                self.is_at_end = true;
                self.broken.deliver_until(u64::MAX);
                continue;
            };
            let now_us = stamp_us(&input).map_or(0, |stamp_us| {
                stamp_us.saturating_sub(*self.first_us.get_or_insert(stamp_us))
            });
            self.broken.take(input, now_us);
        }
    }
}

fn is_on_inputs(fault: &super::Fault) -> bool {
    match fault.component {
        Component::Sensor(_) | Component::Ring => {
            !matches!(fault.kind, Kind::Slow(_) | Kind::Delayed(_))
        }
        Component::Can => !matches!(fault.kind, Kind::Stuck | Kind::Garbage | Kind::Slow(_)),
        Component::Bus(_) | Component::Mux(_) | Component::Link => fault.kind == Kind::Ok,
    }
}

fn stamp_us(input: &Input) -> Option<u64> {
    match *input {
        Input::Proximity { stamp_us, .. }
        | Input::Odometry { stamp_us, .. }
        | Input::Wheels { stamp_us, .. }
        | Input::Tick { stamp_us } => Some(stamp_us),
        Input::Configure(_) | Input::Limit { .. } => None,
    }
}

/// The state of the faults on a stream of inputs.
struct Broken {
    faults: ActiveFaults,
    stuck: [Option<Sample>; SENSORS],
    /// Odometry that is still to come, with its new stamp.
    late: VecDeque<(u64, Input)>,
    /// Inputs that are ready to be returned.
    output: VecDeque<Input>,
}

impl Broken {
    fn take(&mut self, input: Input, now_us: u64) {
        if let Some(stamp_us) = stamp_us(&input) {
            self.deliver_until(stamp_us);
        }
        match input {
            Input::Proximity { stamp_us, samples } => {
                let mut sensor = 0..;
                let samples = samples.map(|sample| match sensor.next() {
                    Some(sensor) => self.sample(sensor, sample, now_us),
                    None => sample,
                });
                self.output
                    .push_back(Input::Proximity { stamp_us, samples });
            }
            Input::Odometry { .. } | Input::Wheels { .. } => self.take_motion(input, now_us),
            _ => self.output.push_back(input),
        }
    }

    fn sample(&mut self, sensor: usize, sample: Sample, now_us: u64) -> Sample {
        let active = self.faults.placed(Component::Sensor(sensor), now_us);
        let active: Vec<_> = active.collect();
        let stuck = active.iter().any(|(_, kind)| *kind == Kind::Stuck);
        let mut faulty = sample;
        for (place, kind) in active {
            faulty = match (kind, faulty) {
                (Kind::Off, _) => Sample::Missing,
                (Kind::Intermittent(share), faulty) => {
                    if self.is_out(place, share, now_us) {
                        Sample::Missing
                    } else {
                        faulty
                    }
                }
                // A missing sample has no value to change.
                (_, Sample::Missing) => Sample::Missing,
                (Kind::Saturated, _) => Sample::Saturated,
                (Kind::Stuck, faulty) => self.stuck_at(sensor, faulty),
                (Kind::Garbage, _) => self.garbage(sensor, now_us),
                (Kind::Wrong(by), Sample::Counts(counts)) => {
                    Sample::Counts(counts.saturating_add(by))
                }
                (_, faulty) => faulty,
            };
        }
        if !stuck && let Some(held) = self.stuck.get_mut(sensor) {
            *held = None;
        }
        faulty
    }

    fn stuck_at(&mut self, sensor: usize, sample: Sample) -> Sample {
        let held = self.stuck.get_mut(sensor);
        held.map_or(sample, |held| *held.get_or_insert(sample))
    }

    fn garbage(&self, sensor: usize, now_us: u64) -> Sample {
        let moment = (now_us << 3 | sensor as u64).rotate_left(20);
        let mut noise = Generator::seeded(self.faults.seed() ^ INPUT_STREAM ^ moment);
        // The upper half of the bits.
        match (noise.bits() >> 16) as u16 {
            u16::MAX => Sample::Saturated,
            raw => Sample::Counts(i32::from(raw) - i32::from(DEFAULT_OFFSET)),
        }
    }

    /// Whether a loose contact is open now; two of them are not open at the same times.
    fn is_out(&self, place: usize, share: f64, now_us: u64) -> bool {
        let seed = self
            .faults
            .seed()
            .wrapping_add(1 + place as u64)
            .rotate_left(32);
        Outages::new(SLOT_NS, share, seed).fails_at(now_us.saturating_mul(1_000))
    }

    fn take_motion(&mut self, mut input: Input, now_us: u64) {
        let mut noise =
            Generator::seeded(self.faults.seed() ^ INPUT_STREAM ^ now_us.rotate_left(40));
        let mut late_us = 0;
        for kind in self.faults.of(Component::Can, now_us) {
            match kind {
                Kind::Off => return,
                Kind::Intermittent(share) if f64::from(uniform(&mut noise)) < share => return,
                Kind::Delayed(by) => late_us = micros(by),
                Kind::Wrong(by_mm) => {
                    if let Input::Odometry { pose, .. } = &mut input {
                        pose.position.x += by_mm as f32 * 1e-3;
                    }
                }
                _ => {}
            }
        }
        let due_us = stamp_us(&input).unwrap_or(0).saturating_add(late_us);
        // Later odometry does not overtake delayed odometry.
        let last_us = self.late.back().map_or(0, |(last_us, _)| *last_us);
        if late_us == 0 && self.late.is_empty() {
            self.output.push_back(input);
        } else {
            self.late.push_back((due_us.max(last_us), input));
        }
    }

    /// Delivers the delayed odometry that is due by a time.
    fn deliver_until(&mut self, now_us: u64) {
        while let Some(&(due_us, mut input)) = self.late.front()
            && due_us <= now_us
        {
            self.late.pop_front();
            match &mut input {
                Input::Odometry { stamp_us, .. } | Input::Wheels { stamp_us, .. } => {
                    *stamp_us = due_us;
                }
                _ => {}
            }
            self.output.push_back(input);
        }
    }
}
