//! The inverse kinematic model: how a wall moves, seen from a differential drive.
//!
//! Paper section 4.4. For wheel speeds v_l, v_r and track b the body moves with
//! v = (v_l + v_r) / 2 and omega = (v_r - v_l) / b, counter-clockwise positive; a
//! point that is fixed in the world moves past the body with
//! (-v + omega y, -omega x).
//!
//! **Two misprints are corrected here.** Equation 6 prints omega = (v_l - v_r) / b,
//! which is clockwise-positive and contradicts the AMiRo's own firmware.
//! Equation 7 as printed is no rigid motion in any axis convention: its two
//! rotation terms have equal signs and shear the particle set. Tests below fail for
//! both printed forms. Equation 8's Euler step is replaced by the exact motion,
//! because Euler inflates radii by sqrt(1 + turn^2) per step.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::geometry::{Angle, Motion, Point, Rotation};
use crate::math;

/// Speeds of the two wheels over ground, metres a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelSpeeds {
    /// Left wheel, v_l.
    pub left_m_per_s: f32,
    /// Right wheel, v_r.
    pub right_m_per_s: f32,
}

/// Distance each wheel has rolled over ground, metres; backward is negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTravel {
    /// Left wheel.
    pub left_m: f32,
    /// Right wheel.
    pub right_m: f32,
}

/// Wheel geometry of a differential drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DifferentialDrive {
    /// Track: distance between the wheels' contact points, metres (b in the paper).
    pub track_m: f32,
}

impl DifferentialDrive {
    /// The AMiRo's track, 69 mm (public AMiRo headers; the paper prints none).
    pub const AMIRO: Self = Self { track_m: 0.069 };

    /// What the body does in `seconds` of constant wheel speeds: exact, an arc (eq. 6).
    #[must_use]
    pub fn motion(&self, speeds: WheelSpeeds, seconds: f32) -> Motion {
        self.motion_of_travel(WheelTravel {
            left_m: speeds.left_m_per_s * seconds,
            right_m: speeds.right_m_per_s * seconds,
        })
    }

    /// What the body does when its wheels roll the given distances evenly.
    #[must_use]
    pub fn motion_of_travel(&self, travel: WheelTravel) -> Motion {
        let arc = 0.5 * (travel.left_m + travel.right_m);
        let turn = (travel.right_m - travel.left_m) / self.track_m;
        let half_turn = 0.5 * turn;
        let chord = if half_turn.abs() < 1e-3 {
            arc
        } else {
            arc * math::sin_cos(half_turn).0 / half_turn
        };
        Motion {
            displacement: Point::new(chord, 0.0).rotated(Rotation::by(half_turn)),
            turn: Angle::from_radians(turn),
        }
    }

    /// How far the wheels rolled during `motion`, taken as one even arc.
    #[must_use]
    pub fn travel_of_motion(&self, motion: &Motion) -> WheelTravel {
        let arc = motion.travel();
        let difference = 0.5 * self.track_m * motion.turn.radians();
        WheelTravel {
            left_m: arc - difference,
            right_m: arc + difference,
        }
    }

    /// The Jacobian J_u of a point's place by the two wheels' travel, 2 x 2.
    ///
    /// [[-1/2 - y/b, -1/2 + y/b], [x/b, -x/b]]: equation 8 (corrected), derived by the
    /// travel of the left and of the right wheel. Rows: x, y of the point; columns:
    /// left, right. Dimensionless.
    #[must_use]
    pub fn jacobian(&self, point: Point) -> Matrix2<f32> {
        let b = self.track_m;
        Matrix2::new(
            -0.5 - point.y / b,
            -0.5 + point.y / b,
            point.x / b,
            -point.x / b,
        )
    }

    /// Covariance of a world-fixed point after a motion whose wheel travel is uncertain.
    ///
    /// `before` is its covariance ahead of the motion, square metres, and `point` its
    /// place there; `travel_sigma` is the standard deviation of each wheel's travel.
    /// The result is in the body frame after the motion:
    /// R before R^T + H J diag(sigma_l^2, sigma_r^2) J^T H^T with R the rotation by
    /// minus the turn and H by minus half of it. J is taken in the middle of the
    /// motion, where an error of an even arc acts in the mean; at its end the variance
    /// would be wrong by travel / distance, 10 % for a step of 10 mm. Paper section
    /// 4.4: "one can now derive error propagation from equation 8 by calculating the
    /// Jacobian".
    #[must_use]
    pub fn propagate_covariance(
        &self,
        before: &Matrix2<f32>,
        motion: &Motion,
        point: Point,
        travel_sigma: WheelTravel,
    ) -> Matrix2<f32> {
        let half = motion.fraction(0.5);
        let to_middle = InverseMotion::of(&half);
        let rotation = InverseMotion::of(motion).rotation_matrix();
        let j = to_middle.rotation_matrix() * self.jacobian(to_middle.apply(point));
        let variances = Vector2::new(
            travel_sigma.left_m * travel_sigma.left_m,
            travel_sigma.right_m * travel_sigma.right_m,
        );
        rotation * before * rotation.transpose()
            + j * Matrix2::from_diagonal(&variances) * j.transpose()
    }
}

