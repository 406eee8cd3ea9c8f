//! A world: its objects, the robot's start, the drive.

use amiro_ipf::model::{Ring, SensorMask};

use super::{Allowance, Leg, Opening, Rectangle, Shape};
use crate::geometry::{Vector, radians};

/// A world and a drive through it; the format is described in `scenarios/README.md`.
///
/// What [`parse`](Self::parse) returns is within all limits: an hour or a kilometre
/// of driving, 10 000 shapes, four million cells. A simulation of any file ends within
/// some minutes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scenario {
    /// A short name.
    pub name: String,
    /// The scenario in a sentence.
    pub about: String,
    /// Side of a map cell, metres.
    pub cell_m: f64,
    /// The map's rectangle; cells outside of it are not judged.
    pub extent: Rectangle,
    /// Linear speed while driving.
    pub speed_m_per_s: f64,
    /// Directions of the sensors in use, degrees; `None` is the AMiRo's ring.
    pub sensors_deg: Option<Vec<f64>>,
    /// The robot's centre at the start.
    pub start: Vector,
    /// The robot's heading at the start, degrees.
    pub start_heading_deg: f64,
    /// The legs of the drive, in order.
    pub drive: Vec<Leg>,
    /// The objects of the world.
    pub shapes: Vec<Shape>,
    /// Passages that a map must leave open.
    pub openings: Vec<Opening>,
    /// Checks of the drive that this scenario fails on purpose.
    pub allow: Vec<Allowance>,
}

impl Scenario {
    /// The ring and the sensors of it that are in use.
    #[must_use]
    pub fn ring(&self) -> (Ring, SensorMask) {
        let Some(angles) = &self.sensors_deg else {
            return (Ring::AMIRO, SensorMask::ALL);
        };
        let mut ring = Ring::AMIRO;
        let mut mask = SensorMask::NONE;
        for (sensor, (axis, angle)) in ring.axis_rad.iter_mut().zip(angles).enumerate() {
            *axis = radians(*angle);
            mask = mask.with(sensor);
        }
        (ring, mask)
    }

    /// How long the drive takes, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let durations = self
            .drive
            .iter()
            .map(|leg| leg.duration_s(self.speed_m_per_s));
        durations.sum()
    }
}
