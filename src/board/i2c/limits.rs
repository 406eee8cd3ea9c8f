//! How long, and how often.

/// Longest time without progress, microseconds. With a poll every 500 us a hang is
/// found within 900 us.
pub(super) const STALL_US: u64 = 400;

/// Longest time for a stop, microseconds; it takes 4. A part that holds SDA low in a
/// read is noticed only now, so this is short, yet leaves room for a stretched clock.
pub(super) const STOP_US: u64 = 50;

/// Time for a byte on top of [`STALL_US`], microseconds: nine bits at 400 kHz are 22.5.
pub(super) const BYTE_US: u64 = 25;

/// Waits before a dead bus is tried again, microseconds: the first, doubled up to the last.
pub(super) const BACK_OFF_US: (u64, u64) = (10_000, 1_000_000);

/// Looks at the unit in which a stop is finished: two bit times, 5 us. A look is two
/// readings over the peripheral bus, some 25 core cycles: these take 10 us at 168 MHz.
pub(super) const LOOKS: u8 = 64;

/// Useless event interrupts in a row after which the event is no longer listened to.
///
/// A repeated start leaves the old event standing until it is on the bus: some six
/// calls of half a microsecond. More than these would keep the poll from running.
pub(super) const USELESS_EVENTS: u8 = 32;