/// A motion of the body, prepared for moving many world-fixed points past it.
#[derive(Clone, Copy, Debug)]
pub struct InverseMotion {
    displacement: Point,
    rotation: Rotation,
}

impl InverseMotion {
    /// Prepares the exact SE(2) inverse of `motion`: one sine and cosine.
    #[must_use]
    pub fn of(motion: &Motion) -> Self {
        Self {
            displacement: motion.displacement,
            rotation: Rotation::by(motion.turn.radians()).inverse(),
        }
    }

    /// Where a world-fixed point of the old body frame lies in the new one.
    #[must_use]
    #[inline]
    pub fn apply(&self, body: Point) -> Point {
        (body - self.displacement).rotated(self.rotation)
    }

    fn rotation_matrix(&self) -> Matrix2<f32> {
        let Rotation { sine, cosine } = self.rotation;
        Matrix2::new(cosine, -sine, sine, cosine)
    }
}

/// Random errors of the wheels' travel, prepared for displacing many points.
#[derive(Clone, Copy, Debug)]
pub struct TravelNoise {
    forward: WheelTravel,
    turn: WheelTravel,
}

impl TravelNoise {
    /// Independent errors with the given standard deviations.
    #[must_use]
    pub fn new(drive: &DifferentialDrive, sigma: WheelTravel) -> Self {
        Self {
            forward: WheelTravel {
                left_m: 0.5 * sigma.left_m,
                right_m: 0.5 * sigma.right_m,
            },
            turn: WheelTravel {
                left_m: sigma.left_m / drive.track_m,
                right_m: sigma.right_m / drive.track_m,
            },
        }
    }

