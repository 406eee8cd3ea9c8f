//! Differential drive with factors for its systematic errors (\[IPM\] equations 6 and 7).

use serde::{Deserialize, Serialize};

use crate::geometry::{Angle, Motion, Point, Rotation};
use crate::model::{DifferentialDrive, WheelSpeeds};

/// Factors from what encoders and drawings say to what wheels and track are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelCorrection {
    /// True travel of the left wheel per measured travel (k1); 0.5 to 2.
    pub left: f32,
    /// True travel of the right wheel per measured travel (k2); 0.5 to 2.
    pub right: f32,
    /// True track per nominal track (k3); 0.5 to 2. Found only by turning.
    pub track: f32,
}

impl WheelCorrection {
    /// No correction: an uncalibrated robot.
    pub const NONE: Self = Self {
        left: 1.0,
        right: 1.0,
        track: 1.0,
    };
}

/// A differential drive whose wheels and track are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectedDrive {
    /// The drive with its nominal track (b).
    pub nominal: DifferentialDrive,
    /// The factors.
    pub correction: WheelCorrection,
}

impl CorrectedDrive {
    /// Speeds of the wheels over ground, from measured ones: (k1 v_L, k2 v_R).
    #[must_use]
    pub fn over_ground(&self, measured: WheelSpeeds) -> WheelSpeeds {
        WheelSpeeds {
            left_m_per_s: self.correction.left * measured.left_m_per_s,
            right_m_per_s: self.correction.right * measured.right_m_per_s,
        }
    }

    /// The drive with its true track, k3 b.
    #[must_use]
    pub fn true_drive(&self) -> DifferentialDrive {
        DifferentialDrive {
            track_m: self.correction.track * self.nominal.track_m,
        }
    }

    /// Speed of the axle's centre, metres per second: (k1 v_L + k2 v_R) / 2 (eq. 6).
    #[must_use]
    pub fn forward_m_per_s(&self, measured: WheelSpeeds) -> f32 {
        let wheels = self.over_ground(measured);
        0.5 * (wheels.left_m_per_s + wheels.right_m_per_s)
    }

    /// Rate of turn, radians per second, counter-clockwise positive:
    /// (k2 v_R - k1 v_L) / (k3 b) (eq. 7).
    #[must_use]
    pub fn yaw_rad_per_s(&self, measured: WheelSpeeds) -> f32 {
        let wheels = self.over_ground(measured);
        (wheels.right_m_per_s - wheels.left_m_per_s) / self.true_drive().track_m
    }

    /// What the body does in `seconds` of constant measured speeds: exact, an arc.
    #[must_use]
    pub fn motion(&self, measured: WheelSpeeds, seconds: f32) -> Motion {
        self.true_drive()
            .motion(self.over_ground(measured), seconds)
    }

