//! Where the robot was when a reading was taken.
//!
//! Readings and odometry carry stamps of their own: the AMiRo sends odometry every
//! 63 ms, the sensors deliver every 8 ms, and 50 ms of age are 4 mm at 80 mm/s. The
//! pose at a reading's stamp is interpolated between two odometry poses or predicted
//! beyond the last.

use crate::geometry::{Motion, Pose};
use crate::model::{DifferentialDrive, WheelSpeeds};
use crate::node::InputError;

/// Odometry older than this at a reading's stamp is stale: three periods of the
/// AMiRo's 63 ms, rounded up.
pub const MAX_AGE_US: u64 = 200_000;

/// Poses farther apart than this are not joined: the robot may have been carried.
pub const MAX_GAP_US: u64 = 1_000_000;

/// Fastest that a wheel or the body is believed to be, metres a second: twice the
/// 0.5 m/s that the AMiRo's own programs ask for at most, because two frames of 63 ms
/// can carry the motion of two updates of 50 ms.
pub const MAX_SPEED_M_PER_S: f32 = 1.0;

/// Fastest turn that is believed, radians a second: twice 6 rad/s, for the same reason.
pub const MAX_TURN_RAD_PER_S: f32 = 12.0;

/// Way and turn that are believed in no time: the steps of 256 um and 256 urad in which
/// the AMiRo sends its pose, with room.
const SLACK_M: f32 = 0.001;
const SLACK_RAD: f32 = 0.005;

/// Implausible poses in a row, plausible among themselves, that are a new origin.
const INSISTING: u8 = 3;

/// The last two odometry poses, and how the robot moves beyond them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometry {
    last: Option<StampedPose>,
    before: Option<StampedPose>,
    /// Wheel speeds since the last pose, when the source of motion is wheel speeds.
    speeds: Option<WheelSpeeds>,
    /// The last pose that was implausible, and how many of them agree.
    suspect: Option<(StampedPose, u8)>,
}

#[derive(Clone, Copy, Debug)]
struct StampedPose {
    stamp_us: u64,
    pose: Pose,
}

impl StampedPose {
    /// Whether a robot can get from here to `next` in the time between.
    fn reaches(&self, next: &Self) -> bool {
        let seconds = next.stamp_us.saturating_sub(self.stamp_us) as f32 * 1e-6;
        let motion = self.pose.motion_to(&next.pose);
        motion.displacement.norm() <= MAX_SPEED_M_PER_S * seconds + SLACK_M
            && motion.turn.radians().abs() <= MAX_TURN_RAD_PER_S * seconds + SLACK_RAD
    }
}

/// How a pose follows from those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continuity {
    /// The robot drove there.
    Continuous,
    /// The motion to this pose is unknown: the odometry was silent for more than
    /// [`MAX_GAP_US`], or continues from another origin.
    Reset,
}

impl Odometry {
    /// Takes a pose.
    ///
    /// An equal stamp is a repetition and changes nothing. A pose that no robot can
    /// reach in its time is refused and the last one held, until three in a row agree
    /// with each other: the odometry then has a new origin.
    ///
    /// # Errors
    /// [`InputError::NotFinite`]; [`InputError::StampBackward`];
    /// [`InputError::Implausible`]. The pose is then ignored.
    pub fn take_pose(&mut self, stamp_us: u64, pose: Pose) -> Result<Continuity, InputError> {
        if !pose.is_finite() {
            return Err(InputError::NotFinite);
        }
        let continuity = self.push(StampedPose { stamp_us, pose })?;
        self.speeds = None;
        Ok(continuity)
    }

