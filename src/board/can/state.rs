//! How the robot's bus is.

use serde::{Deserialize, Serialize};

/// State of the bus's controller. Variants are appended, never reordered: they may go
/// over the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanState {
    /// The controller does not answer, or nobody has asked it yet.
    #[default]
    Absent,
    /// It is being set up, or waits for the bus to be idle.
    Joining,
    /// It takes part.
    On,
    /// It saw too many errors and keeps silent until the bus is well.
    BusOff,
}
