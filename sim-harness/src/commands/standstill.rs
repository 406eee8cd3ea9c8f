//! A recording whose odometry does not move, of which no map can be made.

use std::fmt;

use amiro_ipf::config::{Config, StepRule};
use amiro_ipf::input::Input;
use sim_harness::Survey;

/// An odometry that does not move, under a rule that steps by way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Standstill {
    /// Poses of the odometry.
    poses: usize,
    /// Largest distance of a pose from the first, metres.
    within_m: f32,
    /// Way that a step takes, metres.
    step_m: f32,
}

impl Standstill {
    /// Looks whether a run that steps by way did not get beyond its first step, though it
    /// had poses; `None` if it did, or has less than two poses.
    pub(super) fn of(config: &Config, inputs: &[Input], survey: &Survey) -> Option<Self> {
        let StepRule::PerDistance { step_m } = config.step_rule else {
            return None;
        };
        if survey.figures().steps > 1 {
            return None;
        }
        let places = || {
            inputs.iter().filter_map(|input| match input {
                Input::Odometry { pose, .. } => Some(pose.position),
                _ => None,
            })
        };
        let first = places().next()?;
        let poses = places().count();
        let distances = places().map(|place| (place - first).norm());
        (poses > 1).then(|| Self {
            poses,
            within_m: distances.fold(0.0, f32::max),
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
             a robot was put down by hand are judged by `cargo ipf evaluate --recordings \
             FOLDER`; with --fixed, `replay` steps at 8 Hz though the robot stands",
            self.poses,
            1e3 * self.within_m,
            1e3 * self.step_m
        )
    }
}