    /// Takes wheel speeds that hold from the stamp on; poses are reckoned from them,
    /// from the origin if none is known.
    ///
    /// # Errors
    /// [`InputError::NotFinite`]; [`InputError::StampBackward`];
    /// [`InputError::Implausible`] for a wheel faster than [`MAX_SPEED_M_PER_S`]. The
    /// speeds are then ignored.
    pub fn take_wheels(
        &mut self,
        drive: &DifferentialDrive,
        stamp_us: u64,
        speeds: WheelSpeeds,
    ) -> Result<Continuity, InputError> {
        let wheels = [speeds.left_m_per_s, speeds.right_m_per_s];
        if !wheels.iter().all(|speed| speed.is_finite()) {
            return Err(InputError::NotFinite);
        }
        if wheels.iter().any(|speed| speed.abs() > MAX_SPEED_M_PER_S) {
            return Err(InputError::Implausible);
        }
        let pose = match (self.last, self.speeds) {
            (Some(last), Some(before)) if stamp_us >= last.stamp_us => {
                reckon(drive, &last, before, stamp_us - last.stamp_us)
            }
            (Some(last), _) => last.pose,
            (None, _) => Pose::default(),
        };
        let continuity = self.push(StampedPose { stamp_us, pose })?;
        self.speeds = Some(speeds);
        Ok(continuity)
    }

    fn push(&mut self, next: StampedPose) -> Result<Continuity, InputError> {
        let Some(last) = self.last else {
            self.last = Some(next);
            return Ok(Continuity::Continuous);
        };
        if next.stamp_us < last.stamp_us {
            return Err(InputError::StampBackward);
        }
        if next.stamp_us == last.stamp_us {
            return Ok(Continuity::Continuous);
        }
        if next.stamp_us - last.stamp_us > MAX_GAP_US {
            self.begin_at(next);
            return Ok(Continuity::Reset);
        }
        if last.reaches(&next) {
            self.before = self.last;
            self.last = Some(next);
            self.suspect = None;
            return Ok(Continuity::Continuous);
        }
        let agreeing = match self.suspect {
            Some((suspect, agreeing)) if suspect.reaches(&next) => agreeing + 1,
            _ => 1,
        };
        if agreeing < INSISTING {
            self.suspect = Some((next, agreeing));
            return Err(InputError::Implausible);
        }
        self.begin_at(next);
        Ok(Continuity::Reset)
    }

    /// Clears the motion to the current pose.
    fn begin_at(&mut self, origin: StampedPose) {
        *self = Self {
            last: Some(origin),
            ..Self::default()
        };
    }

    /// The pose at a stamp.
    ///
    /// # Errors
    /// [`InputError::NoPose`] before any odometry; [`InputError::StalePose`] when the stamp
    /// lies before the last two poses or more than [`MAX_AGE_US`] after the last.
    pub fn pose_at(&self, drive: &DifferentialDrive, stamp_us: u64) -> Result<Pose, InputError> {
        let last = self.last.ok_or(InputError::NoPose)?;
        match stamp_us.checked_sub(last.stamp_us) {
            Some(0) => Ok(last.pose),
            Some(age_us) if age_us > MAX_AGE_US => Err(InputError::StalePose),
            Some(age_us) => Ok(match self.speeds {
                Some(speeds) => reckon(drive, &last, speeds, age_us),
                None => self.along_last_motion(&last, stamp_us).unwrap_or(last.pose),
            }),
            None => self
                .along_last_motion(&last, stamp_us)
                .ok_or(InputError::StalePose),
        }
    }

    /// The pose at a stamp on the arc through the last two poses, if they determine one.
    fn along_last_motion(&self, last: &StampedPose, stamp_us: u64) -> Option<Pose> {
        let before = self.before?;
        let gap_us = last.stamp_us - before.stamp_us;
        if stamp_us < before.stamp_us {
            return None;
        }
        let fraction = (stamp_us - before.stamp_us) as f32 / gap_us as f32;
        let motion = before.pose.motion_to(&last.pose);
        if stamp_us <= last.stamp_us {
            return Some(before.pose.moved(&motion.fraction(fraction)));
        }
        // Beyond the last pose, continue from it: rounding then never moves the robot
        // backward at the joint.
        Some(last.pose.moved(&motion.fraction(fraction - 1.0)))
    }
}

