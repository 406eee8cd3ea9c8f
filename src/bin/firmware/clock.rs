//! Time: the monotonic, the beats, and how long a step takes.

use core::sync::atomic::{AtomicU32, Ordering};

use amiro_ipf::event::{BoardStatus, Status};
use amiro_ipf::input::Input;
use amiro_ipf::wire::Terminal;
use cortex_m::peripheral::SYST;
use rtic_monotonics::systick::prelude::*;

use crate::budget::CAPACITY;
use crate::link::{Inbox, Outbox};

systick_monotonic!(Mono, 1_000);

/// Beats that `think` has not attended to yet.
pub(crate) static BEATS: BeatCounter = BeatCounter(AtomicU32::new(0));

/// Counts from one task to another.
pub(crate) struct BeatCounter(AtomicU32);

impl BeatCounter {
    /// One more beat.
    pub(crate) fn count(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn take(&self) -> u32 {
        self.0.swap(0, Ordering::Relaxed)
    }
}

/// What happens eight times a second, and the time that steps take.
pub(crate) struct Beats {
    cycles_per_tick: u32,
    steps_seen: u32,
    board: BoardStatus,
}

impl Beats {
    /// No beat yet, on a core of the given frequency.
    pub(crate) const fn new(core_hz: u32) -> Self {
        Self {
            cycles_per_tick: core_hz / 1000,
            steps_seen: 0,
            board: BoardStatus {
                uptime_ms: 0,
                step_cycles: 0,
                step_cycles_max: 0,
                overruns: 0,
                dropped_frames: 0,
                broken_frames: 0,
                lost_bytes: 0,
            },
        }
    }

    /// Core clock cycles since start, from the tick and the timer below it.
    ///
    /// In an emulator that counts one instruction a nanosecond these are
    /// instructions x 0.168.
    fn cycles(&self) -> u64 {
        let read = || {
            let tick = Mono::now().as_ticks();
            let below = self.cycles_per_tick - 1 - SYST::get_current();
            (
                tick,
                tick * u64::from(self.cycles_per_tick) + u64::from(below),
            )
        };
        let (tick, cycles) = read();
        if Mono::now().as_ticks() == tick {
            return cycles;
        }
        // The tick passed between the two readings: the next is a millisecond away.
        read().1
    }

    /// Runs `work` and, if it stepped the filter, notes how long that took.
    pub(crate) fn time<T>(
        &mut self,
        terminal: &mut Terminal<'static, CAPACITY>,
        work: impl FnOnce(&mut Terminal<'static, CAPACITY>) -> T,
    ) -> T {
        let start = self.cycles();
        let result = work(terminal);
        let steps = terminal.node().status().steps;
        if steps != self.steps_seen {
            let cycles = (self.cycles() - start).min(u64::from(u32::MAX)) as u32;
            let max = if steps > self.steps_seen {
                self.board.step_cycles_max
            } else {
                0
            };
            self.board.step_cycles = cycles;
            self.board.step_cycles_max = max.max(cycles);
            self.steps_seen = steps;
        }
        result
    }

    /// If a beat has passed: the board's own tick, if it is to make them, and a status.
    pub(crate) fn attend(
        &mut self,
        terminal: &mut Terminal<'static, CAPACITY>,
        inbox: &Inbox,
        outbox: &mut Outbox,
    ) {
        let beats = BEATS.take();
        if beats == 0 {
            return;
        }
        self.board.uptime_ms = Mono::now().as_ticks();
        if terminal.node().status().own_ticks {
            let tick = Input::Tick {
                stamp_us: self.board.uptime_ms * 1000,
            };
            self.board.overruns = self.board.overruns.wrapping_add(beats - 1);
            self.time(terminal, |terminal| {
                terminal.inject(&tick, &mut |frame, importance| {
                    outbox.send(frame, importance)
                });
            });
        }
        self.board.dropped_frames = outbox.dropped();
        self.board.broken_frames = terminal.broken_frames();
        self.board.lost_bytes = inbox.lost();
        let status = Status {
            node: *terminal.node().status(),
            board: self.board,
        };
        terminal.report(status, &mut |frame, importance| {
            outbox.send(frame, importance)
        });
    }
}
