//! Vectors, turns and poses of the plane in double precision, for the world around the robot.
//!
//! Only sums, products, quotients and square roots, which round alike everywhere, the
//! core's sine and cosine, and those of the crate `libm`: the same file and seed give the
//! same world on every machine.

use amiro_ipf::geometry::{Point, Pose, Rotation};

/// A position in the world, or a displacement, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
}

impl Vector {
    /// The vector with the given coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The vector `factor` times as long.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(factor * self.x, factor * self.y)
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Cross product: positive when `other` points to the left of this vector.
    #[must_use]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Length.
    #[must_use]
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Distance of this position from the segment between two others.
    #[must_use]
    pub fn distance_from_segment(self, from: Self, to: Self) -> f64 {
        let way = to - from;
        let squared = way.dot(way);
        let share = if squared > 0.0 {
            ((self - from).dot(way) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (self - from - way.scaled(share)).norm()
    }

    /// The vector turned counter-clockwise.
    #[must_use]
    pub fn turned(self, turn: Turn) -> Self {
        Self::new(
            turn.cosine * self.x - turn.sine * self.y,
            turn.sine * self.x + turn.cosine * self.y,
        )
    }
}

impl From<Point> for Vector {
    fn from(point: Point) -> Self {
        Self::new(f64::from(point.x), f64::from(point.y))
    }
}

impl core::ops::Add for Vector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl core::ops::Sub for Vector {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

/// Sine and cosine of an angle, from the core's own functions: within 3e-7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Sine of the angle.
    pub sine: f64,
    /// Cosine of the angle.
    pub cosine: f64,
}

impl Turn {
    /// The turn by an angle in radians.
    #[must_use]
    pub fn by_radians(radians: f32) -> Self {
        Self::from(Rotation::by(radians))
    }

    /// The turn by an angle in radians, in double precision.
    #[must_use]
    pub fn by_radians_f64(radians: f64) -> Self {
        let (sine, cosine) = libm::sincos(radians);
        Self { sine, cosine }
    }

    /// The turn by an angle in degrees, whole turns taken off first.
    #[must_use]
    pub fn by_degrees(degrees: f64) -> Self {
        Self::by_radians(radians(degrees))
    }

    /// The turn that undoes this one.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            sine: -self.sine,
            ..self
        }
    }

    /// This turn after `first`.
    #[must_use]
    pub fn after(self, first: Self) -> Self {
        Self {
            sine: self.sine * first.cosine + self.cosine * first.sine,
            cosine: self.cosine * first.cosine - self.sine * first.sine,
        }
    }

    /// The unit vector in this direction.
    #[must_use]
    pub const fn direction(self) -> Vector {
        Vector::new(self.cosine, self.sine)
    }
}

impl From<Rotation> for Turn {
    fn from(Rotation { sine, cosine }: Rotation) -> Self {
        Self {
            sine: f64::from(sine),
            cosine: f64::from(cosine),
        }
    }
}

/// A position and a heading: the pose of one frame in another.
///
/// Named by its two frames: `world_from_body * body_from_sensor` is `world_from_sensor`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose2 {
    /// Origin of the inner frame in the outer one, metres.
    pub position: Vector,
    /// Direction of the inner frame's x axis in the outer one.
    pub heading: Turn,
}

impl Pose2 {
    /// The pose at a place, metres, with a heading in radians, counter-clockwise.
    #[must_use]
    pub fn new(x: f64, y: f64, heading_rad: f64) -> Self {
        Self {
            position: Vector::new(x, y),
            heading: Turn::by_radians_f64(heading_rad),
        }
    }

    /// A point of the inner frame in the outer one.
    #[must_use]
    pub fn place(&self, point: Vector) -> Vector {
        self.position + point.turned(self.heading)
    }

    /// A point of the outer frame in the inner one.
    #[must_use]
    pub fn view(&self, point: Vector) -> Vector {
        (point - self.position).turned(self.heading.inverse())
    }

    /// The heading, radians in (-pi, pi].
    #[must_use]
    pub fn heading_rad(&self) -> f64 {
        libm::atan2(self.heading.sine, self.heading.cosine)
    }

    /// Angle between the two headings, radians in [0, pi].
    #[must_use]
    pub fn turn_to(&self, other: &Self) -> f64 {
        let turn = other.heading.after(self.heading.inverse());
        libm::atan2(turn.sine.abs(), turn.cosine)
    }

    /// Whether all four numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let Turn { sine, cosine } = self.heading;
        [self.position.x, self.position.y, sine, cosine]
            .iter()
            .all(|number| number.is_finite())
    }
}

impl From<Pose> for Pose2 {
    fn from(pose: Pose) -> Self {
        Self {
            position: Vector::from(pose.position),
            heading: Turn::by_radians(pose.heading.radians()),
        }
    }
}

impl core::ops::Mul for Pose2 {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self {
            position: self.place(inner.position),
            heading: inner.heading.after(self.heading),
        }
    }
}

/// A rectangle with sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub min: Vector,
    /// Upper right corner.
    pub max: Vector,
}

impl Rectangle {
    /// Whether a place lies inside or on the edge.
    #[must_use]
    pub fn contains(&self, place: Vector) -> bool {
        (self.min.x..=self.max.x).contains(&place.x) && (self.min.y..=self.max.y).contains(&place.y)
    }
}

/// Degrees as radians in (-2 pi, 2 pi), in the core's precision.
#[must_use]
pub(crate) fn radians(degrees: f64) -> f32 {
    ((degrees % 360.0) * (core::f64::consts::PI / 180.0)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_turn_is_exact_and_whole_turns_do_not_count() {
        let place = Vector::new(0.3, -0.7);
        assert_eq!(place.turned(Turn::by_degrees(0.0)), place);
        assert_eq!(Turn::by_degrees(3630.0), Turn::by_degrees(30.0));
    }

    #[test]
    fn poses_chain_and_views_undo_places() {
        let world_from_body = Pose2::new(1.0, 2.0, core::f64::consts::FRAC_PI_2);
        let body_from_sensor = Pose2::new(0.1, 0.0, core::f64::consts::FRAC_PI_2);
        let world_from_sensor = world_from_body * body_from_sensor;
        let expected = Pose2::new(1.0, 2.1, core::f64::consts::PI);
        assert!((world_from_sensor.position - expected.position).norm() < 1e-12);
        assert!(world_from_sensor.turn_to(&expected) < 1e-12);
        let point = Vector::new(-0.3, 0.7);
        let back = world_from_sensor.view(world_from_sensor.place(point));
        assert!((back - point).norm() < 1e-12);
        assert!(
            (world_from_body.turn_to(&world_from_sensor) - core::f64::consts::FRAC_PI_2).abs()
                < 1e-12
        );
        assert!(world_from_body.is_finite() && !Pose2::new(f64::NAN, 0.0, 0.0).is_finite());
    }

    #[test]
    fn turns_add_and_undo_each_other() {
        let place = Vector::new(1.0, 2.0);
        let turn = Turn::by_degrees(25.0).after(Turn::by_degrees(40.0));
        let there = place.turned(turn);
        let expected = place.turned(Turn::by_degrees(65.0));
        assert!((there - expected).norm() < 1e-6);
        assert!((there.turned(turn.inverse()) - place).norm() < 1e-6);
        assert!(place.cross(place.turned(Turn::by_degrees(1.0))) > 0.0);
    }
}
