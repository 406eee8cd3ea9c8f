//! How the robot moves, in the words of the bus: forward and about itself.

use crate::model::{DifferentialDrive, WheelSpeeds};

/// Speed of the body: AMiRo's v and w_z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BodySpeed {
    /// Along x, metres a second; backward is negative.
    pub forward_m_per_s: f32,
    /// About the centre, radians a second, counter-clockwise positive: a positive turn
    /// is one to the left, as in the robots' firmware and against the paper's eq. 6.
    pub turn_rad_per_s: f32,
}

impl BodySpeed {
    /// The wheels' speeds that move the body so: v -+ omega b / 2 for left and right.
    ///
    /// The one place where the bus's omega becomes the filter's motion.
    #[must_use]
    pub fn wheels(&self, drive: &DifferentialDrive) -> WheelSpeeds {
        let half_difference = 0.5 * self.turn_rad_per_s * drive.track_m;
        WheelSpeeds {
            left_m_per_s: self.forward_m_per_s - half_difference,
            right_m_per_s: self.forward_m_per_s + half_difference,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::model::InverseMotion;

    const DRIVE: DifferentialDrive = DifferentialDrive::AMIRO;

    #[test]
    fn f34_positive_omega_of_the_bus_is_a_turn_to_the_left() {
        // 0.2 rad/s at 69 mm: the right wheel 6.9 mm/s faster than the body.
        let speed = BodySpeed {
            forward_m_per_s: 0.08,
            turn_rad_per_s: 0.2,
        };
        let wheels = speed.wheels(&DRIVE);
        assert!((wheels.left_m_per_s - 0.0731).abs() < 1e-7, "{wheels:?}");
        assert!((wheels.right_m_per_s - 0.0869).abs() < 1e-7, "{wheels:?}");
        let motion = DRIVE.motion(wheels, 1.0);
        assert!((motion.turn.radians() - 0.2).abs() < 1e-6, "{motion:?}");
        assert!(motion.displacement.y > 0.0, "{motion:?}");
    }

    #[test]
    fn f34_turning_left_moves_the_wall_on_the_left_ahead_and_that_on_the_right_back() {
        let turning = BodySpeed {
            forward_m_per_s: 0.0,
            turn_rad_per_s: 0.1,
        };
        let wall = InverseMotion::of(&DRIVE.motion(turning.wheels(&DRIVE), 1.0));
        // (omega y, -omega x) for a tenth of a radian at 0.1 m: 10 mm, exactly sin 0.1.
        let left = wall.apply(Point::new(0.0, 0.1));
        let right = wall.apply(Point::new(0.0, -0.1));
        assert!((left.x - 0.009_983_34).abs() < 1e-7, "{left:?}");
        assert!((right.x + 0.009_983_34).abs() < 1e-7, "{right:?}");
        let ahead = wall.apply(Point::new(0.1, 0.0));
        assert!((ahead.y + 0.009_983_34).abs() < 1e-7, "{ahead:?}");
    }
}
