//! Time: the monotonic, the heartbeat counter, and how long work takes.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use rtic_monotonics::systick::prelude::*;

/// Ticks per second: a hanging bus is detected within two of them.
const TICK_HZ: u32 = 2_000;

systick_monotonic!(Mono, 2_000);

/// Heartbeats, 8 per second, that `run` has not handled yet.
pub(crate) static HEARTBEATS: HeartbeatCounter = HeartbeatCounter(AtomicU32::new(0));

/// A counter that one task increments and another takes.
pub(crate) struct HeartbeatCounter(AtomicU32);

impl HeartbeatCounter {
    /// Counts one heartbeat.
    pub(crate) fn count(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// The heartbeats since the last call.
    pub(crate) fn take(&self) -> u32 {
        self.0.swap(0, Ordering::Relaxed)
    }
}

/// Time since start, milliseconds; wraps after 292 million years.
pub(crate) fn uptime_ms() -> u64 {
    Mono::now().as_ticks() / u64::from(TICK_HZ / 1_000)
}

/// Time since start in ticks and in core clock cycles below a tick.
fn tick_and_cycles(cycles_per_tick: u32) -> (u64, u32) {
    let read = || {
        let tick = Mono::now().as_ticks();
        (tick, cycles_per_tick - 1 - SYST::get_current())
    };
    let time = read();
    if Mono::now().as_ticks() == time.0 {
        return time;
    }
    // The tick passed between the two readings: the next is half a millisecond away.
    read()
}

/// A clock in microseconds.
#[derive(Clone, Copy)]
pub(crate) struct Microseconds {
    cycles_per_tick: u32,
    cycles_per_us: u32,
}

impl Microseconds {
    /// A clock on a core of the given frequency.
    pub(crate) const fn new(core_hz: u32) -> Self {
        Self {
            cycles_per_tick: core_hz / TICK_HZ,
            cycles_per_us: core_hz / 1_000_000,
        }
    }

    /// Time since start.
    pub(crate) fn now(self) -> u64 {
        let (tick, cycles) = tick_and_cycles(self.cycles_per_tick);
        tick * u64::from(1_000_000 / TICK_HZ) + u64::from(cycles / self.cycles_per_us)
    }
}

/// Counts the core's clock cycles.
pub(crate) struct CycleCounter {
    cycles_per_tick: u32,
}

impl CycleCounter {
    /// A counter on a core of the given frequency.
    pub(crate) const fn new(core_hz: u32) -> Self {
        Self {
            cycles_per_tick: core_hz / TICK_HZ,
        }
    }

    /// Core clock cycles since start, from the tick and the timer below it.
    ///
    /// In an emulator that counts one instruction per nanosecond these are
    /// instructions x 0.168.
    pub(crate) fn now(&self) -> u64 {
        let (tick, cycles) = tick_and_cycles(self.cycles_per_tick);
        tick * u64::from(self.cycles_per_tick) + u64::from(cycles)
    }
}
