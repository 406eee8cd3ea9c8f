//! The watchdog is fed only after every task has checked in.

use core::sync::atomic::{AtomicU8, Ordering};

/// A task that must run periodically.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The task that serves deadlines and sensor rounds.
    Poll,
    /// The heartbeat.
    Heartbeat,
    /// The program; it checks in between its inputs and with every frame of a long step.
    Run,
}

impl Task {
    /// All tasks.
    pub const ALL: [Self; 3] = [Self::Poll, Self::Heartbeat, Self::Run];

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// The tasks that have checked in since the watchdog was last fed. Shared by all tasks.
#[derive(Debug, Default)]
pub struct TaskCheckIn(AtomicU8);

impl TaskCheckIn {
    /// No task has checked in.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// Notes that the task runs.
    #[inline]
    pub fn check_in(&self, task: Task) {
        self.0.fetch_or(task.bit(), Ordering::Relaxed);
    }

    /// Whether all tasks have checked in; if so, starts again. Otherwise those that have
    /// stay checked in.
    #[must_use]
    pub fn all_checked_in(&self) -> bool {
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

    /// When the watchdog resets the chip, with the tasks at their rates and one that may
    /// hang from a time on.
    fn reset_ms(hang: Option<(Task, u32)>, period_ms: u32) -> Option<u32> {
        let tasks = TaskCheckIn::new();
        let mut fed_ms = 0;
        let runs = |task: Task, now_ms: u32| {
            hang.is_none_or(|(hung, since_ms)| hung != task || now_ms < since_ms)
        };
        (0..20_000).find(|&now_ms| {
            for task in Task::ALL {
                if (task == Task::Poll || now_ms % 125 == 0) && runs(task, now_ms) {
                    tasks.check_in(task);
                }
            }
            if now_ms % 125 == 0 && runs(Task::Heartbeat, now_ms) && tasks.all_checked_in() {
                fed_ms = now_ms;
            }
            now_ms - fed_ms >= period_ms
        })
    }

    #[test]
    fn f45_a_hung_task_ends_in_a_reset_and_running_tasks_do_not() {
        // 500 ms nominal: 340 to 941 ms with a clock of 47 to 17 kHz.
        for period_ms in [340, 500, 941] {
            assert_eq!(reset_ms(None, period_ms), None);
            for task in Task::ALL {
                let at_ms = reset_ms(Some((task, 10_007)), period_ms).unwrap();
                // One feeding may still follow from the check-ins before.
                let latest = 10_007 + 125 + period_ms;
                assert!((10_007..=latest).contains(&at_ms), "{task:?}: {at_ms}");
            }
        }
    }
}
