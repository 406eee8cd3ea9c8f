//! The robot's two I2C buses as they behave on the wire, for tests and simulated robots.
//!
//! Parts ([`Vcnl4020Model`], [`Pca9544aModel`], [`At24c01Model`]) understand bytes, not
//! transactions. A [`FakeBus`] joins them with a clock and a [`Script`] of faults, and has
//! two interfaces: embedded-hal's `I2c` for drivers, and single starts, bytes and stops for
//! a model of a microcontroller's I2C unit. [`RobotBuses`] are the AMiRo's, populated.
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

pub use at24c01::{At24c01Model, MEMORY_BYTES, PAGE_BYTES, WRITE_CYCLE_NS};
pub use device::Device;
pub use fake_bus::{FakeBus, LineFault};
pub use fault::{InjectedBusFault, MuxFault, Vcnl4020Fault};
pub use master::FakeBusError;
pub use pca9544a::Pca9544aModel;
pub use robot::{RobotBuses, RobotParts, on_sensor};
pub use script::{Outages, Random, Script};
pub use transcript::{Transcript, Word};
pub use vcnl4020::Vcnl4020Model;
