//! One row of a drive.

use std::ops::Range;

use crate::geometry::Pose2;

/// One row of a drive, in SI units; stamps are microseconds from the drive's first row.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// Where the robot is, by the pose source that was asked for.
    Pose {
        /// When, microseconds.
        stamp_us: u64,
        /// The robot's origin in the world.
        world_from_body: Pose2,
    },
    /// What sensors returned at one instant.
    Scan(Scan),
}

/// Returns of neighbouring mounts at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// When, microseconds.
    pub stamp_us: u64,
    /// The robot's origin in the world at that time.
    pub world_from_body: Pose2,
    /// The mounts of the rig, by index; each has [`Sensor::returns`] returns.
    ///
    /// [`Sensor::returns`]: crate::rig::Sensor::returns
    pub mounts: Range<usize>,
    /// The returns, mount by mount.
    pub returns: Vec<Return>,
}

/// What a sensor returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Return {
    /// The nearest surface.
    Echo {
        /// Its range on the axis, metres, positive and finite.
        range_m: f64,
        /// Standard deviation of the range, metres, not negative.
        sigma_m: f64,
    },
    /// No surface up to a limit.
    NoEcho {
        /// The limit, metres.
        limit_m: f64,
    },
    /// A surface nearer than the sensor can measure.
    TooClose,
    /// No measurement.
    Invalid,
}
