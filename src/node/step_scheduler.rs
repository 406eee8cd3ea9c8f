//! When a step is due, and what it consumes: odometry and samples brought together.

use super::odometry::{Continuity, Odometry};
use super::{Config, Input, InputError, SampleWindow, StepRule, StepTrigger};
use crate::geometry::{Motion, Pose};
use crate::model::{SENSORS, Sample, SensorMask};

/// What a step consumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInput {
    /// When the newest samples were taken, microseconds.
    pub stamp_us: u64,
    /// Where the robot was then, in the world frame.
    pub pose: Pose,
    /// Motion since the last step, in the body frame; none in the first step.
    pub motion: Motion,
    /// One sample per sensor; those of sensors that are not in use are missing.
    pub samples: [Sample; SENSORS],
}

/// What follows from an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scheduled {
    /// No step is due.
    Nothing,
    /// A step is due.
    Step(StepInput),
    /// The odometry lost its origin: the motion since the last step is unknown.
    OdometryReset {
        /// When, microseconds.
        stamp_us: u64,
    },
}

/// Takes odometry, samples and ticks, and schedules the steps of a mapping method.
///
/// It holds no particles: the filter and a mapper without one get the same steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepScheduler {
    odometry: Odometry,
    trigger: StepTrigger,
    samples: SampleWindow,
    last_sampled: Option<Sampled>,
    last_step: Option<Pose>,
    without: SensorMask,
}

/// When and where the newest samples were taken.
#[derive(Clone, Copy, Debug)]
struct Sampled {
    stamp_us: u64,
    pose: Pose,
}

impl StepScheduler {
    /// Takes one input; at most one step follows.
    ///
    /// [`Input::Configure`] and [`Input::Limit`] concern the filter: nothing follows.
    ///
    /// # Errors
    /// Why the input was refused: those of [`Odometry`]; [`InputError::StampBackward`] for
    /// samples older than the last; [`InputError::NoReading`] for a tick before any sample;
    /// [`InputError::NoSensor`] when a step is due and no sensor in use has counts.
    pub fn take(&mut self, config: &Config, input: &Input) -> Result<Scheduled, InputError> {
        match *input {
            Input::Odometry { stamp_us, pose } => {
                let continuity = self.odometry.take_pose(stamp_us, pose)?;
                Ok(self.on_odometry(stamp_us, continuity))
            }
            Input::Wheels { stamp_us, speeds } => {
                let continuity = self.odometry.take_wheels(&config.drive, stamp_us, speeds)?;
                Ok(self.on_odometry(stamp_us, continuity))
            }
            Input::Proximity { stamp_us, samples } => self.on_proximity(config, stamp_us, samples),
            Input::Tick { .. } => self.on_tick(config),
            Input::Configure(_) | Input::Limit { .. } => Ok(Scheduled::Nothing),
        }
    }

    /// The sensors without counts when a step was last due.
    #[must_use]
    pub fn without(&self) -> SensorMask {
        self.without
    }

    /// Treats the next samples as the first ones after a reset of the odometry.
    fn on_odometry(&mut self, stamp_us: u64, continuity: Continuity) -> Scheduled {
        if continuity != Continuity::Reset {
            return Scheduled::Nothing;
        }
        self.trigger = StepTrigger::default();
        self.last_sampled = None;
        self.last_step = None;
        Scheduled::OdometryReset { stamp_us }
    }

    /// Finds the pose at which the samples were taken.
    fn on_proximity(
        &mut self,
        config: &Config,
        stamp_us: u64,
        samples: [Sample; SENSORS],
    ) -> Result<Scheduled, InputError> {
        let last = self.last_sampled;
        if last.is_some_and(|last| stamp_us < last.stamp_us) {
            return Err(InputError::StampBackward);
        }
        let pose = self.odometry.pose_at(&config.drive, stamp_us)?;
        let travel_m = last.map(|last| last.pose.motion_to(&pose).travel());
        let sampled = Sampled { stamp_us, pose };
        self.last_sampled = Some(sampled);
        self.samples.take(stamp_us, &samples);
        if self.is_step_due(config.step_rule, travel_m) {
            return self.step(config, &sampled);
        }
        Ok(Scheduled::Nothing)
    }

    /// The sample-per-speed rule: a step at the first samples, then one per distance.
    fn is_step_due(&mut self, rule: StepRule, travel_m: Option<f32>) -> bool {
        match (rule, travel_m) {
            (StepRule::PerTick { .. }, _) => false,
            (StepRule::PerDistance { .. }, None) => true,
            (StepRule::PerDistance { step_m }, Some(travel_m)) => {
                self.trigger.advance(travel_m, step_m)
            }
        }
    }

    /// A step at the newest samples under [`StepRule::PerTick`].
    fn on_tick(&mut self, config: &Config) -> Result<Scheduled, InputError> {
        let sampled = self.last_sampled.ok_or(InputError::NoReading)?;
        if let StepRule::PerTick { .. } = config.step_rule {
            return self.step(config, &sampled);
        }
        Ok(Scheduled::Nothing)
    }

    /// A step with the samples since the last one.
    ///
    /// Refused when no sensor has counts: without an observation no particle would be
    /// rejected, and all would pass the gate.
    fn step(&mut self, config: &Config, sampled: &Sampled) -> Result<Scheduled, InputError> {
        let samples = in_use(config.sensors, self.samples.select(config.choice));
        self.without = without_counts(&samples);
        if self.without == SensorMask::ALL {
            return Err(InputError::NoSensor);
        }
        self.samples.begin_window();
        let last = self.last_step.replace(sampled.pose);
        let motion = last.map(|last| last.motion_to(&sampled.pose));
        Ok(Scheduled::Step(StepInput {
            stamp_us: sampled.stamp_us,
            pose: sampled.pose,
            motion: motion.unwrap_or_default(),
            samples,
        }))
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
