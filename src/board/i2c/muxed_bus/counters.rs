//! What happened on one multiplexed bus.

/// Counters of one bus since the start; each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MuxedBusCounters {
    /// Rounds begun.
    pub rounds: u32,
    /// Rounds not begun because the one before was still busy.
    pub late: u16,
    /// Read-backs that named another channel than they should.
    pub wrong_channel: u16,
    /// Rounds that ended because the multiplexer could not be deselected after an error.
    pub mux_failures: u16,
    /// Rounds that ended because a line was held low or a transaction did not end.
    pub line_failures: u16,
}
