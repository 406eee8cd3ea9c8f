//! A replay on the host's node, and what a replay gives wherever it runs.

use std::error::Error;

use amiro_ipf::link::Encoder;
use amiro_ipf::node::{Config, Event};
use sim_harness::device::{Comparison, FaultInjector, HOST_NODE_BOOT_ID, LineRun, Verdict};
use sim_harness::log::StoredRecording;
use sim_harness::spool::{EventSpool, Spool};
use sim_harness::{RunOutcome, RunRecord, console, run_streamed};

use super::replay::{Replay, progress};
use super::standstill::StandstillCheck;

/// How a recording is replayed, besides the options.
pub(super) struct Plan<'a> {
    pub(super) config: &'a Config,
    /// Size of the map's cells, metres.
    pub(super) cell_m: f64,
    /// Whether the events are kept for the scores on the way.
    pub(super) is_scored: bool,
}

/// Where the filter ran, and what came of it.
pub(super) struct Replayed {
    pub(super) ran_on: &'static str,
    pub(super) survey: RunRecord,
    pub(super) events: KeptEvents,
    /// The bytes of what was answered.
    pub(super) answered: Spool,
    pub(super) comparison: Option<Verdict>,
    pub(super) standstill: StandstillCheck,
}

/// What of a run's events the report needs besides the survey.
pub(super) struct KeptEvents {
    /// How often the odometry was reset.
    pub(super) resets: usize,
    /// All of them, for the scores on the way, where the recording carries a truth.
    pub(super) all: Option<EventSpool>,
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

/// On the host's node; recorded events of the same configuration must be met.
pub(super) fn on_host(
    replay: &Replay,
    plan: &Plan<'_>,
    recording: &mut StoredRecording,
) -> Result<Replayed, Box<dyn Error>> {
    let overview = recording.overview();
    let is_recorded = overview.config.is_some() && overview.steps > 0 && replay.is_as_recorded();
    let mut survey = replay.survey(plan);
    let mut events = KeptEvents::new(plan.is_scored);
    let mut line = replay
        .has_line_faults()
        .then(|| LineRun::new(FaultInjector::new(&replay.fault, replay.seed_of_faults)));
    let mut encoder = Encoder::new(HOST_NODE_BOOT_ID);
    let mut answered = Spool::default();
    let mut comparison = Comparison::default();
    let mut standstill = StandstillCheck::default();
    let mut arrive = |event: &Event| {
        survey.take(event);
        events.take(event);
    };
    let bar = progress("replayed", Some(recording.length()));
    let mut inputs = recording.inputs(|bytes| bar.set_position(bytes))?;
    let replayed = replay
        .replayed(&mut inputs)?
        .inspect(|input| standstill.take(input));
    let on_event = |event: &Event| {
        if is_recorded {
            comparison.expect(event);
        }
        if let Some(line) = &mut line {
            line.send(event, &mut arrive);
            line.move_bytes(&mut answered);
        } else {
            answered.write(encoder.encode(event));
            arrive(event);
        }
    };
    let outcome = run_streamed(plan.config, replayed, on_event, |_, _| ())?;
    inputs.finish()?;
    let arrived = line.map(|line| line.finish(&mut arrive));
    bar.finish_and_clear();
    if let Some(arrived) = arrived {
        answered.write(&arrived.bytes);
        let (frames, line) = (arrived.frames, arrived.line);
        console::print(format_args!("{frames}; {} damaged", line.damaged));
        frames.balance(line.sent)?;
    }
    warn_of_refused_inputs(&outcome);
    if is_recorded {
        meet_recorded(recording, &mut comparison)?;
    }
    Ok(Replayed {
        ran_on: "host",
        survey,
        events,
        answered,
        comparison: is_recorded.then(|| comparison.verdict_of_recording()),
        standstill,
    })
}

/// Compares the recorded messages with the host's run.
fn meet_recorded(
    recording: &mut StoredRecording,
    comparison: &mut Comparison,
) -> Result<(), Box<dyn Error>> {
    let bar = progress("compared", Some(recording.length()));
    let mut recorded = recording.messages(|bytes| bar.set_position(bytes))?;
    recorded
        .by_ref()
        .for_each(|message| comparison.meet(&message));
    recorded.finish()?;
    bar.finish_and_clear();
    Ok(())
}

pub(super) fn warn_of_refused_inputs(outcome: &RunOutcome) {
    for (fault, count) in outcome.faults() {
        console::warn(format_args!("{count} inputs refused: {fault:?}, {fault}"));
    }
}
