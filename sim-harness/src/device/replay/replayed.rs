//! What a replay gives wherever it runs.

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
    /// Core clock cycles of a board's longest step; 0 for a replay on the host.
    pub slowest_step_cycles: u32,
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
