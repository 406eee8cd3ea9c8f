//! Where the robot was when a reading was taken.
//!
//! Readings and odometry carry stamps of their own: the AMiRo sends odometry every
//! 63 ms, the sensors deliver every 8 ms, and 50 ms of age are 4 mm at 80 mm/s. The
//! pose at a reading's stamp is interpolated between two odometry poses or predicted
//! beyond the last.

use crate::fault::Fault;
use crate::geometry::{Motion, Pose};
use crate::kinematics::{DifferentialDrive, WheelSpeeds};

/// Odometry older than this at a reading's stamp is stale: three periods of the
/// AMiRo's 63 ms, rounded up.
pub const MAX_AGE_US: u64 = 200_000;

/// Poses farther apart than this are not joined by an even motion.
const MAX_GAP_US: u64 = 1_000_000;

/// The last two odometry poses, and how the robot moves beyond them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometry {
    last: Option<Stamped>,
    before: Option<Stamped>,
    /// Wheel speeds since the last pose, when the source of motion is wheel speeds.
    speeds: Option<WheelSpeeds>,
}

#[derive(Clone, Copy, Debug)]
struct Stamped {
    stamp_us: u64,
    pose: Pose,
}

impl Odometry {
    /// Takes a pose. An equal stamp replaces the pose before.
    ///
    /// # Errors
    /// [`Fault::NotFinite`]; [`Fault::StampBackward`]. The pose is then ignored.
    pub fn take_pose(&mut self, stamp_us: u64, pose: Pose) -> Result<(), Fault> {
        if !pose.is_finite() {
            return Err(Fault::NotFinite);
        }
        self.push(Stamped { stamp_us, pose })?;
        self.speeds = None;
        Ok(())
    }

    /// Takes wheel speeds that hold from the stamp on; poses are reckoned from them,
    /// from the origin if none is known.
    ///
    /// # Errors
    /// [`Fault::NotFinite`]; [`Fault::StampBackward`]. The speeds are then ignored.
    pub fn take_wheels(
        &mut self,
        drive: &DifferentialDrive,
        stamp_us: u64,
        speeds: WheelSpeeds,
    ) -> Result<(), Fault> {
        if !(speeds.left_m_per_s.is_finite() && speeds.right_m_per_s.is_finite()) {
            return Err(Fault::NotFinite);
        }
        let pose = match (self.last, self.speeds) {
            (Some(last), Some(before)) if stamp_us >= last.stamp_us => {
                reckon(drive, &last, before, stamp_us - last.stamp_us)
            }
            (Some(last), _) => last.pose,
            (None, _) => Pose::default(),
        };
        self.push(Stamped { stamp_us, pose })?;
        self.speeds = Some(speeds);
        Ok(())
    }

    fn push(&mut self, next: Stamped) -> Result<(), Fault> {
        match self.last {
            Some(last) if next.stamp_us < last.stamp_us => return Err(Fault::StampBackward),
            Some(last) if next.stamp_us == last.stamp_us => {}
            last => self.before = last,
        }
        self.last = Some(next);
        Ok(())
    }

    /// The pose at a stamp.
    ///
    /// # Errors
    /// [`Fault::NoPose`] before any odometry; [`Fault::StalePose`] when the stamp lies
    /// before the last two poses or more than [`MAX_AGE_US`] after the last.
    pub fn pose_at(&self, drive: &DifferentialDrive, stamp_us: u64) -> Result<Pose, Fault> {
        let last = self.last.ok_or(Fault::NoPose)?;
        if stamp_us == last.stamp_us {
            return Ok(last.pose);
        }
        if stamp_us > last.stamp_us {
            let age_us = stamp_us - last.stamp_us;
            if age_us > MAX_AGE_US {
                return Err(Fault::StalePose);
            }
            return Ok(match self.speeds {
                Some(speeds) => reckon(drive, &last, speeds, age_us),
                None => self.along_last_motion(&last, stamp_us).unwrap_or(last.pose),
            });
        }
        self.along_last_motion(&last, stamp_us)
            .ok_or(Fault::StalePose)
    }

    /// The pose at a stamp on the arc through the last two poses, if they say anything.
    fn along_last_motion(&self, last: &Stamped, stamp_us: u64) -> Option<Pose> {
        let before = self.before?;
        let gap_us = last.stamp_us - before.stamp_us;
        if stamp_us < before.stamp_us || gap_us > MAX_GAP_US {
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

fn reckon(drive: &DifferentialDrive, from: &Stamped, speeds: WheelSpeeds, after_us: u64) -> Pose {
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
    fn too_old_too_young_and_absent_are_told_apart() {
        assert_eq!(Odometry::default().pose_at(&DRIVE, 5), Err(Fault::NoPose));
        let odometry = straight();
        assert_eq!(odometry.pose_at(&DRIVE, 999_999), Err(Fault::StalePose));
        assert!(odometry.pose_at(&DRIVE, 1_250_000).is_ok());
        assert_eq!(odometry.pose_at(&DRIVE, 1_250_001), Err(Fault::StalePose));
    }

    #[test]
    fn backward_stamps_and_bad_numbers_change_nothing() {
        let mut odometry = straight();
        let backward = odometry.take_pose(1_049_999, Pose::new(9.0, 0.0, 0.0));
        assert_eq!(backward, Err(Fault::StampBackward));
        let bad = odometry.take_pose(1_060_000, Pose::new(f32::NAN, 0.0, 0.0));
        assert_eq!(bad, Err(Fault::NotFinite));
        let speeds = WheelSpeeds {
            left_m_per_s: f32::INFINITY,
            right_m_per_s: 0.0,
        };
        assert_eq!(
            odometry.take_wheels(&DRIVE, 1_060_000, speeds),
            Err(Fault::NotFinite)
        );
        let pose = odometry.pose_at(&DRIVE, 1_050_000).unwrap();
        assert!((pose.position.x - 0.004).abs() < 1e-9);
    }

    #[test]
    fn an_equal_stamp_replaces_the_pose() {
        let mut odometry = straight();
        odometry
            .take_pose(1_050_000, Pose::new(0.005, 0.0, 0.0))
            .unwrap();
        let between = odometry.pose_at(&DRIVE, 1_025_000).unwrap();
        assert!((between.position.x - 0.0025).abs() < 1e-7, "{between:?}");
    }
}
