//! What the node takes: a configuration, readings, odometry, ticks.

use super::Config;
use crate::geometry::Pose;
use crate::model::{SENSORS, Sample, WheelSpeeds};

/// One input of the node.
///
/// Stamps are microseconds of the sender's clock. Readings and odometry each have
/// their own; within a kind they never decrease.
///
/// Any 64-bit number is a legal stamp. Arithmetic on stamps, here and in the harness,
/// saturates: a difference is 0 where the second stamp is the earlier one, and a sum
/// stops at [`u64::MAX`]. It neither wraps nor panics.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input {
    /// Starts a run with this configuration.
    Configure(Config),
    /// One sample of each sensor.
    Proximity {
        /// When the samples were taken.
        stamp_us: u64,
        /// Samples by sensor index.
        samples: [Sample; SENSORS],
    },
    /// The robot's pose by its odometry.
    Odometry {
        /// When it was there.
        stamp_us: u64,
        /// World frame, metres and radians.
        pose: Pose,
    },
    /// How fast the wheels turn from now on; an alternative to poses.
    Wheels {
        /// Since when.
        stamp_us: u64,
        /// Speeds over ground.
        speeds: WheelSpeeds,
    },
    /// Time for a step under [`StepRule::PerTick`](super::StepRule::PerTick).
    Tick {
        /// When.
        stamp_us: u64,
    },
    /// Lowers the number of particles per sensor until the next configuration. A board
    /// sends it to its node when steps take too long.
    Limit {
        /// The new number; a number above the configured one changes nothing.
        particles_per_sensor: u16,
    },
}
