//! Points, angles, poses and rigid motions in the plane.
//!
//! Metres and radians; x forward, y left, counter-clockwise positive (ROS REP 103).
//! A [`Pose`] places the robot's body in the world; a [`Motion`] is the body's
//! displacement seen from where it started.

use serde::{Deserialize, Serialize};

use crate::math;

/// A point, or the vector to it, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Point {
    /// Forward in a body frame, east in a world frame; metres.
    pub x: f32,
    /// Left in a body frame, north in a world frame; metres.
    pub y: f32,
}

impl Point {
    /// The point at the given coordinates, metres.
    #[must_use]
    pub const fn new(x: f32, y: f32) -> Self {
        Self { x, y }
    }

    /// The scalar product.
    #[must_use]
    #[inline]
    pub fn dot(self, other: Self) -> f32 {
        self.x * other.x + self.y * other.y
    }

    /// Squared distance from the origin, square metres.
    #[must_use]
    #[inline]
    pub fn norm_squared(self) -> f32 {
        self.x * self.x + self.y * self.y
    }

    /// Distance from the origin, metres.
    #[must_use]
    #[inline]
    pub fn norm(self) -> f32 {
        math::sqrt(self.norm_squared())
    }

    /// The point turned counter-clockwise about the origin by the angle of `turn`.
    #[must_use]
    #[inline]
    pub fn rotated(self, turn: Rotation) -> Self {
        Self::new(
            turn.cosine * self.x - turn.sine * self.y,
            turn.sine * self.x + turn.cosine * self.y,
        )
    }
}

impl core::ops::Add for Point {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl core::ops::Sub for Point {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

/// An angle in radians that is always in (-pi, pi], or NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(from = "f32", into = "f32")]
pub struct Angle(f32);

impl Angle {
    /// Wraps any finite number of radians; NaN and infinities become NaN, which
    /// [`Pose::is_finite`] detects.
    #[must_use]
    pub fn from_radians(radians: f32) -> Self {
        Self(math::wrap_angle(radians))
    }

    /// The angle in radians, in (-pi, pi].
    #[must_use]
    #[inline]
    pub const fn radians(self) -> f32 {
        self.0
    }
}

impl From<f32> for Angle {
    fn from(radians: f32) -> Self {
        Self::from_radians(radians)
    }
}

impl From<Angle> for f32 {
    fn from(angle: Angle) -> Self {
        angle.0
    }
}

/// Sine and cosine of an angle: what turning many points needs, computed once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Sine of the angle.
    pub sine: f32,
    /// Cosine of the angle.
    pub cosine: f32,
}

impl Rotation {
    /// The rotation by an angle in radians, counter-clockwise.
    #[must_use]
    #[inline]
    pub fn by(radians: f32) -> Self {
        let (sine, cosine) = math::sin_cos(radians);
        Self { sine, cosine }
    }

    /// The rotation that undoes this one.
    #[must_use]
    #[inline]
    pub fn inverse(self) -> Self {
        Self {
            sine: -self.sine,
            cosine: self.cosine,
        }
    }
}

/// Where the robot's body is in the world: `world_from_body`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// The robot's centre in the world, metres.
    pub position: Point,
    /// Direction of the body's x axis in the world.
    pub heading: Angle,
}

impl Pose {
    /// A pose from metres and radians; the heading is wrapped.
    #[must_use]
    pub fn new(x: f32, y: f32, heading: f32) -> Self {
        Self {
            position: Point::new(x, y),
            heading: Angle::from_radians(heading),
        }
    }

    /// Whether every coordinate is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position.x.is_finite() && self.position.y.is_finite() && self.heading.0.is_finite()
    }

    /// The motion that takes this pose to `later`, in this pose's body frame.
    #[must_use]
    pub fn motion_to(&self, later: &Self) -> Motion {
        let world = later.position - self.position;
        Motion {
            displacement: world.rotated(Rotation::by(self.heading.0).inverse()),
            turn: Angle::from_radians(later.heading.0 - self.heading.0),
        }
    }

    /// The pose after `motion`.
    #[must_use]
    pub fn moved(&self, motion: &Motion) -> Self {
        Self {
            position: self.position + motion.displacement.rotated(Rotation::by(self.heading.0)),
            heading: Angle::from_radians(self.heading.0 + motion.turn.0),
        }
    }

    /// A point of the body frame in world coordinates.
    #[must_use]
    pub fn world_from_body(&self, body: Point) -> Point {
        self.position + body.rotated(Rotation::by(self.heading.0))
    }
}

