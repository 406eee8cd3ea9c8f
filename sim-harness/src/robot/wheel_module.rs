//! The board that drives the wheels and sends the odometry.

use amiro_ipf::board::can::{self, CanFrame};
use amiro_ipf::geometry::Pose;
use amiro_ipf::random::Generator;

use super::PartClocks;
use crate::world::{
    Drive, FRAME_PERIOD_US, OdometryModel, Options, UPDATE_PERIOD_US, WheelErrors, WheelWalk,
};

/// Keeps the wheels' errors apart from the noise: "wheel".
const WHEEL_STREAM: u64 = 0x77_6865_656c;

/// A frame of the message ODOMETRY on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sent {
    /// When, microseconds after the power came up.
    pub(super) at_us: u64,
    /// When its pose was computed.
    pub(super) updated_us: u64,
    /// The pose.
    pub(super) pose: Pose,
}

impl Sent {
    /// The frame, with the pose moved by an offset, metres.
    pub(super) fn frame(&self, carried_m: [f32; 2]) -> CanFrame {
        let [x, y] = carried_m;
        let mut pose = self.pose;
        pose.position.x += x;
        pose.position.y += y;
        can::odometry(&pose)
    }
}

/// Updates the odometry every 50 ms and sends it every 63 ms, as the DiWheelDrive does.
#[derive(Clone, Debug)]
pub(super) struct WheelModule {
    walk: WheelWalk,
    starts_us: u64,
    next_update_us: u64,
    next_frame_us: u64,
    reckoned: Option<(u64, Pose)>,
}

impl WheelModule {
    /// The board of a robot that stands until `starts_us` and then drives; of the
    /// odometries [`OdometryModel::WheelErrors`] errs, all others are exact.
    pub(super) fn new(
        drive: &Drive,
        starts_us: u64,
        seed: u64,
        options: &Options,
        clocks: &PartClocks,
    ) -> Self {
        let errors = match options.odometry {
            OdometryModel::WheelErrors(errors) => errors,
            OdometryModel::Truth | OdometryModel::Amiro | OdometryModel::AmiroUndated => {
                WheelErrors::NONE
            }
        };
        let generator = Generator::seeded(seed ^ WHEEL_STREAM);
        Self {
            walk: WheelWalk::new(&errors, &drive.pose_at(0), generator),
            starts_us,
            next_update_us: clocks.first_update_us,
            next_frame_us: clocks.first_frame_us,
            reckoned: None,
        }
    }

    /// The next frame that is sent up to a time, if any; the next call gives the one after it.
    ///
    /// An update at the time of a frame is in it.
    pub(super) fn sent_by(&mut self, now_us: u64, drive: &Drive) -> Option<Sent> {
        while self.next_frame_us <= now_us {
            let at_us = self.next_frame_us;
            self.next_frame_us += FRAME_PERIOD_US;
            while self.next_update_us <= at_us {
                let true_pose = drive.pose_at(self.next_update_us.saturating_sub(self.starts_us));
                self.reckoned = Some((self.next_update_us, self.walk.moved_to(&true_pose)));
                self.next_update_us += UPDATE_PERIOD_US;
            }
            if let Some((updated_us, pose)) = self.reckoned {
                return Some(Sent {
                    at_us,
                    updated_us,
                    pose,
                });
            }
        }
        None
    }
}
