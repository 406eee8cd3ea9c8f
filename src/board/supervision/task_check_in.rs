//! Who still runs: the watchdog is fed only when everybody has reported.

use core::sync::atomic::{AtomicU8, Ordering};

/// A task that must run again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// What looks after buses and rounds.
    Patrol,
    /// The heartbeat.
    Beat,
    /// The program: between its inputs, and with every frame of a long step.
    Think,
}

impl Task {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Patrol, Self::Beat, Self::Think];

    const fn bit(self) -> u8 {
        match self {
            Self::Patrol => 1,
            Self::Beat => 2,
            Self::Think => 4,
        }
    }
}

/// Who has reported since the roll was called last. Shared by all tasks.
#[derive(Debug, Default)]
pub struct Roll(AtomicU8);

impl Roll {
    /// A roll on which nobody has reported.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// The task runs.
    #[inline]
    pub fn report(&self, task: Task) {
        self.0.fetch_or(task.bit(), Ordering::Relaxed);
    }

    /// Whether all have reported since the last time that this was so. If not, what was
    /// reported stays.
    #[must_use]
    pub fn call(&self) -> bool {
        let all = Task::ALL.into_iter().fold(0, |all, task| all | task.bit());
        let complete = self.0.load(Ordering::Relaxed) == all;
        if complete {
            self.0.store(0, Ordering::Relaxed);
        }
        complete
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A watchdog by the chip's manual: it resets so long after it was fed last.
    struct Watchdog {
        period_ms: u32,
        fed_ms: u32,
    }

    /// Runs the tasks at their rates until the watchdog bites; when it does, with a
    /// task that hangs from a time on.
    fn bitten_ms(hangs: Option<(Task, u32)>, period_ms: u32) -> Option<u32> {
        let roll = Roll::new();
        let mut watchdog = Watchdog {
            period_ms,
            fed_ms: 0,
        };
        let runs = |task: Task, now_ms: u32| {
            hangs.is_none_or(|(hung, since_ms)| hung != task || now_ms < since_ms)
        };
        for now_ms in 0..20_000 {
            if runs(Task::Patrol, now_ms) {
                roll.report(Task::Patrol);
            }
            if now_ms % 125 == 0 && runs(Task::Think, now_ms) {
                roll.report(Task::Think);
            }
            if now_ms % 125 == 0 && runs(Task::Beat, now_ms) {
                roll.report(Task::Beat);
                if roll.call() {
                    watchdog.fed_ms = now_ms;
                }
            }
            if now_ms - watchdog.fed_ms >= watchdog.period_ms {
                return Some(now_ms);
            }
        }
        None
    }

    #[test]
    fn f45_a_task_that_hangs_is_bitten_and_nobody_else() {
        // 500 ms nominal: 340 to 941 ms with a clock of 47 to 17 kHz.
        for period_ms in [340, 500, 941] {
            assert_eq!(bitten_ms(None, period_ms), None);
            for task in Task::ALL {
                let bitten = bitten_ms(Some((task, 10_007)), period_ms).unwrap();
                // One feeding may still follow from what was reported before.
                let latest = 10_007 + 125 + period_ms;
                assert!((10_007..=latest).contains(&bitten), "{task:?}: {bitten}");
            }
        }
    }
}
