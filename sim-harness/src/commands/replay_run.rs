//! Where a replay runs: on the host's node, or on a board beside it.

use std::cell::RefCell;
use std::error::Error;

use amiro_ipf::link::{Encoder, Message};
use amiro_ipf::node::{Config, Event, Input};
use sim_harness::device::{
    Comparison, FaultInjector, HOST_NODE_BOOT_ID, LineRun, Verdict, drive_streamed, listen,
};
use sim_harness::log::StoredRecording;
use sim_harness::spool::{EventSpool, Spool};
use sim_harness::{RunOutcome, Survey, console, run_streamed};

use super::connect;
use super::replay::{Replay, progress};
use super::standstill::StandstillCheck;

/// Cycles of a core that an emulator lets run at one instruction a nanosecond.
const NANOSECONDS_PER_CYCLE: f64 = 1e9 / 168e6;

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
    pub(super) survey: Survey,
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
    fn new(is_scored: bool) -> Self {
        Self {
            resets: 0,
            all: is_scored.then(EventSpool::default),
        }
    }

    fn take(&mut self, event: &Event) {
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
        let bar = progress("compared", Some(recording.length()));
        let mut recorded = recording.messages(|bytes| bar.set_position(bytes))?;
        recorded
            .by_ref()
            .for_each(|message| comparison.meet(&message));
        recorded.finish()?;
        bar.finish_and_clear();
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

/// On a board or in QEMU, held against the host's own run.
pub(super) fn on_board(
    replay: &Replay,
    plan: &Plan<'_>,
    recording: &mut StoredRecording,
) -> Result<Replayed, Box<dyn Error>> {
    let mut board = replay.board(plan.config)?;
    connect::greet(&mut board)?;
    connect::check_capacity(&board, plan.config)?;
    let mut comparison = Comparison::default();
    let standstill = expect_host(replay, plan, recording, &mut comparison)?;
    let comparison = RefCell::new(comparison);
    let mut survey = replay.survey(plan);
    let mut events = KeptEvents::new(plan.is_scored);
    let mut answered = Spool::default();
    let mut slowest_step = 0;
    let bar = progress("replayed", Some(recording.length()));
    let mut inputs = recording.inputs(|bytes| bar.set_position(bytes))?;
    let configured = std::iter::once(Input::Configure(*plan.config));
    let driven = drive_streamed(
        &mut board,
        configured.chain(replay.replayed(&mut inputs)?),
        |message| {
            comparison.borrow_mut().meet(message);
            match message {
                Message::Event(event) => {
                    survey.take(event);
                    events.take(event);
                }
                Message::Status(status) => {
                    slowest_step = slowest_step.max(status.board.step_cycles_max);
                }
                _ => {}
            }
        },
        |input, refused| comparison.borrow_mut().meet_answer(input, refused),
        Some(&mut answered),
    );
    bar.finish_and_clear();
    let mut comparison = comparison.into_inner();
    comparison.take_audit(driven?);
    inputs.finish()?;
    listen(&mut board, |message| comparison.meet(message))?;
    if replay.count_instructions {
        let instructions = f64::from(slowest_step) * NANOSECONDS_PER_CYCLE / 1e6;
        console::print(format_args!(
            "longest step: {instructions:.2} million instructions (emulated)"
        ));
    }
    console::print_text(board.tally());
    answered.write(&board.take_raw());
    Ok(Replayed {
        ran_on: ran_on(replay),
        survey,
        events,
        answered,
        comparison: Some(comparison.verdict(board.boot(), &board.tally())),
        standstill,
    })
}

fn ran_on(replay: &Replay) -> &'static str {
    match replay.on.as_str() {
        "qemu" => "QEMU (emulated)",
        _ => "board",
    }
}

/// Runs the host's node for a comparison with a board.
fn expect_host(
    replay: &Replay,
    plan: &Plan<'_>,
    recording: &mut StoredRecording,
    comparison: &mut Comparison,
) -> Result<StandstillCheck, Box<dyn Error>> {
    let mut standstill = StandstillCheck::default();
    let mut refusals = Vec::new();
    let mut inputs = recording.inputs(|_| ())?;
    let replayed = replay
        .replayed(&mut inputs)?
        .inspect(|input| standstill.take(input));
    let outcome = run_streamed(
        plan.config,
        replayed,
        |event| comparison.expect(event),
        // The configuration goes in front.
        |input, fault| refusals.push((input + 1, fault)),
    )?;
    inputs.finish()?;
    warn_of_refused_inputs(&outcome);
    comparison.expect_refusals(&refusals);
    Ok(standstill)
}

fn warn_of_refused_inputs(outcome: &RunOutcome) {
    for (fault, count) in outcome.faults() {
        console::warn(format_args!("{count} inputs refused: {fault:?}, {fault}"));
    }
}
