//! The interface between a bus and the parts on it.

use super::InjectedBusFault;

/// A part, or several wired together, byte by byte.
///
/// Every part gets every start, byte and stop, and answers those addressed to it. Time
/// is an argument, nanoseconds since the bus's power came up; it never goes back.
pub trait Device {
    /// A start or repeated start with an address of seven bits; whether it acknowledges.
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool;

    /// A byte from the master; returns whether it is acknowledged. A part that is not
    /// addressed does not.
    fn write(&mut self, byte: u8, now_ns: u64) -> bool;

    /// A byte for the master; all ones from a part that is not addressed.
    fn read(&mut self, now_ns: u64) -> u8;

    /// A stop.
    fn stop(&mut self, now_ns: u64);

    /// Advances the part's own processes to a time.
    fn pass(&mut self, _now_ns: u64) {}

    /// Whether it pulls its interrupt line low.
    fn interrupts(&self) -> bool {
        false
    }

    /// Injects a fault; returns whether it had an effect. A fault of another part has none.
    fn inject(&mut self, _fault: InjectedBusFault, _now_ns: u64) -> bool {
        false
    }
}
