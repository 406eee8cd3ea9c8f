//! A replay on the host's node.

use amiro_ipf::link::Encoder;
use amiro_ipf::node::Event;

use super::{KeptEvents, ReplayError, ReplayPass, ReplayPlan, Replayed, StepCycles};
use crate::device::{Comparison, FaultInjector, HOST_NODE_BOOT_ID, LineRun};
use crate::drive::InputCheck;
use crate::log::StoredRecording;
use crate::run_streamed;
use crate::spool::Spool;

/// Replays a recording on the host's node, over a line if that has faults; recorded events
/// of the same configuration must be met.
///
/// `on_bytes` gets the bytes of the recording that a pass has read so far.
///
/// # Errors
/// As [`run`](crate::run()); a recording that cannot be read again.
pub fn replay_on_host(
    plan: &ReplayPlan<'_>,
    recording: &mut StoredRecording,
    on_bytes: &mut dyn FnMut(ReplayPass, u64),
) -> Result<Replayed, ReplayError> {
    let is_compared = plan.is_compared(recording.overview());
    let mut run_record = plan.run_record();
    let mut events = KeptEvents::new(plan.is_scored);
    let mut line = plan
        .has_line_faults()
        .then(|| LineRun::new(FaultInjector::new(plan.faults, plan.seed_of_faults)));
    let mut encoder = Encoder::new(HOST_NODE_BOOT_ID);
    let mut answered = Spool::default();
    let mut comparison = Comparison::default();
    let mut input_check = InputCheck::default();
    let mut arrive = |event: &Event| {
        run_record.take(event);
        events.take(event);
    };
    let mut inputs = recording.inputs(|bytes| on_bytes(ReplayPass::Replay, bytes))?;
    let replayed = plan
        .inputs(&mut inputs)?
        .inspect(|input| input_check.take(input));
    let on_event = |event: &Event| {
        if is_compared {
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
    let line = line.map(|line| {
        let arrived = line.finish(&mut arrive);
        answered.write(&arrived.bytes);
        (arrived.frames, arrived.line)
    });
    if is_compared {
        meet_recorded(recording, &mut comparison, on_bytes)?;
    }
    Ok(Replayed {
        run_record,
        events,
        answered,
        comparison: is_compared.then(|| comparison.verdict_of_recording()),
        input_check,
        outcome,
        line,
        step_cycles: StepCycles::default(),
    })
}

/// Compares the recorded messages with the host's run.
fn meet_recorded(
    recording: &mut StoredRecording,
    comparison: &mut Comparison,
    on_bytes: &mut dyn FnMut(ReplayPass, u64),
) -> Result<(), ReplayError> {
    let mut recorded = recording.messages(|bytes| on_bytes(ReplayPass::Compare, bytes))?;
    recorded
        .by_ref()
        .for_each(|message| comparison.meet(&message));
    recorded.finish()?;
    Ok(())
}
