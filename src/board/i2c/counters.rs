//! What went wrong on a bus since start.

/// Counts of faults; each stays at its greatest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MasterCounters {
    /// Times that the bus was freed by hand, or that this was tried; not the start's.
    pub recoveries: u16,
    /// Transactions that did not end in their time.
    pub overdue: u16,
    /// Addresses and bytes that nobody acknowledged.
    pub nacks: u16,
    /// Arbitrations lost.
    pub arbitration: u16,
    /// Bus errors, which the silicon also reports where there is none.
    pub bus_errors: u16,
}

/// One more, up to the greatest value.
pub(super) fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}
