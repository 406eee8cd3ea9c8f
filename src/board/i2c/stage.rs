//! The progress of a transaction.

use crate::board::i2c::BusFault;

/// State of the master after a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferProgress {
    /// No transaction is under way.
    Idle,
    /// The transaction goes on.
    Running,
    /// The transaction has just ended, see [`result`](super::I2cMaster::result). Returned
    /// once per transaction.
    Done,
    /// Not begun: another transaction is under way.
    Refused,
}

/// Direction of the data after the address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Write,
    Read,
}

/// What the unit does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Idle,
    /// A start is requested; then the address.
    Start(Direction),
    /// The address is out; then its acknowledgement.
    Address(Direction),
    Writing,
    Reading,
    /// A stop is requested, after which the transaction has this outcome.
    Stop(Result<(), BusFault>),
}
