//! A sensor's place in the world, and what it sees along a ray.

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{Ring, SensorMask};

use super::Shape;
use crate::geometry::{Pose2, Turn, Vector};

/// One sensor's place and direction in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Index on the ring.
    pub sensor: usize,
    /// Where it is.
    pub position: Vector,
    /// Where its axis points.
    pub axis: Turn,
}

impl Eye {
    /// The sensors in use of a robot at the given pose.
    pub fn of(ring: &Ring, used: SensorMask, pose: &Pose) -> impl Iterator<Item = Self> {
        Self::at(ring, used, Pose2::from(*pose))
    }

    /// The sensors in use of a robot at the given pose, in double precision.
    pub fn at(ring: &Ring, used: SensorMask, world_from_body: Pose2) -> impl Iterator<Item = Self> {
        let (ring, body) = (*ring, world_from_body.heading);
        let centre = world_from_body.position;
        used.iter().map(move |sensor| {
            let mount = ring.mount(sensor);
            let axis = Turn {
                sine: f64::from(mount.direction.sine),
                cosine: f64::from(mount.direction.cosine),
            };
            Self {
                sensor,
                position: centre + Vector::from(mount.position).turned(body),
                axis: axis.after(body),
            }
        })
    }
}

/// The first surface on a ray: its distance, and the shape it belongs to.
#[must_use]
pub fn first_surface<'s>(
    shapes: impl IntoIterator<Item = &'s Shape>,
    origin: Vector,
    direction: Vector,
) -> Option<(f64, &'s Shape)> {
    let hits = shapes
        .into_iter()
        .filter_map(|shape| Some((shape.hit_m(origin, direction)?, shape)));
    hits.min_by(|(a, _), (b, _)| a.total_cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::model::SENSORS;

    #[test]
    fn eyes_turn_with_the_robot() {
        let pose = Pose::new(1.0, 2.0, core::f32::consts::FRAC_PI_2);
        let eyes: Vec<_> = Eye::of(&Ring::AMIRO, SensorMask::ALL, &pose).collect();
        assert_eq!(eyes.len(), SENSORS);
        // Sensor 3 looks 22.5 degrees left of forward: here 112.5 degrees.
        let direction = Turn::by_degrees(112.5).direction();
        assert!((eyes[3].axis.direction() - direction).norm() < 1e-6);
        let place = Vector::new(1.0, 2.0) + direction.scaled(0.05);
        assert!((eyes[3].position - place).norm() < 1e-6);
    }
}
