//! Lock-step: inputs go out only as fast as their answers come back.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use amiro_ipf::link::{Frame, Message, MessageRef};
use amiro_ipf::node::{Event, Input, InputError};

use super::board::ANSWER_DEADLINE;
use super::{Board, LinkError};
use crate::spool::Spool;

/// Longest time for the events of one input: a whole step at 9600 baud.
const INPUT_DEADLINE: Duration = Duration::from_secs(30);

/// Statuses come at 8 Hz: how long one is waited for.
const STATUS_DEADLINE: Duration = Duration::from_millis(500);

/// Inputs after which the raw bytes so far are moved to a spool.
const RAW_EVERY: usize = 1024;

/// Errors in the sequence of a board's answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AnswerAudit {
    /// Answers without an unanswered input.
    pub surplus: u64,
    /// Answers that came before that to an earlier input.
    pub out_of_order: u64,
}

/// Sends messages to a board and passes its own on, in order, until all are answered.
///
/// At most as many inputs are unanswered at a time as the board accepts ahead; nothing is
/// lost by design, so the run is exactly repeatable. `on_message` also gets statuses and
/// healths, which come by the board's clock. When a configuration is the first input, the
/// steps of the board's earlier run are left out. `on_answer` gets each input's number,
/// from 0, and why it was refused if it was: an input that the board refuses is one that
/// the host's own node may refuse too. Answers that match no input are skipped and counted.
///
/// # Errors
/// [`LinkError::NoAnswer`] when an input is unanswered for two seconds;
/// [`LinkError::Restarted`]; a broken link.
pub fn drive<M>(
    board: &mut Board,
    inputs: &[M],
    on_message: impl FnMut(&Message),
    on_answer: impl FnMut(usize, Option<InputError>),
) -> Result<AnswerAudit, LinkError>
where
    M: Clone,
    for<'m> &'m M: Into<MessageRef<'m>>,
{
    let pace = Pace::Answers;
    drive_streamed(
        board,
        pace,
        inputs.iter().cloned(),
        on_message,
        on_answer,
        None,
    )
}

/// What the next input waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// For the answers to all inputs but as many as the board accepts ahead.
    Answers,
    /// For the answer to the last input and, if that made a step, for a status: a status
    /// holds the cycles of the last step, so that each step is measured. Takes an eighth of a
    /// second of the board's time per step.
    StatusPerStep,
}

/// As [`drive`], for inputs of any number: the board's raw bytes go to `raw`, if there is
/// one, but for the last, which [`Board::take_raw`] gives.
///
/// # Errors
/// As [`drive`]; [`LinkError::NoAnswer`], too, when a step has no status within two seconds.
pub fn drive_streamed<M>(
    board: &mut Board,
    pace: Pace,
    inputs: impl IntoIterator<Item = M>,
    mut on_message: impl FnMut(&Message),
    mut on_answer: impl FnMut(usize, Option<InputError>),
    mut raw: Option<&mut Spool>,
) -> Result<AnswerAudit, LinkError>
where
    for<'m> &'m M: Into<MessageRef<'m>>,
{
    let window = match pace {
        Pace::StatusPerStep => 1,
        Pace::Answers => board
            .boot()
            .map_or(1, |boot| usize::from(boot.window.max(1))),
    };
    let mut has_stepped = false;
    let mut audit = AnswerAudit::default();
    let mut waiting: VecDeque<(usize, u16)> = VecDeque::new();
    let mut rest = inputs.into_iter().enumerate().peekable();
    let first = rest.peek();
    let mut is_in_other_run = first.is_some_and(|(_, first)| is_configuration(first.into()));
    let mut deadline = Instant::now() + ANSWER_DEADLINE;
    let mut last_deadline = Instant::now() + INPUT_DEADLINE;
    loop {
        while waiting.len() < window {
            let Some((index, input)) = rest.next() else {
                break;
            };
            waiting.push_back((index, board.send(&input)?));
        }
        let Some(&(first, _)) = waiting.front() else {
            return Ok(audit);
        };
        let frame = receive(board, first, deadline)?;
        if is_in_other_run && matches!(frame.message, Message::Event(Event::Configured(_))) {
            board.begin_loss_stats(&frame);
        }
        let message = frame.message;
        if !message.is_from_board() {
            continue;
        }
        if !matches!(message, Message::Status(_) | Message::Health(_)) {
            // The events of a long step on a slow line are progress too.
            deadline = (Instant::now() + ANSWER_DEADLINE).min(last_deadline);
        }
        let Message::Answer { input, refused } = message else {
            is_in_other_run &= !matches!(message, Message::Event(Event::Configured(_)));
            if !(is_in_other_run && is_of_a_run(&message)) {
                has_stepped |= matches!(message, Message::Event(Event::StepDone(_)));
                on_message(&message);
            }
            continue;
        };
        let Some(place) = waiting.iter().position(|&(_, sequence)| sequence == input) else {
            audit.surplus += u64::from(input != board.greeted_as());
            continue;
        };
        audit.out_of_order += u64::from(place > 0);
        let Some((index, _)) = waiting.remove(place) else {
            continue;
        };
        is_in_other_run = false;
        last_deadline = Instant::now() + INPUT_DEADLINE;
        deadline = Instant::now() + ANSWER_DEADLINE;
        on_answer(index, refused);
        if std::mem::take(&mut has_stepped) && pace == Pace::StatusPerStep {
            wait_for_status(board, index, &mut on_message)?;
        }
        if index % RAW_EVERY == 0
            && let Some(raw) = &mut raw
        {
            raw.write(&board.take_whole_raw());
        }
    }
}

/// The next frame of the boot that was greeted, while input `first` waits for its answer.
fn receive(board: &mut Board, first: usize, deadline: Instant) -> Result<Frame, LinkError> {
    let Some(frame) = board.receive_frame(deadline)? else {
        return Err(LinkError::NoAnswer { input: first });
    };
    let greeted = board.boot_id();
    if greeted.is_some_and(|greeted| greeted != frame.boot_id) {
        return Err(LinkError::Restarted { input: first });
    }
    Ok(frame)
}

/// Passes on the messages up to the next status, after a step of input `index`.
fn wait_for_status(
    board: &mut Board,
    index: usize,
    on_message: &mut impl FnMut(&Message),
) -> Result<(), LinkError> {
    let deadline = Instant::now() + ANSWER_DEADLINE;
    loop {
        let message = receive(board, index, deadline)?.message;
        if message.is_from_board() {
            on_message(&message);
        }
        if matches!(message, Message::Status(_)) {
            return Ok(());
        }
    }
}

/// Passes on the messages after the last answer, where no message of a run is expected: up
/// to the next status, or for half a second.
///
/// # Errors
/// A broken link.
pub fn listen(board: &mut Board, mut on_message: impl FnMut(&Message)) -> Result<(), LinkError> {
    let deadline = Instant::now() + STATUS_DEADLINE;
    while let Some(frame) = board.receive_frame(deadline)? {
        if !frame.message.is_from_board() {
            continue;
        }
        on_message(&frame.message);
        if matches!(frame.message, Message::Status(_)) {
            break;
        }
    }
    Ok(())
}

/// Whether a message configures the node.
fn is_configuration(message: MessageRef<'_>) -> bool {
    matches!(message, MessageRef::Input(Input::Configure(_)))
}

/// Whether a message belongs to the run of one configuration.
fn is_of_a_run(message: &Message) -> bool {
    match message {
        Message::Event(event) => !matches!(event, Event::Configured(_)),
        _ => false,
    }
}
