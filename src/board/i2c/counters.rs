//! Counts of a master's faults since start.

/// Counts of faults; each stays at its greatest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MasterCounters {
    /// Attempts to free the bus by hand, except the one at the start.
    pub recoveries: u16,
    /// Transactions that did not end in their time.
    pub overdue: u16,
    /// Addresses and bytes without acknowledgement.
    pub nacks: u16,
    /// Arbitrations lost.
    pub arbitration: u16,
    /// Bus errors, which the silicon also reports spuriously.
    pub bus_errors: u16,
}

/// Adds one, up to the greatest value.
pub(super) fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}
