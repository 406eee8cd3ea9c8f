//! How far a transaction is.

use crate::board::i2c::BusFault;

/// What a call has led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferProgress {
    /// No transaction is under way.
    Idle,
    /// The transaction goes on.
    Running,
    /// The transaction has just ended: [`result`](super::I2cMaster::result). Said once for each.
    Done,
    /// Not begun: another transaction is under way.
    Refused,
}

/// Which way data go after the address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Write,
    Read,
}

/// What the unit is asked to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Idle,
    /// A start is asked for; then the address.
    Start(Direction),
    /// The address is out; then its acknowledgement.
    Address(Direction),
    Writing,
    Reading,
    /// A stop is asked for, after which the transaction has ended thus.
    Stop(Result<(), BusFault>),
}
