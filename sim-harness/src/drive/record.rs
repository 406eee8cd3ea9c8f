//! One row of a drive.

use std::ops::Range;

use crate::geometry::{Pose2, Vector};

/// One row of a drive, in SI units; stamps are microseconds that never decrease, from the
/// drive's first row or as the robot counts.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// The robot's pose, by the selected pose source.
    Pose {
        /// When, microseconds.
        stamp_us: u64,
        /// The robot's origin in the world.
        world_from_body: Pose2,
    },
    /// The odometry was reset: the robot did not drive from the pose before to the next.
    OdometryReset {
        /// When, microseconds.
        stamp_us: u64,
    },
    /// The returns of sensors at one instant.
    Scan(RangeScan),
    /// The outcomes of an inverse particle filter, on a board or on the host.
    Outcomes(Vec<PointOutcome>),
}

impl Record {
    /// The pose, if the record is one.
    #[must_use]
    pub fn pose(&self) -> Option<Pose2> {
        match self {
            Self::Pose {
                world_from_body, ..
            } => Some(*world_from_body),
            Self::OdometryReset { .. } | Self::Scan(_) | Self::Outcomes(_) => None,
        }
    }
}

/// Returns of neighbouring mounts at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeScan {
    /// When, microseconds.
    pub stamp_us: u64,
    /// The robot's origin in the world at that time.
    pub world_from_body: Pose2,
    /// The mounts of the rig, by index; each has as many returns as its sensor's
    /// [`returns`](crate::sensors::RangeSensor::returns).
    pub mounts: Range<usize>,
    /// The returns, mount by mount.
    pub returns: Vec<Return>,
    /// What proximity sensors measured before it became a range: counts above the
    /// sensor's dark value (s - beta), one per return; `None` for a sample that is missing
    /// or saturated. Empty for sensors that measure ranges.
    pub signals: Vec<Option<f64>>,
}

/// One return of a sensor.
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
        /// The limit on the axis, metres.
        limit_m: f64,
        /// Standard deviation of the limit, metres, not negative.
        sigma_m: f64,
    },
    /// A surface nearer than the sensor can measure.
    TooClose,
    /// No measurement.
    Invalid,
}

/// A place at which an inverse particle filter found a surface, or found none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointOutcome {
    /// Where, metres in the world.
    pub place: Vector,
    /// Whether a surface was found there.
    pub is_occupied: bool,
}
