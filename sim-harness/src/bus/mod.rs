//! The robot's two I2C buses as they behave on the wire, for tests and simulated robots.
//!
//! Parts ([`Vcnl4020`], [`Pca9544a`], [`At24c01`]) understand bytes, not transactions.
//! A [`FakeBus`] joins them with a clock and a [`Script`] of faults, and has two doors:
//! embedded-hal's `I2c` for drivers, and single starts, bytes and stops for a model of
//! a microcontroller's I2C unit. [`RobotBuses`] are the AMiRo's, populated.
//!
//! Not modelled: rise times, voltages, other masters, and what a part does after a
//! START or STOP in the middle of a byte.

mod at24c01;
mod device;
mod fake_bus;
mod fault;
mod master;
mod pca9544a;
mod robot;
mod script;
mod transcript;
mod vcnl4020;

pub use at24c01::{At24c01, MEMORY_BYTES, PAGE_BYTES, WRITE_CYCLE_NS};
pub use device::Device;
pub use fake_bus::{FakeBus, LineFault};
pub use fault::{Fault, MuxFault, SensorFault};
pub use master::FakeBusError;
pub use pca9544a::Pca9544a;
pub use robot::{Place, RobotBuses, RobotParts, place_of};
pub use script::{Outages, Random, Script};
pub use transcript::{Transcript, Word};
pub use vcnl4020::Vcnl4020;
