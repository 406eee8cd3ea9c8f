//! A robot as data: its size, and the poses of its sensors.

mod amiro;
mod file;

pub use file::RigError;

use amiro_ipf::model::Photometry;

use crate::geometry::Pose2;
use crate::sensors::{Infrared, Sensor};

/// A robot: name, size, and the sensors in the order in which a scan lists them.
///
/// Rigs are TOML files in `rigs/`, described in its `README.md`. Body frame: x forward,
/// y left, angles counter-clockwise; the origin is the point that the poses of a drive
/// describe.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// A short name, without control characters.
    pub name: String,
    /// A description of the robot in one sentence.
    pub about: String,
    /// Radius of the hull around the origin, metres.
    pub radius_m: f64,
    /// Distance between the wheels, metres, where it is known.
    pub track_m: Option<f64>,
    /// The sensors; at least one.
    pub mounts: Vec<SensorMount>,
}

/// One sensor on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorMount {
    /// Name of the sensor, without control characters.
    pub name: String,
    /// Pose of the sensor; its axis is the sensor frame's x.
    pub body_from_sensor: Pose2,
    /// How it measures.
    pub sensor: Sensor,
}

impl Rig {
    /// Of each mount, whether its name begins with one of these; all of them for no name.
    #[must_use]
    pub fn mounts_named(&self, names: &[String]) -> Vec<bool> {
        let is_named = |mount: &SensorMount| names.iter().any(|it| mount.name.starts_with(it));
        let mounts = self.mounts.iter();
        mounts
            .map(|mount| names.is_empty() || is_named(mount))
            .collect()
    }

    /// Sets the gain of the law of all infrared sensors, counts m^2.
    pub fn set_alpha(&mut self, alpha_counts_m2: f32) {
        for mount in &mut self.mounts {
            if let Sensor::Infrared(sensor) = &mount.sensor {
                let photometry = *sensor.photometry();
                mount.sensor = Sensor::Infrared(Infrared::new(Photometry {
                    alpha_counts_m2,
                    ..photometry
                }));
            }
        }
    }
}
