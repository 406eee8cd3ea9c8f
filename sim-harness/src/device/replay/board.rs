//! A replay on a board or in QEMU, compared with the host's own run.

use std::cell::RefCell;

use amiro_ipf::link::Message;
use amiro_ipf::node::Input;

use super::{KeptEvents, ReplayError, ReplayPass, ReplayPlan, Replayed, StepCycles};
use crate::device::{Board, Comparison, Pace, drive_streamed, listen};
use crate::drive::InputCheck;
use crate::log::StoredRecording;
use crate::spool::Spool;
use crate::{RunOutcome, run_streamed};

/// Replays a recording on a greeted board, compared with the host's own run.
///
/// With [`Pace::StatusPerStep`] each step is measured.
///
/// `on_bytes` gets the bytes of the recording that a pass has read so far.
///
/// # Errors
/// As [`drive_streamed`] and [`run`](crate::run()); a recording that cannot be read again.
pub fn replay_on_board(
    plan: &ReplayPlan<'_>,
    board: &mut Board,
    pace: Pace,
    recording: &mut StoredRecording,
    on_bytes: &mut dyn FnMut(ReplayPass, u64),
) -> Result<Replayed, ReplayError> {
    let mut comparison = Comparison::default();
    let (outcome, input_check) = expect_host(plan, recording, &mut comparison)?;
    let comparison = RefCell::new(comparison);
    let mut run_record = plan.run_record();
    let mut events = KeptEvents::new(plan.is_scored);
    let mut answered = Spool::default();
    let mut step_cycles = StepCycles::default();
    let mut inputs = recording.inputs(|bytes| on_bytes(ReplayPass::Replay, bytes))?;
    let configured = std::iter::once(Input::Configure(*plan.config));
    let driven = drive_streamed(
        board,
        pace,
        configured.chain(plan.inputs(&mut inputs)?),
        |message| {
            comparison.borrow_mut().meet(message);
            match message {
                Message::Event(event) => {
                    run_record.take(event);
                    events.take(event);
                }
                Message::Status(status) => step_cycles.take(status),
                _ => {}
            }
        },
        |input, refused| comparison.borrow_mut().meet_answer(input, refused),
        Some(&mut answered),
    );
    let mut comparison = comparison.into_inner();
    comparison.take_audit(driven?);
    inputs.finish()?;
    listen(board, |message| comparison.meet(message))?;
    answered.write(&board.take_raw());
    Ok(Replayed {
        run_record,
        events,
        answered,
        comparison: Some(comparison.verdict(board.boot(), &board.tally())),
        input_check,
        outcome,
        line: None,
        step_cycles,
    })
}

/// Runs the host's node for a comparison with a board.
fn expect_host(
    plan: &ReplayPlan<'_>,
    recording: &mut StoredRecording,
    comparison: &mut Comparison,
) -> Result<(RunOutcome, InputCheck), ReplayError> {
    let mut input_check = InputCheck::default();
    let mut refusals = Vec::new();
    let mut inputs = recording.inputs(|_| ())?;
    let replayed = plan
        .inputs(&mut inputs)?
        .inspect(|input| input_check.take(input));
    let outcome = run_streamed(
        plan.config,
        replayed,
        |event| comparison.expect(event),
        // The configuration goes in front.
        |input, fault| refusals.push((input + 1, fault)),
    )?;
    inputs.finish()?;
    comparison.expect_refusals(&refusals);
    Ok((outcome, input_check))
}
