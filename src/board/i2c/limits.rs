//! Time limits and repetition limits of the master.

/// Longest time without progress, microseconds. With a poll every 500 us a hang is
/// detected within 900 us.
pub(super) const STALL_US: u64 = 400;

/// Longest time for a stop, microseconds; it takes 4. A part that holds SDA low in a
/// read is detected only here, so this is short, yet leaves room for a stretched clock.
pub(super) const STOP_US: u64 = 50;

/// Time for a byte on top of [`STALL_US`], microseconds: nine bits at 400 kHz are 22.5.
pub(super) const BYTE_US: u64 = 25;

/// Waits before a held bus is retried, microseconds: the first, doubled up to the last.
pub(super) const BACK_OFF_US: (u64, u64) = (10_000, 1_000_000);

/// Polls of the unit within which a stop is finished: two bit times, 5 us. A poll is two
/// reads over the peripheral bus, about 25 core cycles: these take 10 us at 168 MHz.
pub(super) const LOOKS: u8 = 64;

/// Useless event interrupts in a row after which the event interrupt is disabled.
///
/// A repeated start leaves the old event set until it is on the bus: about six calls of
/// half a microsecond. Many more would keep the poll from running.
pub(super) const USELESS_EVENTS: u8 = 32;
