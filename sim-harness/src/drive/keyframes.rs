//! Selects poses that are far enough apart to be mapped.

use crate::geometry::Pose2;

/// Keeps the first pose, and each that has moved or turned far enough since the last one
/// that was kept.
///
/// A robot that stands still repeats its readings; if all were counted, they
/// would outweigh all others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframes {
    distance_m: f64,
    turn_rad: f64,
    last: Option<Pose2>,
}

impl Keyframes {
    /// Keyframes at least the given metres or radians apart; with 0 and 0 every pose is one.
    #[must_use]
    pub const fn new(distance_m: f64, turn_rad: f64) -> Self {
        Self {
            distance_m,
            turn_rad,
            last: None,
        }
    }

    /// Whether a pose is a keyframe; if so, the next poses are compared with it.
    pub fn take(&mut self, pose: &Pose2) -> bool {
        let is_keyframe = self.last.is_none_or(|last| {
            (pose.position - last.position).norm() >= self.distance_m
                || last.turn_to(pose) >= self.turn_rad
        });
        if is_keyframe {
            self.last = Some(*pose);
        }
        is_keyframe
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pose_and_each_far_or_turned_enough_one_is_kept() {
        let mut keyframes = Keyframes::new(0.10, 5_f64.to_radians());
        let kept = [
            (0.0, 0.0),
            (0.06, 0.0),
            (0.11, 0.0),
            (0.15, 4.0),
            (0.15, 6.0),
            (0.04, 6.0),
            // Through half a turn: 350 degrees are 16 away from 6.
            (0.04, 350.0),
        ]
        .map(|(x, degrees)| keyframes.take(&Pose2::new(x, 0.0, f64::to_radians(degrees))));
        assert_eq!(kept, [true, false, true, false, true, true, true]);
    }
}
