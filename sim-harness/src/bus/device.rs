//! What a bus asks of the parts on it.

use super::InjectedBusFault;

/// A part, or several wired together, as the bus sees it: byte by byte.
///
/// Every part sees every start, byte and stop, and answers those that concern it. Time
/// is an argument, nanoseconds since the bus's power came up; it never goes back.
pub trait Device {
    /// A start or repeated start with an address of seven bits; whether it acknowledges.
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool;

    /// A byte from the master; whether it is acknowledged. Not so by who is not addressed.
    fn write(&mut self, byte: u8, now_ns: u64) -> bool;

    /// A byte for the master; all ones from who is not addressed.
    fn read(&mut self, now_ns: u64) -> u8;

    /// A stop.
    fn stop(&mut self, now_ns: u64);

    /// Time passes: whatever the part does by itself until then.
    fn pass(&mut self, _now_ns: u64) {}

    /// Whether it pulls its interrupt line low.
    fn interrupts(&self) -> bool {
        false
    }

    /// A fault strikes; whether it made a difference, which another part's does not.
    fn inject(&mut self, _fault: InjectedBusFault, _now_ns: u64) -> bool {
        false
    }
}
