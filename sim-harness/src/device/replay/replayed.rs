//! What a replay gives wherever it runs.

use amiro_ipf::link::Status;
use amiro_ipf::node::Event;

use crate::device::{FrameTally, LineTally, Verdict};
use crate::drive::InputCheck;
use crate::spool::{EventSpool, Spool};
use crate::{RunOutcome, RunRecord};

/// What came of a replay.
#[derive(Debug)]
pub struct Replayed {
    /// Map, path and counts.
    pub run_record: RunRecord,
    /// What of the events the run record does not keep.
    pub events: KeptEvents,
    /// The bytes of what was answered.
    pub answered: Spool,
    /// The board's run, or the recorded one, against this host's.
    pub comparison: Option<Verdict>,
    /// What the inputs were, to say why there are no steps.
    pub input_check: InputCheck,
    /// The run of the host's node.
    pub outcome: RunOutcome,
    /// What became of the frames, as the receiver counts and as the line knows, where the
    /// line had faults.
    pub line: Option<(FrameTally, LineTally)>,
    /// What a board's steps took; nothing for a replay on the host.
    pub step_cycles: StepCycles,
}

/// Core clock cycles of a board's steps, as its statuses report them.
///
/// The longest is over all steps. The mean is over the steps that were the last one before
/// a status, since a status holds the cycles of the last step: with
/// [`Pace::StatusPerStep`](crate::device::Pace) over all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCycles {
    /// The longest step.
    pub longest: u32,
    /// Steps that the mean is over.
    pub counted: u32,
    sum: u64,
    last_step: u32,
}

impl StepCycles {
    /// Takes a status.
    pub(super) fn take(&mut self, status: &Status) {
        self.longest = self.longest.max(status.board.step_cycles_max);
        if status.node.steps != self.last_step {
            self.last_step = status.node.steps;
            self.counted += 1;
            self.sum += u64::from(status.board.step_cycles);
        }
    }

    /// Steps that the board has made, as its last status reports them.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.last_step
    }

    /// The mean step; `None` without one.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.counted > 0).then(|| self.sum as f64 / f64::from(self.counted))
    }
}

/// What of a run's events is needed besides the run record.
#[derive(Debug)]
pub struct KeptEvents {
    /// How often the odometry was reset.
    pub resets: usize,
    /// All of them, for the scores on the way, where the recording carries a truth.
    pub all: Option<EventSpool>,
}

impl KeptEvents {
    pub(super) fn new(is_scored: bool) -> Self {
        Self {
            resets: 0,
            all: is_scored.then(EventSpool::default),
        }
    }

    pub(super) fn take(&mut self, event: &Event) {
        self.resets += usize::from(matches!(event, Event::OdometryReset { .. }));
        if let Some(all) = &mut self.all {
            all.push(event);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_step_counts_each_step_once() {
        let status = |steps, step_cycles, step_cycles_max| {
            let mut status = Status::default();
            status.node.steps = steps;
            status.board.step_cycles = step_cycles;
            status.board.step_cycles_max = step_cycles_max;
            status
        };
        let mut cycles = StepCycles::default();
        assert_eq!(cycles.mean(), None);
        // No step yet; then one that two statuses report; then a step was missed.
        for status in [
            status(0, 0, 0),
            status(1, 30, 30),
            status(1, 30, 30),
            status(3, 10, 50),
        ] {
            cycles.take(&status);
        }
        assert_eq!((cycles.longest, cycles.counted), (50, 2));
        assert_eq!(cycles.steps(), 3);
        assert_eq!(cycles.mean(), Some(20.0));
    }
}
