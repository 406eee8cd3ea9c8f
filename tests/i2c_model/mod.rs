//! A bus of the board on a host: the F405's I2C unit, a part, and time.

mod bench;
mod part;
mod unit;

pub(crate) use bench::{Bench, PATROL_NS};
pub(crate) use part::{Part, Seen};
pub(crate) use unit::{FOR_EVER, Fault, Stuck, Unit};

/// A part on the bus, byte by byte. Times are microseconds.
pub(crate) trait Device {
    /// A start with an address; whether the part acknowledges.
    fn start(&mut self, address: u8, read: bool, now_us: u64) -> bool;
    /// A byte comes in; whether the part acknowledges.
    fn write(&mut self, byte: u8, now_us: u64) -> bool;
    /// A byte goes out.
    fn read(&mut self, now_us: u64) -> u8;
    /// A stop.
    fn stop(&mut self, now_us: u64);
}
