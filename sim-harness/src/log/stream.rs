//! The bytes of the link: frames of a host and of the board that answers it.
//!
//! `docs/protocol.md` is the specification of a frame. In a file, frames of several
//! senders lie one after another, told apart by their boot ids; each sender's
//! sequence numbers are followed on their own, so that interleaving costs nothing and
//! a lost frame shows as a gap.

use std::io::Read;
use std::ops::ControlFlow;

use amiro_ipf::input::Input;
use amiro_ipf::wire::{Frame, MAX_FRAME, Message, Truth};

use super::draft::{Draft, Sender};
use super::sequence::{Continuity, Sequences};
use super::source::Source;
use super::{Format, LogError, Place, Reason, Recording};

/// Most bytes between two zero bytes of good frames.
const MOST_ENCODED: usize = MAX_FRAME - 1;
/// Boot ids of boards lie below this one.
const BEYOND_BOARDS: u8 = 0xA0;
/// Most bytes of a scenario.
const MOST_SCENARIO: usize = 64 * 1024;

/// Most bytes of the faults' texts together.
const MOST_FAULTS: usize = 4 * 1024;

/// The pieces of the scenario so far and where it began.
#[derive(Debug, Default)]
struct Scenario {
    begins: Option<Place>,
    bytes: Vec<u8>,
    is_too_long: bool,
}

/// The pieces of the faults' texts so far: place, seed and bytes of each text.
#[derive(Debug, Default)]
struct FaultTexts {
    texts: Vec<(Place, u64, Vec<u8>)>,
    bytes: usize,
    /// Where there was too much of it.
    too_long: Option<Place>,
}

/// What comes in pieces.
#[derive(Debug, Default)]
struct Pieces {
    scenario: Scenario,
    faults: FaultTexts,
}

/// Whether the beginning of a source holds a frame, or at least begins as one would.
pub(super) fn is_stream(head: &[u8]) -> bool {
    head.first() == Some(&0)
        || head
            .split(|byte| *byte == 0)
            .any(|piece| Frame::decode(&mut piece.to_vec()).is_ok())
}

/// Reads a source of frames to its end.
///
/// # Errors
/// A source that cannot be read, or that shows no frame in its first MiB.
pub(super) fn read<R: Read>(source: &mut Source<R>) -> Result<Recording, LogError> {
    let mut draft = Draft::new(Format::Stream);
    let mut sequences = Sequences::default();
    let mut pieces = Pieces::default();
    let mut bytes = Vec::with_capacity(MAX_FRAME);
    let mut before = Vec::new();
    // One byte beyond the longest frame, so that its decoder sees that it is too long.
    while let Some(piece) = source.read_piece(0, MOST_ENCODED + 1, &mut bytes)? {
        if bytes.is_empty() {
            continue;
        }
        let place = Place::Byte(piece.start);
        let encoded = bytes.clone();
        let frame = match Frame::decode(&mut bytes) {
            Ok(frame) => frame,
            Err(error) if piece.is_ended => {
                draft.refuse(place, Reason::Broken(error), error);
                continue;
            }
            Err(_) => {
                draft.refuse(place, Reason::Cut, "the source ends within a frame");
                continue;
            }
        };
        source.trust();
        let mut continuity = sequences.follow(frame.boot_id, frame.sequence, &encoded);
        if matches!(frame.message, Message::Input(Input::Configure(_))) && encoded != before {
            // A line repeats a frame directly behind it. With frames of the board in between,
            // it is the first frame of another recording.
            continuity = continuity.not_again();
        }
        before = encoded;
        report(&mut draft, place, frame.sequence, continuity);
        if continuity == Continuity::Again {
            continue;
        }
        let sender = if frame.boot_id < BEYOND_BOARDS {
            Sender::Board
        } else {
            Sender::Host
        };
        if begins_a_recording(&frame.message) {
            if draft.has_begun() {
                let text = "the truth of another simulation: what follows is another run";
                draft.refuse(place, Reason::SecondRun, text);
                break;
            }
            if continuity == Continuity::Earlier {
                // A recording that ended before its configuration lies in front.
                pieces = Pieces::default();
                draft.forget_truth(place);
            }
        }
        if take(&mut draft, &mut pieces, place, (sender, frame.message)).is_break() {
            break;
        }
    }
    pieces.scenario.finish(&mut draft);
    pieces.faults.finish(&mut draft);
    Ok(draft.finish())
}

