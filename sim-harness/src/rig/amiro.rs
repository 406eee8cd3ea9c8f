//! The rig that a filter's configuration describes.

use amiro_ipf::node::Config;

use super::{Rig, SensorMount};
use crate::geometry::{Pose2, Turn, Vector};
use crate::sensors::{Infrared, Sensor};

impl From<&Config> for Rig {
    /// The ring and the law of a configuration, sensors that are masked out included: a
    /// node reports their readings as missing.
    fn from(config: &Config) -> Self {
        let sensor = Infrared::new(config.photometry);
        let mount = |index: usize| {
            let mount = config.ring.mount(index);
            SensorMount {
                name: format!("infrared {index}"),
                body_from_sensor: Pose2 {
                    position: Vector::from(mount.position),
                    heading: Turn::from(mount.direction),
                },
                sensor: Sensor::Infrared(sensor.clone()),
            }
        };
        Self {
            name: "amiro".to_owned(),
            about: "AMiRo: a ring of eight infrared proximity sensors.".to_owned(),
            // The sensors sit on the hull. To the micrometre: the ring is in f32.
            radius_m: (f64::from(config.ring.radius_m) * 1e6).round() / 1e6,
            track_m: Some(f64::from(config.drive.track_m)),
            mounts: (0..config.ring.axis_rad.len()).map(mount).collect(),
        }
    }
}
