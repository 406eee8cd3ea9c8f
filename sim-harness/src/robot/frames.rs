//! Frames on their way over the robot's bus, and what befalls them there.

use std::collections::VecDeque;

use amiro_ipf::board::can::{CanFrame, StandardId};
use amiro_ipf::geometry::Pose;
use amiro_ipf::random::{Generator, uniform};

use super::wheel_board::Sent;
use super::{RobotFaults, Trouble};

/// Keeps lost and garbled frames apart from all other noise: "frame".
const FRAME_STREAM: u64 = 0x66_7261_6d65;

/// A frame that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrived {
    /// When, microseconds after the power came up.
    pub(super) at_us: u64,
    /// When the pose that was sent was reckoned.
    pub(super) updated_us: u64,
    /// What it carries.
    pub(super) frame: CanFrame,
}

/// The frames between the board that sends them and the one that hears them.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameWay {
    on_the_way: VecDeque<Arrived>,
    last_passed_us: Option<u64>,
    /// What all frames say.
    held: Option<Pose>,
}

impl FrameWay {
    /// Takes a frame that is sent at a time of the drive; of the faults those that
    /// concern frames.
    pub(super) fn take(&mut self, mut sent: Sent, drive_us: u64, faults: &RobotFaults) {
        let mut noise = Generator::seeded(faults.seed() ^ FRAME_STREAM ^ sent.at_us);
        let mut carried_m = [0.0; 2];
        let (mut is_lost, mut is_held, mut is_garbled) = (false, false, false);
        let mut late_us = 0;
        for trouble in faults.at(drive_us) {
            match trouble {
                Trouble::NoFrames => is_lost = true,
                Trouble::LooseFrames { share } => {
                    is_lost |= f64::from(uniform(&mut noise)) < share;
                }
                Trouble::SeldomFrames { period_us } => {
                    let since_us = self.last_passed_us.map(|last_us| sent.at_us - last_us);
                    is_lost |= since_us.is_some_and(|since_us| since_us < period_us);
                }
                Trouble::Elsewhere { by_m } => carried_m = by_m,
                Trouble::SameFrames => is_held = true,
                Trouble::GarbledFrames => is_garbled = true,
                Trouble::LateFrames { by_us } => late_us = by_us,
                _ => {}
            }
        }
        if is_held {
            sent.pose = *self.held.get_or_insert(sent.pose);
        } else {
            self.held = None;
        }
        if is_lost {
            return;
        }
        self.last_passed_us = Some(sent.at_us);
        let mut frame = sent.frame(carried_m);
        if is_garbled {
            let [high, low] = [noise.bits(), noise.bits()].map(u64::from);
            frame = CanFrame::data(StandardId::ODOMETRY, (high << 32 | low).to_le_bytes());
        }
        // Frames never overtake each other.
        let last_us = self.on_the_way.back().map_or(0, |last| last.at_us);
        self.on_the_way.push_back(Arrived {
            at_us: (sent.at_us + late_us).max(last_us),
            updated_us: sent.updated_us,
            frame,
        });
    }

    /// The next frame that has arrived by a time; asked again, the one after it.
    pub(super) fn arrived_by(&mut self, now_us: u64) -> Option<Arrived> {
        let next = self.on_the_way.front()?;
        (next.at_us <= now_us).then(|| self.on_the_way.pop_front())?
    }
}