/// Whether a message stands in front of the configuration of a simulated recording only.
fn begins_a_recording(message: &Message) -> bool {
    matches!(
        message,
        Message::Truth(Truth::Seed(_) | Truth::Scenario(_) | Truth::Faults { .. })
    )
}

fn report(draft: &mut Draft, place: Place, sequence: u16, continuity: Continuity) {
    match continuity {
        Continuity::Next => {}
        Continuity::Lost(frames) => {
            let text = format_args!("{frames} frames lost");
            draft.refuse(place, Reason::Lost, text);
        }
        Continuity::Again => {
            let text = format_args!("repeats frame {sequence}");
            draft.refuse(place, Reason::Repeated, text);
        }
        Continuity::Earlier => {
            let text = format_args!("the sender starts over at frame {sequence}");
            draft.refuse(place, Reason::StartedOver, text);
        }
    }
}

fn take(
    draft: &mut Draft,
    pieces: &mut Pieces,
    place: Place,
    (sender, message): (Sender, Message),
) -> ControlFlow<()> {
    match message {
        Message::Input(input) => draft.take_input(place, sender, input)?,
        Message::Event(event) => draft.take_event(place, event)?,
        Message::Truth(Truth::Pose { stamp_us, pose }) => {
            draft.take_true_pose(place, stamp_us, pose)?;
        }
        Message::Truth(Truth::Scenario(chunk)) => pieces.scenario.extend(place, &chunk),
        Message::Truth(Truth::Faults { seed, text }) => pieces.faults.extend(place, seed, &text),
        Message::Truth(Truth::Seed(seed)) => {
            let kept = *draft.truth().seed.get_or_insert(seed);
            if kept != seed {
                draft.refuse(place, Reason::Repeated, "a second seed");
            }
        }
    }
    ControlFlow::Continue(())
}

impl Scenario {
    fn extend(&mut self, place: Place, chunk: &[u8]) {
        self.begins.get_or_insert(place);
        self.is_too_long |= self.bytes.len() + chunk.len() > MOST_SCENARIO;
        if !self.is_too_long {
            self.bytes.extend_from_slice(chunk);
        }
    }

    /// Hands the joined text over; half a scenario would be another one.
    fn finish(self, draft: &mut Draft) {
        let Some(place) = self.begins else {
            return;
        };
        match String::from_utf8(self.bytes) {
            Ok(text) if !self.is_too_long => draft.truth().scenario = Some(text),
            Ok(_) => draft.refuse(place, Reason::BadScenario, "a scenario of more than 64 KiB"),
            Err(error) => draft.refuse(place, Reason::BadScenario, error.utf8_error()),
        }
    }
}

impl FaultTexts {
    fn extend(&mut self, place: Place, seed: u64, chunk: &[u8]) {
        // An empty piece would be a text each time the seed changes.
        self.bytes += chunk.len().max(1);
        if self.bytes > MOST_FAULTS {
            self.too_long.get_or_insert(place);
            return;
        }
        match self.texts.last_mut() {
            Some((_, last, bytes)) if *last == seed => bytes.extend_from_slice(chunk),
            _ => self.texts.push((place, seed, chunk.to_vec())),
        }
    }

    /// Hands the texts over; half of one would be another one.
    fn finish(self, draft: &mut Draft) {
        if let Some(place) = self.too_long {
            let text = "more than 4 KiB of faults: none are told";
            draft.refuse(place, Reason::BadFaults, text);
            return;
        }
        for (place, seed, bytes) in self.texts {
            match String::from_utf8(bytes) {
                Ok(text) => draft.truth().faults.push((text, seed)),
                Err(error) => draft.refuse(place, Reason::BadFaults, error.utf8_error()),
            }
        }
    }
}
