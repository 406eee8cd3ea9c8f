//! The report on the board's parts: sensors, I2C buses, CAN bus.

use serde::{Deserialize, Serialize};

use crate::board::can::CanState;
use crate::board::offsets::OffsetOrigin;
use crate::board::sensor_state::SensorState;
use crate::model::SENSORS;
use crate::node::SeedSource;

/// Health of the board's parts, sent at 8 Hz beside the status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// The proximity sensors by index.
    pub sensors: [SensorHealth; SENSORS],
    /// The two I2C buses.
    pub buses: [BusHealth; 2],
    /// The CAN bus, which carries the odometry.
    pub can: CanHealth,
    /// Source of the board's first seed.
    pub seed: SeedSource,
    /// Where the sensors' offsets come from.
    pub offsets: OffsetOrigin,
}

/// Health of one sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorHealth {
    /// Its state.
    pub state: SensorState,
    /// Age of its last value, milliseconds; 255 also for older ones and for none.
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

/// Health of an I2C bus; counters since boot, each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusHealth {
    /// Its state.
    pub state: BusState,
    /// Transactions that failed.
    pub failed: u16,
    /// Recoveries: nine clocks, a stop, and a reset of the bus unit.
    pub recoveries: u16,
}

/// Health of the CAN bus; counters since boot, each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanHealth {
    /// The controller's state.
    pub state: CanState,
    /// Frames decoded.
    pub taken: u32,
    /// Frames that were not for this board, or damaged.
    pub ignored: u16,
    /// Frames lost because they came faster than they were taken.
    pub overruns: u16,
    /// Times that the controller was off the bus.
    pub bus_offs: u16,
    /// Own frames that were not sent in their time.
    pub unsent: u16,
}
