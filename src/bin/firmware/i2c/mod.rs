//! The I2C master of the F405, driven by interrupts and bounded in every wait.
//!
//! [`Master`] is told of interrupts and of time and moves one transaction; what it
//! does to the silicon goes through [`Registers`], so that a host can stand in.
//!
//! # Who calls what
//!
//! | call | from | how often |
//! |---|---|---|
//! | [`Master::begin`] | whoever has a transaction | once each |
//! | [`Master::on_event`] | the unit's event interrupt | once a byte, a start, an address |
//! | [`Master::on_error`] | the unit's error interrupt | seldom |
//! | [`Master::patrol`] | a timer | every 0.5 ms |
//!
//! All four belong to one priority, for they share the master. That priority is free:
//! the unit is only ever served while it holds the clock low and waits (see
//! [`Master`]), so a late interrupt costs time and no byte. The time has an end: 0.4 ms
//! without progress and the patrol ends the transaction.
//!
//! # Sources
//!
//! \[RM\] is ST's reference manual RM0090, chapter 27. \[ES\] is the errata sheet ES0182
//! of the F405, \[ES F1\] that of the STM32F10x, whose I2C unit is of the same design
//! and whose limitations are kept clear of here as well. None of this has been
//! verified on hardware.

pub(crate) mod counters;
mod master;
mod recovery;
mod registers;
mod timing;

pub(crate) use master::{Master, Progress};
pub(crate) use registers::{Line, Register, Registers};
pub(crate) use timing::Timing;
