//! What a board reports of itself.

use serde::{Deserialize, Serialize};

use crate::driver::{OffsetRefusal, Offsets};
use crate::model::SENSORS;
use crate::node::NodeStatus;

/// The introduction of a board: version, build, capacity, clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Boot {
    /// Version of the wire's messages.
    pub wire_version: u8,
    /// Hash of the sources that the image was built from.
    pub build_id: u64,
    /// Particles that fit.
    pub capacity: u32,
    /// Inputs that are taken ahead of their answers.
    pub window: u8,
    /// Speed of the serial link, bits a second.
    pub baud: u32,
    /// What the core's clock runs on.
    pub clock: ClockSource,
    /// Frequency that the board believes its core has, hertz.
    pub core_hz: u32,
}

/// What the core's clock runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ClockSource {
    /// No microcontroller: the node runs on a host.
    Host,
    /// Crystal and PLL, 168 MHz.
    CrystalPll,
    /// Internal oscillator and PLL, 168 MHz within 1 %: the crystal did not start.
    InternalPll,
    /// Internal oscillator, 16 MHz: the PLL did not lock.
    Internal,
    /// The clock unit answers nothing, as in an emulator; 168 MHz are assumed.
    Unknown,
}

/// The offsets in use, and what became of the last attempt to measure them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OffsetReport {
    /// The offsets and where they come from.
    pub offsets: Offsets,
    /// Whether the board's memory holds them, or is being written.
    pub is_kept: bool,
    /// Why a sensor's could not be measured, in the last attempt; with any refused,
    /// none is taken.
    pub refused: [Option<OffsetRefusal>; SENSORS],
}

/// The state of the node and of the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// The node's part; `inputs` also counts greetings and calibrations.
    pub node: NodeStatus,
    /// The board's part.
    pub board: BoardStatus,
}

/// The state of the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BoardStatus {
    /// Time since reset by the board's clock, milliseconds.
    pub uptime_ms: u64,
    /// Core clock cycles of the last step, its events and interrupts included.
    pub step_cycles: u32,
    /// The most of these since the configuration.
    pub step_cycles_max: u32,
    /// Own ticks that found the step before still running.
    pub overruns: u32,
    /// Frames dropped because the link was too slow, particle frames first.
    pub dropped_frames: u32,
    /// Input frames that arrived broken, out of order or not at all.
    pub broken_frames: u32,
    /// Received bytes lost for want of room or to line errors.
    pub lost_bytes: u32,
    /// Frames queued for the link since reset, this one not yet; with the dropped ones
    /// they are all that have a number.
    pub sent_frames: u32,
}
