//! How the parts around the filter are: sensors, buses, odometry's bus.

use serde::{Deserialize, Serialize};

use crate::can::CanState;
use crate::driver::{OffsetOrigin, SensorState};
use crate::model::SENSORS;
use crate::node::SeedSource;

/// How the board's parts are, at 8 Hz beside the status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// The proximity sensors by index.
    pub sensors: [SensorHealth; SENSORS],
    /// The two I2C buses.
    pub buses: [BusHealth; 2],
    /// The bus that odometry comes over.
    pub can: CanHealth,
    /// What the seed was made of that the board began with.
    pub seed: SeedSource,
    /// Where the sensors' offsets come from.
    pub offsets: OffsetOrigin,
}

/// How one sensor is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorHealth {
    /// In a word.
    pub state: SensorState,
    /// Age of its last value, milliseconds; 255 for that and more, and for none.
    pub age_ms: u8,
    /// Rounds that ended without a value, since boot; stops at its highest value.
    pub failed: u16,
}

/// Whether a bus works. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusState {
    /// No transaction has succeeded since boot.
    #[default]
    Silent,
    /// The last transaction was acknowledged.
    Working,
    /// The last transactions failed.
    Failing,
    /// A line is held low, and nine clocks did not free it.
    HeldLow,
}

/// How a bus is; counters since boot, each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusHealth {
    /// In a word.
    pub state: BusState,
    /// Transactions that failed.
    pub failed: u16,
    /// Recoveries: nine clocks, a stop, and a reset of the bus unit.
    pub recoveries: u16,
}

/// How the robot's bus is; counters since boot, each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanHealth {
    /// The controller's state.
    pub state: CanState,
    /// Frames understood.
    pub taken: u32,
    /// Frames that said nothing that is understood.
    pub ignored: u16,
    /// Frames that came faster than they were taken.
    pub overruns: u16,
    /// Times that the controller was off the bus.
    pub bus_offs: u16,
    /// Own frames that were not sent in their time.
    pub unsent: u16,
}
