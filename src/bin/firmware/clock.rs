//! Time: the monotonic, the beats, and how long work takes.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use rtic_monotonics::systick::prelude::*;

systick_monotonic!(Mono, 1_000);

/// Beats, eight a second, that nobody has attended to yet.
pub(crate) static BEATS: BeatCounter = BeatCounter(AtomicU32::new(0));

/// Counts from one task to another.
pub(crate) struct BeatCounter(AtomicU32);

impl BeatCounter {
    /// One more beat.
    pub(crate) fn count(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// The beats since the last call.
    pub(crate) fn take(&self) -> u32 {
        self.0.swap(0, Ordering::Relaxed)
    }
}

/// Time since start, milliseconds; wraps after 584 million years.
pub(crate) fn uptime_ms() -> u64 {
    Mono::now().as_ticks()
}

/// Counts the core's clock cycles.
pub(crate) struct CycleCounter {
    cycles_per_tick: u32,
}

impl CycleCounter {
    /// A counter on a core of the given frequency.
    pub(crate) const fn new(core_hz: u32) -> Self {
        Self {
            cycles_per_tick: core_hz / 1000,
        }
    }

    /// Core clock cycles since start, from the tick and the timer below it.
    ///
    /// In an emulator that counts one instruction a nanosecond these are
    /// instructions x 0.168.
    pub(crate) fn now(&self) -> u64 {
        let read = || {
            let tick = uptime_ms();
            let below = self.cycles_per_tick - 1 - SYST::get_current();
            (
                tick,
                tick * u64::from(self.cycles_per_tick) + u64::from(below),
            )
        };
        let (tick, cycles) = read();
        if uptime_ms() == tick {
            return cycles;
        }
        // The tick passed between the two readings: the next is a millisecond away.
        read().1
    }
}
