//! The odometry messages of the AMiRo's bus, bit for bit.

use amiro_ipf::board::can::TransmittedPose;
use amiro_ipf::geometry::Pose;

use super::Drive;

/// Between two updates of the odometry, microseconds.
pub const UPDATE_PERIOD_US: u64 = 50_000;
/// Between two frames on the bus, microseconds.
pub const FRAME_PERIOD_US: u64 = 63_000;

/// A frame of the message ODOMETRY (0x50): the newest update at the time of sending.
///
/// The robot updates its pose every 50 ms in micrometres and microradians and sends it
/// every 63 ms, rounded to the message's resolution ([`TransmittedPose`]). The resolution
/// of the wheels' counters, 124 um per increment, is finer and not modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AmiroFrame {
    sent_us: u64,
}

impl AmiroFrame {
    /// The last frame up to a stamp; the first one is sent at the start.
    pub(super) const fn newest_at(stamp_us: u64) -> Self {
        Self {
            sent_us: stamp_us - stamp_us % FRAME_PERIOD_US,
        }
    }

    /// Time at which the pose in the frame was true.
    pub(super) const fn update_us(self) -> u64 {
        self.sent_us - self.sent_us % UPDATE_PERIOD_US
    }

    /// The pose in the frame.
    pub(super) fn pose(self, drive: &Drive) -> Pose {
        TransmittedPose::of(&drive.pose_at(self.update_us())).pose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Scenario;

    #[test]
    fn frames_come_every_63_ms_with_the_update_before() {
        let times = |stamp_us| {
            let frame = AmiroFrame::newest_at(stamp_us);
            (frame.sent_us, frame.update_us())
        };
        assert_eq!(times(0), (0, 0));
        assert_eq!(times(62_999), (0, 0));
        assert_eq!(times(63_000), (63_000, 50_000));
        assert_eq!(times(252_000), (252_000, 250_000));
        // No frame carries the update of 450 ms.
        assert_eq!(times(503_999), (441_000, 400_000));
        assert_eq!(times(504_000), (504_000, 500_000));
    }

    #[test]
    fn headings_to_the_right_survive_the_unsigned_number() {
        let text = "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\n\
                    speed_m_per_s = 0.08\nstart = [0.1, -0.1, -90]\n";
        let drive = Drive::of(&Scenario::parse(text).unwrap());
        let pose = AmiroFrame::newest_at(0).pose(&drive);
        // 3 pi / 2 is 18407.7 steps of 256 urad.
        let expected = Pose::new(390.0 * 256e-6, -391.0 * 256e-6, 18_407.0 * 256e-6);
        assert!((pose.position - expected.position).norm() < 1e-7);
        assert!(pose.motion_to(&expected).turn.radians().abs() < 1e-6);
        let error = core::f32::consts::FRAC_PI_2 + pose.heading.radians();
        assert!((-257e-6..=1e-6).contains(&error), "{error}");
    }
}
