//! The core without a board or a host: CAN, clocks, what it refuses.

#[path = "../common/mod.rs"]
mod common;

mod can;
mod can_bus;
mod clock;
mod threats;