    /// A point of the body frame, displaced by J_u e for errors e of the left and the
    /// right wheel in standard deviations ([`DifferentialDrive::jacobian`]).
    #[must_use]
    #[inline]
    pub fn displace(&self, point: Point, (left, right): (f32, f32)) -> Point {
        let forward = self.forward.left_m * left + self.forward.right_m * right;
        let turn = self.turn.right_m * right - self.turn.left_m * left;
        Point::new(point.x - forward + turn * point.y, point.y - turn * point.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Generator, standard_normal_pair};

    const DRIVE: DifferentialDrive = DifferentialDrive::AMIRO;

    fn speeds(left: f32, right: f32) -> WheelSpeeds {
        WheelSpeeds {
            left_m_per_s: left,
            right_m_per_s: right,
        }
    }

    #[test]
    fn faster_right_wheel_turns_left() {
        let motion = DRIVE.motion(speeds(0.07, 0.09), 0.125);
        assert!(motion.turn.radians() > 0.0);
        // Equation 6 as printed, (v_l - v_r) / b, says the opposite.
        let printed = (0.07 - 0.09) / DRIVE.track_m * 0.125;
        assert!(printed * motion.turn.radians() < 0.0);
    }

    #[test]
    fn driving_forward_moves_points_back() {
        let motion = DRIVE.motion(speeds(0.08, 0.08), 0.125);
        let moved = InverseMotion::of(&motion).apply(Point::new(0.1, 0.05));
        assert!((moved.x - 0.09).abs() < 1e-7 && (moved.y - 0.05).abs() < 1e-7);
    }

    #[test]
    fn turning_left_moves_a_point_ahead_to_the_right() {
        let motion = DRIVE.motion(speeds(-0.05, 0.05), 0.1);
        let moved = InverseMotion::of(&motion).apply(Point::new(0.1, 0.0));
        assert!(moved.y < 0.0, "{moved:?}");
    }

    #[test]
    fn corrected_point_velocity_is_rigid_and_the_printed_one_shears() {
        // Rate of change of the squared distance of two points, d|A-B|^2/dt.
        let (v_l, v_r, b) = (0.07, 0.1, DRIVE.track_m);
        let (v, omega) = (0.5 * (v_l + v_r), (v_r - v_l) / b);
        let corrected = |p: Point| Point::new(-v + omega * p.y, -omega * p.x);
        let printed = |p: Point| Point::new(v - (v_l - v_r) / b * p.y, -(v_l - v_r) / b * p.x);
        let (a, c) = (Point::new(0.1, 0.05), Point::new(0.04, -0.07));
        let rate = |velocity: &dyn Fn(Point) -> Point| {
            let relative = velocity(a) - velocity(c);
            2.0 * ((a.x - c.x) * relative.x + (a.y - c.y) * relative.y)
        };
        assert!(rate(&corrected).abs() < 1e-8);
        assert!(rate(&printed).abs() > 1e-3, "the printed form must shear");
    }

    #[test]
    fn exact_step_agrees_with_the_corrected_velocity_for_short_times() {
        let (wheels, p, seconds) = (speeds(0.06, 0.1), Point::new(0.12, -0.08), 1e-3);
        let (v, omega) = (0.08, 0.04 / DRIVE.track_m);
        let moved = InverseMotion::of(&DRIVE.motion(wheels, seconds)).apply(p);
        let euler = Point::new(
            p.x + seconds * (-v + omega * p.y),
            p.y - seconds * omega * p.x,
        );
        assert!((moved - euler).norm() < 1e-6);
    }

    #[test]
    fn a_full_turn_in_place_brings_every_point_back() {
        let step = InverseMotion::of(&DRIVE.motion(speeds(-0.05, 0.05), 0.01));
        let start = Point::new(0.15, 0.1);
        let turn_per_step = 0.1 / DRIVE.track_m * 0.01;
        let steps = (core::f32::consts::TAU / turn_per_step) as u32;
        let mut p = start;
        for _ in 0..steps {
            p = step.apply(p);
        }
        let radius_error = (p.norm() - start.norm()).abs();
        assert!(radius_error < 1e-5, "radius drifts by {radius_error} m");
    }

    #[test]
    fn wheel_travel_and_motion_are_inverse() {
        for travel in [(0.01, 0.012), (0.05, -0.05), (-0.02, -0.03), (0.01, 0.01)] {
            let rolled = WheelTravel {
                left_m: travel.0,
                right_m: travel.1,
            };
            let back = DRIVE.travel_of_motion(&DRIVE.motion_of_travel(rolled));
            assert!((back.left_m - rolled.left_m).abs() < 1e-7, "{rolled:?}");
            assert!((back.right_m - rolled.right_m).abs() < 1e-7, "{rolled:?}");
        }
    }

    #[test]
    fn covariance_matches_monte_carlo() {
        // 100 000 samples: a variance's relative error is sqrt(2/n) = 0.45 %, so
        // 4 sigma are 1.8 %; 3 % leaves room for the linearisation.
        const SAMPLES: u32 = 100_000;
        let start = Point::new(0.12, 0.07);
        let travel = WheelTravel {
            left_m: 0.008,
            right_m: 0.014,
        };
        let sigma = WheelTravel {
            left_m: 0.05 * travel.left_m,
            right_m: 0.05 * travel.right_m,
        };
        let motion = DRIVE.motion_of_travel(travel);
        let after = InverseMotion::of(&motion).apply(start);
        let predicted = DRIVE.propagate_covariance(&Matrix2::zeros(), &motion, start, sigma);
        for seed in 1..=3 {
            let mut generator = Generator::seeded(seed);
            let mut sum = Matrix2::<f64>::zeros();
            for _ in 0..SAMPLES {
                let (e_l, e_r) = standard_normal_pair(&mut generator);
                let noisy = DRIVE.motion_of_travel(WheelTravel {
                    left_m: travel.left_m + sigma.left_m * e_l,
                    right_m: travel.right_m + sigma.right_m * e_r,
                });
                let error = InverseMotion::of(&noisy).apply(start) - after;
                let error = Vector2::new(f64::from(error.x), f64::from(error.y));
                sum += error * error.transpose();
            }
            let sampled = sum / f64::from(SAMPLES);
            let scale = f64::from(predicted.trace());
            for (s, p) in sampled.iter().zip(predicted.iter()) {
                let error = (s - f64::from(*p)).abs() / scale;
                assert!(error < 0.03, "seed {seed}: {sampled} against {predicted}");
            }
        }
    }

    #[test]
    fn noise_displaces_by_the_jacobian() {
        let sigma = WheelTravel {
            left_m: 0.0004,
            right_m: 0.0007,
        };
        let point = Point::new(0.13, -0.06);
        let noise = TravelNoise::new(&DRIVE, sigma);
        for (left, right) in [(1.0, 0.0), (0.0, 1.0), (-0.7, 2.1)] {
            let moved = noise.displace(point, (left, right)) - point;
            let errors = Vector2::new(left * sigma.left_m, right * sigma.right_m);
            let expected = DRIVE.jacobian(point) * errors;
            assert!((moved.x - expected.x).abs() < 1e-7, "({left}, {right})");
            assert!((moved.y - expected.y).abs() < 1e-7, "({left}, {right})");
        }
    }

    #[test]
    fn covariance_without_wheel_noise_only_turns() {
        let before = Matrix2::new(4e-6, 1e-6, 1e-6, 2e-6);
        let motion = DRIVE.motion(speeds(-0.05, 0.05), 0.3);
        let after = DRIVE.propagate_covariance(
            &before,
            &motion,
            Point::new(0.1, 0.0),
            WheelTravel::default(),
        );
        assert!((after.trace() - before.trace()).abs() < 1e-11);
        assert!((after.determinant() - before.determinant()).abs() < 1e-17);
    }
}
