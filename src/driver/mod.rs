//! The parts on the robot's I2C buses, for anyone who has one of them.
//!
//! Each part is described once, as the [`Transaction`]s that it understands and as what
//! their answers mean. Two things execute them: a blocking bus of embedded-hal 1.0,
//! behind the drivers' methods, and the flash image's interrupts.

pub mod at24c01;
pub mod branch;
mod calibration;
mod offsets;
pub mod pca9544a;
mod proximity_sensor;
pub mod ring;
mod sensor_state;
mod transaction;
pub mod vcnl4020;
mod watch;

pub use branch::{Branch, BranchCounters};
pub use calibration::{OffsetMeasurement, OffsetRefusal, READINGS};
pub use offsets::{OFFSET_RANGE, OffsetOrigin, Offsets, STORE_BYTES, StoreFault};
pub use proximity_sensor::{
    DEFAULT_LEAST_COUNTS, DEFAULT_OFFSET, MAX_AGE_US, MISSING_AFTER, PROBE_PERIOD_US,
    ProximitySensor, TRUSTED_AFTER,
};
pub use ring::{AMIRO_PLACES, Bus, Place, ProximityRing};
pub use sensor_state::{SensorCounters, SensorFault, SensorState};
pub use transaction::{BusFault, LONGEST_READ, LONGEST_WRITE, Transaction, clocks};
pub use watch::{DAZZLING, STUCK_AFTER, Watch, is_dazzled};

#[cfg(test)]
mod fake;