/// A rigid displacement of the body, in the body frame it starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Where the body's centre goes, metres.
    pub displacement: Point,
    /// How far the body turns, at most half a turn.
    pub turn: Angle,
}

impl Motion {
    /// No motion at all.
    pub const NONE: Self = Self {
        displacement: Point::new(0.0, 0.0),
        turn: Angle(0.0),
    };

    /// The share `fraction` of this motion at constant wheel speeds.
    ///
    /// The body follows the arc that joins both ends; 0 gives no motion, 1 this
    /// motion, 1.5 continues the arc for half as long again. Fractions beyond the
    /// arc's half turn are meaningless and must not be asked for.
    #[must_use]
    pub fn fraction(&self, fraction: f32) -> Self {
        let half_turn = 0.5 * self.turn.0;
        // A chord of an arc has the length 2 R sin(turn / 2) and the direction
        // turn / 2; below 1e-3 rad the sines' ratio is the fraction itself to 2e-7.
        let ratio = if half_turn.abs() < 1e-3 {
            fraction
        } else {
            math::sin_cos(fraction * half_turn).0 / math::sin_cos(half_turn).0
        };
        let chord = self
            .displacement
            .rotated(Rotation::by((fraction - 1.0) * half_turn));
        Self {
            displacement: Point::new(ratio * chord.x, ratio * chord.y),
            turn: Angle::from_radians(fraction * self.turn.0),
        }
    }

    /// Length of the arc along which the body's centre moved, signed by direction, metres.
    ///
    /// Positive forward, negative backward: the sideways component, which a
    /// differential drive does not have, counts for nothing.
    #[must_use]
    pub fn travel(&self) -> f32 {
        let half_turn = 0.5 * self.turn.0;
        let chord = self
            .displacement
            .rotated(Rotation::by(half_turn).inverse())
            .x;
        if half_turn.abs() < 1e-3 {
            chord
        } else {
            chord * half_turn / math::sin_cos(half_turn).0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

    fn close(a: Point, b: Point) {
        let error = (a - b).norm();
        assert!(error < 1e-6, "{a:?} is not {b:?}");
    }

    #[test]
    fn motion_between_poses_takes_the_first_to_the_second() {
        let start = Pose::new(2.0, -1.0, 2.5);
        let end = Pose::new(1.2, 0.3, -2.9);
        let arrived = start.moved(&start.motion_to(&end));
        close(arrived.position, end.position);
        assert!((arrived.heading.radians() - end.heading.radians()).abs() < 1e-6);
    }

    #[test]
    fn angles_wrap_at_half_a_turn() {
        assert!((Angle::from_radians(PI + 0.1).radians() - (0.1 - PI)).abs() < 1e-6);
        assert!((Angle::from_radians(-PI - 0.1).radians() - (PI - 0.1)).abs() < 1e-6);
    }

    #[test]
    fn a_pose_with_any_bad_number_is_not_finite() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(!Pose::new(bad, 0.0, 0.0).is_finite(), "{bad}");
            assert!(!Pose::new(0.0, bad, 0.0).is_finite(), "{bad}");
            assert!(!Pose::new(0.0, 0.0, bad).is_finite(), "{bad}");
        }
        assert!(Pose::new(1e6, -3.0, 1e4).is_finite());
    }

    #[test]
    fn heading_survives_a_million_turns() {
        let quarter = Motion {
            displacement: Point::default(),
            turn: Angle::from_radians(FRAC_PI_2),
        };
        let mut pose = Pose::default();
        for _ in 0..4_000_000_u32 {
            pose = pose.moved(&quarter);
        }
        assert!(pose.heading.radians().abs() < 1e-4, "{:?}", pose.heading);
    }

    #[test]
    fn half_a_quarter_circle_is_an_eighth() {
        // Radius 1: a quarter circle to the left ends at (1, 1).
        let quarter = Motion {
            displacement: Point::new(1.0, 1.0),
            turn: Angle::from_radians(FRAC_PI_2),
        };
        let eighth = quarter.fraction(0.5);
        close(
            eighth.displacement,
            Point::new(FRAC_1_SQRT_2, 1.0 - FRAC_1_SQRT_2),
        );
        assert!((quarter.travel() - FRAC_PI_2).abs() < 1e-6);
        assert!((eighth.travel() - 0.5 * FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn backward_travel_is_negative() {
        let back = Motion {
            displacement: Point::new(-0.01, 0.0),
            turn: Angle::from_radians(0.0),
        };
        assert!((back.travel() + 0.01).abs() < 1e-9);
        close(back.fraction(0.25).displacement, Point::new(-0.0025, 0.0));
    }
}