    /// The same motion with the arc's length along the mean heading (eq. 1 to 3, corrected).
    ///
    /// Longer than the chord by the factor (w T / 2) / sin(w T / 2): 0.03 % at 0.08 rad per
    /// step. \[IPM\] prints the new heading in place of the mean.
    #[must_use]
    pub fn midpoint_motion(&self, measured: WheelSpeeds, seconds: f32) -> Motion {
        let arc_m = self.forward_m_per_s(measured) * seconds;
        let turn = self.yaw_rad_per_s(measured) * seconds;
        Motion {
            displacement: Point::new(arc_m, 0.0).rotated(Rotation::by(0.5 * turn)),
            turn: Angle::from_radians(turn),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    const PIONEER: DifferentialDrive = DifferentialDrive { track_m: 0.33 };
    const SPEEDS: WheelSpeeds = WheelSpeeds {
        left_m_per_s: 0.2,
        right_m_per_s: 0.3,
    };

    fn drive(left: f32, right: f32, track: f32) -> CorrectedDrive {
        CorrectedDrive {
            nominal: PIONEER,
            correction: WheelCorrection { left, right, track },
        }
    }

    /// Single precision: the difference of two speeds of 0.3, over a third of a metre.
    fn close(given: f32, expected: f64) {
        let error = (f64::from(given) - expected).abs();
        assert!(error < 2e-7, "{given} is not {expected}");
    }

    #[test]
    fn g11_one_step_without_correction() {
        let drive = drive(1.0, 1.0, 1.0);
        close(drive.forward_m_per_s(SPEEDS), 0.25);
        close(drive.yaw_rad_per_s(SPEEDS), 0.303_030_303);
        let midpoint = drive.midpoint_motion(SPEEDS, 0.1).displacement;
        close(midpoint.x, 0.024_997_130);
        close(midpoint.y, 0.000_378_773);
        let exact = drive.motion(SPEEDS, 0.1).displacement;
        close(exact.x, 0.024_996_174);
        close(exact.y, 0.000_378_759);
    }

    #[test]
    fn g11_the_printed_order_goes_along_the_new_heading() {
        let drive = drive(1.0, 1.0, 1.0);
        let turn = drive.yaw_rad_per_s(SPEEDS) * 0.1;
        let printed = Point::new(0.025, 0.0).rotated(Rotation::by(turn));
        close(printed.x, 0.024_988_522);
        close(printed.y, 0.000_757_460);
        let midpoint = drive.midpoint_motion(SPEEDS, 0.1).displacement;
        assert!(printed.y > 1.99 * midpoint.y);
    }

    #[test]
    fn g11_one_step_with_correction() {
        let drive = drive(1.02, 0.99, 1.05);
        close(drive.forward_m_per_s(SPEEDS), 0.2505);
        close(drive.yaw_rad_per_s(SPEEDS), 0.268_398_268);
        let midpoint = drive.midpoint_motion(SPEEDS, 0.1).displacement;
        close(midpoint.x, 0.025_047_744);
        close(midpoint.y, 0.000_336_159);
        let (arc, exact) = (drive.motion(SPEEDS, 0.1), drive.true_drive());
        assert_eq!(arc, exact.motion(drive.over_ground(SPEEDS), 0.1));
    }

    /// Largest distance from the exact arc of a circle of 0.3 m/s and 0.8 rad/s, 79 steps
    /// of 0.1 s, with the heading of each step at `share` of its turn.
    fn worst_on_circle(share: f64) -> f64 {
        let (speed, rate, seconds) = (0.3_f64, 0.8_f64, 0.1);
        let (mut x, mut y, mut worst) = (0.0, 0.0, 0.0_f64);
        for step in 0..79 {
            let along = rate * seconds * (f64::from(step) + share);
            x += speed * seconds * along.cos();
            y += speed * seconds * along.sin();
            let end = rate * seconds * f64::from(step + 1);
            let exact = (speed / rate * end.sin(), speed / rate * (1.0 - end.cos()));
            worst = worst.max((x - exact.0).hypot(y - exact.1));
        }
        worst
    }

    #[test]
    fn g11_on_a_circle_the_printed_order_is_30_mm_off_and_the_midpoint_a_fifth_of_one() {
        assert!((worst_on_circle(1.0) - 0.030_000_9).abs() < 1e-7);
        assert!((worst_on_circle(0.0) - 0.030_000_9).abs() < 1e-7);
        assert!((worst_on_circle(0.5) - 0.000_2).abs() < 5e-6);
        // And the code: 0.18 and 0.42 m/s with 0.3 m of track are that circle.
        let drive = CorrectedDrive {
            nominal: DifferentialDrive { track_m: 0.3 },
            correction: WheelCorrection::NONE,
        };
        let speeds = WheelSpeeds {
            left_m_per_s: 0.18,
            right_m_per_s: 0.42,
        };
        let (mut midpoint, mut exact, mut worst) = (Pose::default(), Pose::default(), 0.0_f32);
        for _ in 0..79 {
            midpoint = midpoint.moved(&drive.midpoint_motion(speeds, 0.1));
            exact = exact.moved(&drive.motion(speeds, 0.1));
            worst = worst.max((midpoint.position - exact.position).norm());
        }
        assert!((worst - 0.000_2).abs() < 5e-6, "{worst}");
    }

    #[test]
    fn g11_radians_added_to_degrees_turn_57_times_too_little() {
        // Equation 3 as printed: a heading in degrees, w in rad/s.
        let turn = drive(1.0, 1.0, 1.0).yaw_rad_per_s(SPEEDS) * 0.1;
        let printed = turn.to_radians();
        assert!((turn / printed - 57.295_78).abs() < 1e-3);
    }

    #[test]
    fn a_left_wheel_two_percent_too_large_bends_a_straight_run_by_the_predicted_arc() {
        // 2 m straight with k1 = 1.02: a turn of -0.02 * 2 / 0.33 rad.
        let straight = WheelSpeeds {
            left_m_per_s: 0.2,
            right_m_per_s: 0.2,
        };
        let motion = drive(1.02, 1.0, 1.0).motion(straight, 10.0);
        close(motion.turn.radians(), -0.04 / 0.33);
        assert!(motion.displacement.y < 0.0);
    }
}