fn reckon(
    drive: &DifferentialDrive,
    from: &StampedPose,
    speeds: WheelSpeeds,
    after_us: u64,
) -> Pose {
    let motion: Motion = drive.motion(speeds, after_us as f32 * 1e-6);
    from.pose.moved(&motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: DifferentialDrive = DifferentialDrive::AMIRO;

    fn straight() -> Odometry {
        let mut odometry = Odometry::default();
        odometry
            .take_pose(1_000_000, Pose::new(0.0, 0.0, 0.0))
            .unwrap();
        odometry
            .take_pose(1_050_000, Pose::new(0.004, 0.0, 0.0))
            .unwrap();
        odometry
    }

    #[test]
    fn poses_between_and_beyond_lie_on_the_line() {
        for (stamp, x) in [
            (1_000_000, 0.0),
            (1_025_000, 0.002),
            (1_050_000, 0.004),
            (1_100_000, 0.008),
        ] {
            let pose = straight().pose_at(&DRIVE, stamp).unwrap();
            assert!((pose.position.x - x).abs() < 1e-7, "{stamp}: {pose:?}");
        }
    }

    #[test]
    fn rounding_moves_no_robot_at_the_joint_of_poses_and_prediction() {
        // Ten metres off, a coordinate's last bit is 1 um; a microsecond at 80 mm/s is
        // less than a tenth of it.
        for step in 0..1000 {
            let x = 8.0 + step as f32 * 1.3e-3;
            let last = Pose::new(x + 0.004, -x - 0.000_1, 0.3);
            let mut odometry = Odometry::default();
            odometry.take_pose(0, Pose::new(x, -x, 0.3)).unwrap();
            odometry.take_pose(50_000, last).unwrap();
            let predicted = odometry.pose_at(&DRIVE, 50_001).unwrap();
            assert_eq!(predicted.position, last.position, "at {x} m");
        }
    }

    #[test]
    fn prediction_follows_the_arc() {
        // 0.1 m radius, 0.1 rad a pose: the third pose is known exactly.
        let at = |angle: f32| {
            let (sine, cosine) = crate::math::sin_cos(angle);
            Pose::new(0.1 * sine, 0.1 * (1.0 - cosine), angle)
        };
        let mut odometry = Odometry::default();
        odometry.take_pose(0, at(0.0)).unwrap();
        odometry.take_pose(100_000, at(0.1)).unwrap();
        let predicted = odometry.pose_at(&DRIVE, 200_000).unwrap();
        assert!((predicted.position - at(0.2).position).norm() < 1e-6);
        assert!((predicted.heading.radians() - 0.2).abs() < 1e-6);
    }

    #[test]
    fn wheel_speeds_are_reckoned_until_the_next() {
        let wheels = |left, right| WheelSpeeds {
            left_m_per_s: left,
            right_m_per_s: right,
        };
        let mut odometry = Odometry::default();
        odometry.take_wheels(&DRIVE, 0, wheels(0.08, 0.08)).unwrap();
        odometry
            .take_wheels(&DRIVE, 100_000, wheels(0.0, 0.0))
            .unwrap();
        let pose = odometry.pose_at(&DRIVE, 150_000).unwrap();
        assert!((pose.position.x - 0.008).abs() < 1e-7, "{pose:?}");
    }

    #[test]
    fn wheel_speeds_are_reckoned_over_the_time_between_their_stamps() {
        // A board's clock does not begin with the wheels: 100 ms at 80 mm/s are 8 mm.
        let ahead = WheelSpeeds {
            left_m_per_s: 0.08,
            right_m_per_s: 0.08,
        };
        let mut odometry = Odometry::default();
        odometry.take_wheels(&DRIVE, 1_000_000, ahead).unwrap();
        let continuity = odometry.take_wheels(&DRIVE, 1_100_000, ahead);
        assert_eq!(continuity, Ok(Continuity::Continuous));
        let pose = odometry.pose_at(&DRIVE, 1_100_000).unwrap();
        assert!((pose.position.x - 0.008).abs() < 1e-7, "{pose:?}");
    }

    #[test]
    fn f35_wheel_speeds_of_an_earlier_stamp_are_refused() {
        let ahead = WheelSpeeds {
            left_m_per_s: 0.08,
            right_m_per_s: 0.08,
        };
        let mut odometry = Odometry::default();
        odometry.take_wheels(&DRIVE, 1_000_000, ahead).unwrap();
        assert_eq!(
            odometry.take_wheels(&DRIVE, 999_999, ahead),
            Err(InputError::StampBackward)
        );
        let pose = odometry.pose_at(&DRIVE, 1_100_000).unwrap();
        assert!((pose.position.x - 0.008).abs() < 1e-7, "{pose:?}");
    }

    #[test]
    fn too_old_too_young_and_absent_are_distinguished() {
        assert_eq!(
            Odometry::default().pose_at(&DRIVE, 5),
            Err(InputError::NoPose)
        );
        let odometry = straight();
        assert_eq!(
            odometry.pose_at(&DRIVE, 999_999),
            Err(InputError::StalePose)
        );
        assert!(odometry.pose_at(&DRIVE, 1_250_000).is_ok());
        assert_eq!(
            odometry.pose_at(&DRIVE, 1_250_001),
            Err(InputError::StalePose)
        );
    }

    #[test]
    fn backward_stamps_and_bad_numbers_change_nothing() {
        let mut odometry = straight();
        let backward = odometry.take_pose(1_049_999, Pose::new(9.0, 0.0, 0.0));
        assert_eq!(backward, Err(InputError::StampBackward));
        let bad = odometry.take_pose(1_060_000, Pose::new(f32::NAN, 0.0, 0.0));
        assert_eq!(bad, Err(InputError::NotFinite));
        let speeds = WheelSpeeds {
            left_m_per_s: f32::INFINITY,
            right_m_per_s: 0.0,
        };
        assert_eq!(
            odometry.take_wheels(&DRIVE, 1_060_000, speeds),
            Err(InputError::NotFinite)
        );
        let pose = odometry.pose_at(&DRIVE, 1_050_000).unwrap();
        assert!((pose.position.x - 0.004).abs() < 1e-9);
    }

    #[test]
    fn f30_no_number_that_is_not_finite_is_taken() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for pose in [
                Pose::new(bad, 0.0, 0.0),
                Pose::new(0.0, bad, 0.0),
                Pose::new(0.0, 0.0, bad),
            ] {
                let mut odometry = straight();
                assert_eq!(
                    odometry.take_pose(1_060_000, pose),
                    Err(InputError::NotFinite)
                );
                let held = odometry.pose_at(&DRIVE, 1_060_000).unwrap();
                assert!((held.position.x - 0.0048).abs() < 1e-6, "{held:?}");
            }
        }
    }

    #[test]
    fn f31_a_jump_is_refused_and_the_last_pose_held() {
        let mut odometry = straight();
        for (stamp_us, pose) in [
            (1_113_000, Pose::new(0.5, 0.0, 0.0)),
            (1_176_000, Pose::new(-3.0, 0.0, 0.0)),
            // 63 ms at 12 rad/s are 0.76 rad.
            (1_200_000, Pose::new(0.004, 0.0, 2.9)),
        ] {
            assert_eq!(
                odometry.take_pose(stamp_us, pose),
                Err(InputError::Implausible),
                "{pose:?}"
            );
        }
        let good = odometry.take_pose(1_210_000, Pose::new(0.012, 0.0, 0.0));
        assert_eq!(good, Ok(Continuity::Continuous));
    }

    #[test]
    fn f31_an_odometry_that_insists_has_a_new_origin() {
        let mut odometry = straight();
        let moved = |step: u64| {
            (
                1_113_000 + step * 63_000,
                Pose::new(5.0 + step as f32 * 0.005, 0.0, 0.0),
            )
        };
        let taken: Vec<_> = (0..4)
            .map(|step| {
                let (stamp_us, pose) = moved(step);
                odometry.take_pose(stamp_us, pose)
            })
            .collect();
        assert_eq!(
            taken,
            [
                Err(InputError::Implausible),
                Err(InputError::Implausible),
                Ok(Continuity::Reset),
                Ok(Continuity::Continuous)
            ]
        );
        // Nothing joins the two origins.
        assert_eq!(
            odometry.pose_at(&DRIVE, 1_060_000),
            Err(InputError::StalePose)
        );
    }

    #[test]
    fn f31_fast_but_possible_driving_is_believed() {
        // 0.5 m/s and 6 rad/s, seen through frames that carry one or two updates.
        let mut odometry = Odometry::default();
        for frame in 0..200_u64 {
            let update_s = (frame * 63_000 / 50_000 * 50_000) as f32 * 1e-6;
            let pose = Pose::new(0.5 * update_s, 0.0, 6.0 * update_s);
            assert_eq!(
                odometry.take_pose(frame * 63_000, pose),
                Ok(Continuity::Continuous),
                "frame {frame}"
            );
        }
    }

    #[test]
    fn f31_a_step_of_the_sent_numbers_is_believed_in_no_time_and_more_is_not() {
        // 256 um and 256 urad are what the lowest bits stand for; 1 us drives nowhere.
        for (metres, radians) in [(256e-6, 0.0), (0.0, 256e-6), (-256e-6, -256e-6)] {
            let mut odometry = Odometry::default();
            odometry.take_pose(0, Pose::default()).unwrap();
            assert_eq!(
                odometry.take_pose(1, Pose::new(metres, 0.0, radians)),
                Ok(Continuity::Continuous),
                "{metres} m, {radians} rad"
            );
        }
        for (metres, radians) in [(1024e-6, 0.0), (0.0, 6e-3)] {
            let mut odometry = Odometry::default();
            odometry.take_pose(0, Pose::default()).unwrap();
            assert_eq!(
                odometry.take_pose(1, Pose::new(metres, 0.0, radians)),
                Err(InputError::Implausible),
                "{metres} m, {radians} rad"
            );
        }
    }

    #[test]
    fn f35_no_time_is_skipped_backward_dropped_a_long_gap_breaks_off() {
        let mut odometry = straight();
        let nowhere = Pose::new(9.0, 9.0, 3.0);
        assert_eq!(
            odometry.take_pose(1_050_000, nowhere),
            Ok(Continuity::Continuous),
            "an equal stamp is a repetition"
        );
        let between = odometry.pose_at(&DRIVE, 1_025_000).unwrap();
        assert!((between.position.x - 0.002).abs() < 1e-7, "{between:?}");
        for stamp_us in [0, 1, 1_049_999] {
            assert_eq!(
                odometry.take_pose(stamp_us, Pose::default()),
                Err(InputError::StampBackward)
            );
        }
        for (gap_us, expected) in [
            (1, Err(InputError::Implausible)),
            (MAX_GAP_US, Err(InputError::Implausible)),
            (MAX_GAP_US + 1, Ok(Continuity::Reset)),
            (u64::MAX - 1_050_000, Ok(Continuity::Reset)),
        ] {
            let mut odometry = straight();
            assert_eq!(odometry.take_pose(1_050_000 + gap_us, nowhere), expected);
            let _ = odometry.pose_at(&DRIVE, 1_050_000 + gap_us);
        }
    }

    #[test]
    fn a_wheel_too_fast_for_any_robot_is_refused() {
        let speeds = WheelSpeeds {
            left_m_per_s: 80.0,
            right_m_per_s: 0.08,
        };
        let mut odometry = Odometry::default();
        assert_eq!(
            odometry.take_wheels(&DRIVE, 0, speeds),
            Err(InputError::Implausible)
        );
        // The fastest that is believed is.
        let fastest = WheelSpeeds {
            left_m_per_s: MAX_SPEED_M_PER_S,
            right_m_per_s: -MAX_SPEED_M_PER_S,
        };
        assert_eq!(
            odometry.take_wheels(&DRIVE, 0, fastest),
            Ok(Continuity::Continuous)
        );
    }
}
