//! The ring: position and direction of each proximity sensor on the body.

use core::f32::consts::FRAC_PI_8;

use serde::{Deserialize, Serialize};

use crate::geometry::{Point, Rotation};

/// Number of sensors on the ring.
pub const SENSORS: usize = 8;

/// Where each sensor sits and looks: on a circle about the body's centre, outward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ring {
    /// Distance of every sensor from the body's centre, metres.
    pub radius_m: f32,
    /// Direction of each sensor's axis in the body frame, radians, by sensor index.
    pub axis_rad: [f32; SENSORS],
}

impl Ring {
    /// The AMiRo's ring: 157.5 - 45 i degrees for sensor i, at 50 mm.
    ///
    /// The index runs clockwise seen from above, from back left; no sensor looks
    /// straight ahead. From the group's public headers and robot model.
    pub const AMIRO: Self = Self {
        radius_m: 0.05,
        axis_rad: [
            7.0 * FRAC_PI_8,
            5.0 * FRAC_PI_8,
            3.0 * FRAC_PI_8,
            FRAC_PI_8,
            -FRAC_PI_8,
            -3.0 * FRAC_PI_8,
            -5.0 * FRAC_PI_8,
            -7.0 * FRAC_PI_8,
        ],
    };

    /// The mount of sensor `index`; an index beyond the ring gives that of sensor 0.
    #[must_use]
    pub fn mount(&self, index: usize) -> Mount {
        let axis = self
            .axis_rad
            .get(index)
            .copied()
            .unwrap_or(self.axis_rad[0]);
        let direction = Rotation::by(axis);
        Mount {
            position: Point::new(
                self.radius_m * direction.cosine,
                self.radius_m * direction.sine,
            ),
            direction,
        }
    }
}

/// One sensor's place on the body, with its axis prepared for turning points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// Position in the body frame, metres.
    pub position: Point,
    /// Direction of the axis in the body frame.
    pub direction: Rotation,
}

impl Mount {
    /// A point of the body frame in this sensor's frame: x along the axis, y to its left.
    #[must_use]
    #[inline]
    pub fn sensor_from_body(&self, body: Point) -> Point {
        (body - self.position).rotated(self.direction.inverse())
    }

    /// A point of this sensor's frame in the body frame.
    #[must_use]
    #[inline]
    pub fn body_from_sensor(&self, sensor: Point) -> Point {
        self.position + sensor.rotated(self.direction)
    }
}

/// A set of sensors of the ring, one bit each; sensor 0 is the lowest bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorMask(pub u8);

/// The sensors of these indices; those beyond the ring are left out.
impl FromIterator<usize> for SensorMask {
    fn from_iter<I: IntoIterator<Item = usize>>(indices: I) -> Self {
        indices.into_iter().fold(Self::NONE, Self::with)
    }
}

impl SensorMask {
    /// No sensor.
    pub const NONE: Self = Self(0);
    /// The whole ring.
    pub const ALL: Self = Self(0xff);

    /// Whether the set holds sensor `index`.
    #[must_use]
    #[inline]
    pub const fn contains(self, index: usize) -> bool {
        index < SENSORS && self.0 & (1 << index) != 0
    }

    /// The set with sensor `index` added; an index beyond the ring changes nothing.
    #[must_use]
    pub const fn with(self, index: usize) -> Self {
        if index < SENSORS {
            Self(self.0 | 1 << index)
        } else {
            self
        }
    }

    /// The sensors that are not in this set.
    #[must_use]
    pub const fn complement(self) -> Self {
        Self(!self.0)
    }

    /// How many sensors the set holds.
    #[must_use]
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The indices in the set, ascending.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let index = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            (index < SENSORS).then_some(index)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amiro_axes_run_clockwise_from_back_left() {
        for (index, axis) in Ring::AMIRO.axis_rad.iter().enumerate() {
            let expected = (157.5 - 45.0 * index as f32).to_radians();
            assert!((axis - expected).abs() < 1e-6, "sensor {index}");
        }
    }

    #[test]
    fn mounts_match_the_drawing() {
        // Sensor 3, front left: +46.2 mm, +19.1 mm.
        let mount = Ring::AMIRO.mount(3);
        assert!((mount.position.x - 0.0462).abs() < 5e-5);
        assert!((mount.position.y - 0.0191).abs() < 5e-5);
    }

    #[test]
    fn a_point_on_the_axis_has_no_sideways_part_and_returns() {
        for index in 0..SENSORS {
            let mount = Ring::AMIRO.mount(index);
            let body = mount.body_from_sensor(Point::new(0.1, 0.0));
            assert!((body.norm() - 0.15).abs() < 1e-6, "sensor {index}");
            let back = mount.sensor_from_body(body);
            assert!(
                (back - Point::new(0.1, 0.0)).norm() < 1e-6,
                "sensor {index}"
            );
        }
    }

    #[test]
    fn a_mask_lists_what_was_put_in() {
        let mask = SensorMask::NONE.with(3).with(4).with(99);
        assert_eq!(mask.len(), 2);
        assert!(mask.iter().eq([3, 4]));
        assert!(!mask.complement().contains(3) && mask.complement().contains(0));
        assert!(SensorMask::NONE.is_empty());
    }
}
