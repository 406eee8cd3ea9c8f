//! Frames on the robot's CAN bus and their faults.

use std::collections::VecDeque;

use amiro_ipf::board::can::{CanFrame, StandardId};
use amiro_ipf::geometry::Pose;
use amiro_ipf::random::{Generator, uniform};

use super::wheel_module::Sent;
use crate::faults::{ActiveFaults, Component, Kind, period_us};

/// Keeps lost and garbled frames apart from all other noise: "frame".
const FRAME_STREAM: u64 = 0x66_7261_6d65;

/// A frame that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrived {
    /// When, microseconds after the power came up.
    pub(super) at_us: u64,
    /// When the pose was computed.
    pub(super) updated_us: u64,
    /// The frame.
    pub(super) frame: CanFrame,
}

/// The frames between the sending and the receiving board.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameWay {
    on_the_way: VecDeque<Arrived>,
    last_passed_us: Option<u64>,
    /// The pose of all frames, if they are stuck.
    held: Option<Pose>,
}

impl FrameWay {
    /// Takes a frame that is sent at a time of the drive; of the faults those that
    /// concern frames.
    pub(super) fn take(&mut self, mut sent: Sent, drive_us: u64, faults: &ActiveFaults) {
        let mut noise = Generator::seeded(faults.seed() ^ FRAME_STREAM ^ sent.at_us);
        let mut carried_m = [0.0; 2];
        let (mut is_lost, mut is_held, mut is_garbled) = (false, false, false);
        let mut late_us = 0;
        for kind in faults.of(Component::Can, drive_us) {
            match kind {
                Kind::Off => is_lost = true,
                Kind::Intermittent(share) => {
                    is_lost |= f64::from(uniform(&mut noise)) < share;
                }
                Kind::Slow(rate_hz) => {
                    let period_us = period_us(rate_hz);
                    let since_us = self.last_passed_us.map(|last_us| sent.at_us - last_us);
                    is_lost |= since_us.is_some_and(|since_us| since_us < period_us);
                }
                Kind::Wrong(by_mm) => carried_m[0] = by_mm as f32 * 1e-3,
                Kind::Stuck => is_held = true,
                Kind::Garbage => is_garbled = true,
                Kind::Delayed(by) => late_us = by.as_micros() as u64,
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

    /// The next frame that has arrived by a time; the next call gives the one after it.
    pub(super) fn arrived_by(&mut self, now_us: u64) -> Option<Arrived> {
        let next = self.on_the_way.front()?;
        (next.at_us <= now_us).then(|| self.on_the_way.pop_front())?
    }
}
