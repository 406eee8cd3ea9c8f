//! The robot's bus: the controller of CAN1, without a wait.
//!
//! Everything here is bounded: a call reads and writes some registers and returns, and
//! what takes time is looked for at the next [`Controller::patrol`]. The crate `bxcan`
//! does not serve: several of its calls, leaving initialisation among them, poll until
//! the unit answers, which without a bus or in an emulator is never.

mod controller;
mod filters;
mod mailboxes;
mod registers;
mod timing;

pub use controller::{CanHealth, Controller};
pub use registers::{Register, Registers};
pub use timing::BitTiming;
