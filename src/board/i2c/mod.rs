//! The I2C master of the F405, driven by interrupts and bounded in every wait.
//!
//! [`I2cMaster`] moves one transaction at a time, driven by interrupts and a timer. It
//! accesses the unit through [`I2cRegisters`], which tests implement with a model.
//! [`muxed_bus`] chooses the transactions of a bus of proximity sensors.
//!
//! # Calls
//!
//! | call | from | how often | instructions |
//! |---|---|---|---|
//! | [`I2cMaster::begin`] | the acquisition | once per transaction | 97 |
//! | [`I2cMaster::on_event`] | the unit's event interrupt | once per start, address and byte | 23 to 61 |
//! | [`I2cMaster::on_error`] | the unit's error interrupt | seldom | 50 |
//! | [`I2cMaster::poll`] | a timer | every 0.5 ms | 13 |
//!
//! Instructions were counted in the flash image's code at scripted registers, interrupt
//! entry not included. On top, by the bus's clock: the end of each transaction looks for
//! its stop for some 4 us, and a repeated start keeps the event interrupt up for 2.5 us.
//!
//! All four calls run at one priority, because they share the master; any priority will
//! do. The unit is only served while it holds the clock low and waits (see [`I2cMaster`]),
//! so a late interrupt costs time and no byte. After 0.4 ms without progress the poll ends
//! the transaction. No call waits longer than 10 us, except a recovery, 150 us at most.
//!
//! # Sources
//!
//! \[RM\] is ST's reference manual RM0090, chapter 27. \[ES\] is the errata sheet ES0182
//! of the F405, \[ES F1\] that of the STM32F10x, whose I2C unit is of the same design
//! and whose limitations are kept clear of here as well. None of this has been
//! verified on hardware.

mod counters;
mod limits;
mod master;
pub mod muxed_bus;
mod recovery;
mod registers;
mod stage;
mod timing;
mod transaction;

pub use counters::MasterCounters;
pub use master::I2cMaster;
pub use registers::{BusLine, I2cRegister, I2cRegisters};
pub use stage::TransferProgress;
pub use timing::I2cTiming;
pub use transaction::{BusFault, BusTransaction, LONGEST_READ, LONGEST_WRITE, clocks};
