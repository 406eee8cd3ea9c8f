//! A recording whose odometry does not move, of which no map can be made.

use std::fmt;

use amiro_ipf::geometry::Point;
use amiro_ipf::node::{Config, Input, StepRule};
use sim_harness::Survey;

/// An odometry that does not move, under a rule that steps by way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Standstill {
    /// Poses of the odometry, or speeds of the wheels.
    poses: usize,
    /// Largest distance of a pose from the first, metres.
    within_m: f32,
    /// Way that a step takes, metres.
    step_m: f32,
}

/// Looks at a run's inputs one after another.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StandstillCheck {
    poses: usize,
    first: Option<Point>,
    within_m: f32,
    is_turning: bool,
}

impl StandstillCheck {
    /// Takes the next input.
    pub(super) fn take(&mut self, input: &Input) {
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
            _ => {}
        }
    }

    /// Whether a run that steps by way did not get beyond its first step because its poses
    /// stay within a step of the first; `None` if not, or for less than two poses.
    pub(super) fn finish(&self, config: &Config, survey: &Survey) -> Option<Standstill> {
        let StepRule::PerDistance { step_m } = config.step_rule else {
            return None;
        };
        if self.is_turning || survey.figures().steps > 1 {
            return None;
        }
        (self.poses > 1 && self.within_m < step_m).then_some(Standstill {
            poses: self.poses,
            within_m: self.within_m,
            step_m,
        })
    }
}

impl fmt::Display for Standstill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the odometry does not move: its {} poses lie within {:.1} mm of the first, and the \
             filter steps every {:.0} mm; there is no map to make. Series of stations at which \
             a robot was put down by hand are judged by `evaluate --recordings`; with --fixed, `replay` steps at 8 Hz though the robot stands",
            self.poses,
            1e3 * self.within_m,
            1e3 * self.step_m
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::WheelSpeeds;

    fn of(inputs: &[Input]) -> Option<Standstill> {
        let mut check = StandstillCheck::default();
        inputs.iter().for_each(|input| check.take(input));
        let config = Config::default();
        check.finish(&config, &Survey::new(&config, 0.01, None))
    }

    #[test]
    fn poses_and_wheels_that_stand_are_a_standstill_and_turning_wheels_are_none() {
        let pose = |x: f32| Input::Odometry {
            stamp_us: 0,
            pose: Pose::new(x, 0.0, 0.0),
        };
        let wheels = |left_m_per_s: f32| Input::Wheels {
            stamp_us: 0,
            speeds: WheelSpeeds {
                left_m_per_s,
                right_m_per_s: 0.0,
            },
        };
        let standing = of(&[pose(2.0), pose(2.001), pose(1.999)]).unwrap();
        assert_eq!(standing.poses, 3);
        assert!((standing.within_m - 0.001).abs() < 1e-6);
        assert!(of(&[wheels(0.0), wheels(0.0)]).is_some());
        assert_eq!(of(&[wheels(0.0), wheels(0.1)]), None);
        // Here the readings are missing, not the way.
        assert_eq!(of(&[pose(0.0), pose(0.3)]), None);
        assert_eq!(of(&[pose(0.0)]), None, "one pose moves nowhere");
        assert_eq!(of(&[]), None);
    }
}
