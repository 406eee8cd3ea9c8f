//! The state of the CAN controller.

use serde::{Deserialize, Serialize};

/// State of the CAN controller. Variants are appended, never reordered: they may go
/// over the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanState {
    /// The controller does not answer, or was not polled yet.
    #[default]
    Absent,
    /// It is being set up, or waits for the bus to be idle.
    Joining,
    /// It is on the bus.
    On,
    /// It is off the bus after too many errors, until the bus recovers.
    BusOff,
}
