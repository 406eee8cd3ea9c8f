//! What a board reports of itself.

use serde::{Deserialize, Serialize};

use crate::board::clock_choice::ClockSource;
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
    /// Speed of the serial link, bits per second.
    pub baud: u32,
    /// What the core's clock runs on.
    pub clock: ClockSource,
    /// Frequency of the core by the board's configuration, hertz.
    pub core_hz: u32,
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
    /// Received bytes lost because of a full queue or a line error.
    pub lost_bytes: u32,
    /// Frames queued for the link since reset, this one not yet; with the dropped ones
    /// they are all that have a number.
    pub sent_frames: u32,
}
