//! The parts on the robot's I2C buses, without a bus.
//!
//! The crates [`vcnl4020`] and [`pca9544a`] and the module [`at24c01`] describe a part
//! each: the transactions that it accepts and the meaning of their answers. [`Branch`] and
//! [`ProximityRing`] choose the next [`Transaction`] of a bus and take its result. The
//! flash image's interrupts execute them, or a simulated bus.

pub mod at24c01;
pub mod branch;
mod calibration;
mod offsets;
mod proximity_sensor;
pub mod ring;
mod sensor_state;
mod settings;
mod transaction;
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
pub use settings::{MUX_ADDRESS, SENSOR_CONFIGURATION};
pub use transaction::{BusFault, LONGEST_READ, LONGEST_WRITE, Transaction, clocks};
pub use watch::{DAZZLING, STUCK_AFTER, Watch, is_dazzled};

pub use {pca9544a, vcnl4020};
