//! A replay on a board or in QEMU, compared with the host's own run.

use std::cell::RefCell;
use std::error::Error;

use amiro_ipf::link::Message;
use amiro_ipf::node::Input;
use sim_harness::device::{Comparison, drive_streamed, listen};
use sim_harness::log::StoredRecording;
use sim_harness::spool::Spool;
use sim_harness::{console, run_streamed};

use super::connect;
use super::replay::{Replay, progress};
use super::replay_run::{KeptEvents, Plan, Replayed, warn_of_refused_inputs};
use super::standstill::StandstillCheck;

/// Cycles of a core that an emulator lets run at one instruction a nanosecond.
const NANOSECONDS_PER_CYCLE: f64 = 1e9 / 168e6;

/// On a board or in QEMU, compared with the host's own run.
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
