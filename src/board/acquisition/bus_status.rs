//! The state of one I2C bus, from the results of its transactions.

use crate::board::health::{BusHealth, BusState};
use crate::board::i2c::BusFault;

/// Failed transactions in a row after which a bus is reported as failing.
const FAILING_AFTER: u8 = 3;

/// Origin of the transaction that is under way on a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Requester {
    #[default]
    None,
    Ring,
    Store,
}

/// State of one bus.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BusStatus {
    pub(super) requester: Requester,
    has_worked: bool,
    held_low: bool,
    failures_in_a_row: u8,
    failed: u16,
}

impl BusStatus {
    /// Takes the result of a transaction.
    pub(super) fn on_result(&mut self, fault: Option<BusFault>) {
        let Some(fault) = fault else {
            self.has_worked = true;
            self.held_low = false;
            self.failures_in_a_row = 0;
            return;
        };
        self.held_low = fault == BusFault::HeldLow;
        self.failures_in_a_row = self.failures_in_a_row.saturating_add(1);
        self.failed = self.failed.saturating_add(1);
    }

    /// The bus's health without its recoveries, which its master counts.
    pub(super) fn health(&self) -> BusHealth {
        let state = if self.held_low {
            BusState::HeldLow
        } else if !self.has_worked {
            BusState::Silent
        } else if self.failures_in_a_row >= FAILING_AFTER {
            BusState::Failing
        } else {
            BusState::Working
        };
        BusHealth {
            state,
            failed: self.failed,
            recoveries: 0,
        }
    }
}
