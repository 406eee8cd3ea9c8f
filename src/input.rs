//! What the core is told: a configuration, readings, odometry, ticks.

use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::geometry::Pose;
use crate::kinematics::WheelSpeeds;
use crate::sensor::{SENSORS, Sample};

/// One input of the node. Variants are appended, never reordered: they go over the wire.
///
/// Stamps are microseconds of the sender's clock. Readings and odometry each carry
/// their own; within a kind they never decrease.
///
/// Any 64-bit number is a legal stamp. Arithmetic on stamps, here and in the harness,
/// saturates: a difference is 0 where the second stamp is the earlier one, and a sum
/// stops at [`u64::MAX`]. Neither wraps and neither panics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input {
    /// Who are you? Answered with a boot event.
    Hello,
    /// Start over with this configuration.
    Configure(Config),
    /// One sample of each sensor.
    Proximity {
        /// When the samples were taken.
        stamp_us: u64,
        /// Samples by sensor index.
        samples: [Sample; SENSORS],
    },
    /// Where the robot's odometry believes it is.
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
    /// Time for a step under [`StepRule::PerTick`](crate::config::StepRule::PerTick).
    Tick {
        /// When.
        stamp_us: u64,
    },
    /// Measure the sensors' offsets anew, with nothing near the robot. The board's to
    /// do: the node takes no notice.
    Calibrate,
    /// Go on with fewer particles for each sensor, until the next configuration: what
    /// a board decides whose steps take too long.
    Limit {
        /// How many; more than are configured changes nothing.
        particles_per_sensor: u16,
    },
}
