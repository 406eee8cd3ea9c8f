//! What happened on one branch, in numbers that fit a status message.

use serde::{Deserialize, Serialize};

/// What happened on one branch since the start; each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MuxedBusCounters {
    /// Rounds begun.
    pub rounds: u32,
    /// Rounds not begun because the one before was still busy.
    pub late: u16,
    /// Read-backs that named another channel than they should.
    pub wrong_channel: u16,
    /// Rounds ended because the multiplexer did not come free of an error.
    pub mux_failures: u16,
    /// Rounds ended because a line was held low or a transaction did not end.
    pub line_failures: u16,
}
