//! Why a recording has no steps, so that no map can be made of it.

use std::fmt;

use amiro_ipf::geometry::Point;
use amiro_ipf::node::{Config, Input, InputError, StepRule};

/// Why the inputs of a recording lead to no step.
#[derive(Clone, Debug, PartialEq)]
pub enum NoSteps {
    /// There is neither odometry nor a reading.
    NoInputs,
    /// There is no odometry: no pose and no speed of the wheels.
    NoOdometry {
        /// How many readings there are.
        readings: usize,
    },
    /// There is no reading.
    NoReadings {
        /// Poses of the odometry, or speeds of the wheels.
        poses: usize,
    },
    /// There is no tick, under a rule that steps per tick.
    NoTicks,
    /// The odometry does not move, under a rule that steps by way.
    Standstill {
        /// Poses of the odometry, or speeds of the wheels.
        poses: usize,
        /// Largest distance of a pose from the first, metres.
        within_m: f32,
        /// Way that a step takes, metres.
        step_m: f32,
    },
    /// Inputs were refused, and what is left leads to no step.
    Refused(Vec<(InputError, u64)>),
}

/// Looks at a run's inputs one after another.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputCheck {
    poses: usize,
    readings: usize,
    ticks: usize,
    first: Option<Point>,
    within_m: f32,
    is_turning: bool,
}

impl InputCheck {
    /// Takes the next input.
    pub fn take(&mut self, input: &Input) {
        match input {
            Input::Odometry { pose, .. } => {
                let first = *self.first.get_or_insert(pose.position);
                self.within_m = self.within_m.max((pose.position - first).norm());
                self.poses += 1;
            }
            Input::Wheels { speeds, .. } => {
                self.is_turning |=
                    speeds.left_m_per_s.abs() > 0.0 || speeds.right_m_per_s.abs() > 0.0;
                self.poses += 1;
            }
            Input::Proximity { .. } => self.readings += 1,
            Input::Tick { .. } => self.ticks += 1,
            Input::Configure(_) | Input::Limit { .. } => {}
        }
    }

    /// Readings so far.
    #[must_use]
    pub fn readings(&self) -> usize {
        self.readings
    }

    /// Why a run of so many steps has none, or none but the one at its first reading.
    ///
    /// `faults` are the inputs that were refused. `None` for a run that has steps.
    #[must_use]
    pub fn finish(
        &self,
        config: &Config,
        steps: u64,
        faults: impl Iterator<Item = (InputError, u64)>,
    ) -> Option<NoSteps> {
        let standstill = self.standstill(config);
        if steps > 0 {
            return standstill.filter(|_| steps == 1);
        }
        let is_per_tick = matches!(config.step_rule, StepRule::PerTick { .. });
        Some(match (self.poses, self.readings) {
            (0, 0) => NoSteps::NoInputs,
            (0, readings) => NoSteps::NoOdometry { readings },
            (poses, 0) => standstill.unwrap_or(NoSteps::NoReadings { poses }),
            _ if is_per_tick && self.ticks == 0 => NoSteps::NoTicks,
            _ => standstill.unwrap_or_else(|| NoSteps::Refused(faults.collect())),
        })
    }

    /// Whether the poses of a run that steps by way stay within a step of the first; `None`
    /// if not, or for less than two poses.
    fn standstill(&self, config: &Config) -> Option<NoSteps> {
        let StepRule::PerDistance { step_m } = config.step_rule else {
            return None;
        };
        let is_standing = self.poses > 1 && self.within_m < step_m && !self.is_turning;
        is_standing.then_some(NoSteps::Standstill {
            poses: self.poses,
            within_m: self.within_m,
            step_m,
        })
    }
}

impl fmt::Display for NoSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoInputs => f.write_str("no step: there is neither odometry nor a reading"),
            Self::NoOdometry { readings } => {
                write!(f, "no step: there are {readings} readings and no odometry")
            }
            Self::NoReadings { poses } => write!(
                f,
                "no step: there are {poses} poses or wheel speeds and no reading"
            ),
            Self::NoTicks => f.write_str(
                "no step: the filter steps per tick, and there is no tick; with --fixed, \
                 `replay` makes ticks at 8 Hz",
            ),
            Self::Standstill {
                poses,
                within_m,
                step_m,
            } => write!(
                f,
                "the odometry does not move: its {poses} poses lie within {:.1} mm of the first, and the \
                 filter steps every {:.0} mm; there is no map to make. Series of stations at which \
                 a robot was put down by hand are judged by `evaluate --recordings`; with --fixed, `replay` steps at 8 Hz though the robot stands",
                1e3 * within_m,
                1e3 * step_m
            ),
            Self::Refused(faults) => {
                f.write_str("no step: no reading is left that a step could use")?;
                for (fault, count) in faults {
                    write!(f, "; {count} inputs refused: {fault:?}, {fault}")?;
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::iter;

    use super::*;
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::{SENSORS, Sample, WheelSpeeds};

    fn of(inputs: &[Input]) -> Option<NoSteps> {
        let mut check = InputCheck::default();
        inputs.iter().for_each(|input| check.take(input));
        check.finish(&Config::default(), 0, iter::empty())
    }

    const READING: Input = Input::Proximity {
        stamp_us: 0,
        samples: [Sample::Counts(0); SENSORS],
    };

    fn pose(x: f32) -> Input {
        Input::Odometry {
            stamp_us: 0,
            pose: Pose::new(x, 0.0, 0.0),
        }
    }

    #[test]
    fn poses_and_wheels_that_stand_are_a_standstill_and_turning_wheels_are_none() {
        let wheels = |left_m_per_s: f32| Input::Wheels {
            stamp_us: 0,
            speeds: WheelSpeeds {
                left_m_per_s,
                right_m_per_s: 0.0,
            },
        };
        let standing = of(&[pose(2.0), pose(2.001), pose(1.999)]);
        let Some(NoSteps::Standstill {
            poses, within_m, ..
        }) = standing
        else {
            panic!("{standing:?}");
        };
        assert_eq!(poses, 3);
        assert!((within_m - 0.001).abs() < 1e-6);
        let standing = of(&[wheels(0.0), wheels(0.0)]);
        assert!(matches!(standing, Some(NoSteps::Standstill { .. })));
        let turning = of(&[wheels(0.0), wheels(0.1)]);
        assert_eq!(turning, Some(NoSteps::NoReadings { poses: 2 }));
    }

    #[test]
    fn what_is_missing_for_a_step_is_named() {
        assert_eq!(of(&[]), Some(NoSteps::NoInputs));
        let readings = 2;
        assert_eq!(of(&[READING; 2]), Some(NoSteps::NoOdometry { readings }));
        // One pose moves nowhere, and these do.
        assert_eq!(of(&[pose(0.0)]), Some(NoSteps::NoReadings { poses: 1 }));
        let moving = [pose(0.0), pose(0.3)];
        assert_eq!(of(&moving), Some(NoSteps::NoReadings { poses: 2 }));
        let [first, second] = moving;
        let refused = of(&[READING, first, second]);
        assert_eq!(refused, Some(NoSteps::Refused(Vec::new())));
        let mut check = InputCheck::default();
        [first, second, READING]
            .iter()
            .for_each(|input| check.take(input));
        let per_tick = Config {
            step_rule: StepRule::PerTick { own_clock: false },
            ..Config::default()
        };
        let reason = check.finish(&per_tick, 0, iter::empty());
        assert_eq!(reason, Some(NoSteps::NoTicks));
        assert_eq!(check.finish(&Config::default(), 1, iter::empty()), None);
    }
}
