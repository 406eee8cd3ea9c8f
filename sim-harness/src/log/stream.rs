//! The bytes of the link: frames of a host and of the board that answers it.
//!
//! `docs/protocol.md` is the specification of a frame. In a file, frames of several senders
//! lie one after another, distinguished by their boot ids; each sender's sequence numbers
//! are checked separately, so that interleaved frames are no gap and a lost frame is one.

use std::io::Read;
use std::ops::ControlFlow;

use amiro_ipf::link::{Frame, MAX_FRAME, Message, TruthMessage};
use amiro_ipf::node::Input;

use super::rules::{Rules, Sender};
use super::sequence::{SequenceCheck, Sequences};
use super::source::ByteSource;
use super::{LogError, Place, Reason};

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
struct ScenarioText {
    begins: Option<Place>,
    bytes: Vec<u8>,
    is_too_long: bool,
}

/// The pieces of the faults' texts so far: place, seed and bytes of each text.
#[derive(Debug, Default)]
struct FaultTexts {
    texts: Vec<(Place, u64, Vec<u8>)>,
    bytes: usize,
    /// Where the texts became too long.
    too_long: Option<Place>,
}

/// The texts that arrive in pieces.
#[derive(Debug, Default)]
struct ChunkedTexts {
    scenario: ScenarioText,
    faults: FaultTexts,
}

/// State of the reader of frames.
#[derive(Debug, Default)]
pub(super) struct Frames {
    sequences: Sequences,
    pieces: ChunkedTexts,
    bytes: Vec<u8>,
    /// The frame that is read, before it is decoded in place.
    encoded: Vec<u8>,
    /// The last good frame, of any sender.
    before: Vec<u8>,
}

/// Whether the beginning of a source holds a frame, or at least begins as one would.
pub(super) fn is_stream(head: &[u8]) -> bool {
    head.first() == Some(&0)
        || head
            .split(|byte| *byte == 0)
            .any(|piece| Frame::decode(&mut piece.to_vec()).is_ok())
}

impl Frames {
    /// Reads the next frame; breaks at the end of the source or of its run.
    ///
    /// # Errors
    /// A source that cannot be read, or that shows no frame in its first MiB.
    pub(super) fn read_one<R: Read>(
        &mut self,
        source: &mut ByteSource<R>,
        rules: &mut Rules,
    ) -> Result<ControlFlow<()>, LogError> {
        // One byte beyond the longest frame, so that its decoder sees that it is too long.
        let Some(piece) = source.read_piece(0, MOST_ENCODED + 1, &mut self.bytes)? else {
            return Ok(ControlFlow::Break(()));
        };
        if self.bytes.is_empty() {
            return Ok(ControlFlow::Continue(()));
        }
        let place = Place::Byte(piece.start);
        self.encoded.clone_from(&self.bytes);
        match Frame::decode(&mut self.bytes) {
            Ok(frame) => {
                source.trust();
                return Ok(self.take(rules, place, frame));
            }
            Err(error) if piece.is_ended => rules.refuse(place, Reason::Broken(error), error),
            Err(_) => rules.refuse(place, Reason::Cut, "the source ends within a frame"),
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Takes a frame; breaks when nothing after it may be used.
    fn take(&mut self, rules: &mut Rules, place: Place, frame: Frame) -> ControlFlow<()> {
        let mut continuity = self
            .sequences
            .check(frame.boot_id, frame.sequence, &self.encoded);
        let is_configuration = matches!(frame.message, Message::Input(Input::Configure(_)));
        if is_configuration && self.encoded != self.before {
            // A line repeats a frame directly behind it. With frames of the board in between,
            // it is the first frame of another recording.
            continuity = continuity.not_again();
        }
        std::mem::swap(&mut self.before, &mut self.encoded);
        report(rules, place, frame.sequence, continuity);
        if continuity == SequenceCheck::Again {
            return ControlFlow::Continue(());
        }
        let sender = if frame.boot_id < BEYOND_BOARDS {
            Sender::Board
        } else {
            Sender::Host
        };
        if begins_a_recording(&frame.message) {
            if rules.has_begun() {
                let text = "the truth of another simulation: what follows is another run";
                rules.refuse(place, Reason::SecondRun, text);
                return ControlFlow::Break(());
            }
            if continuity == SequenceCheck::Earlier {
                // A recording that ended before its configuration lies in front.
                self.pieces = ChunkedTexts::default();
                rules.forget_truth(place);
            }
        }
        take(rules, &mut self.pieces, place, (sender, frame.message))
    }

    /// Takes the collected texts at the end of the source.
    pub(super) fn finish(&mut self, rules: &mut Rules) {
        let ChunkedTexts { scenario, faults } = std::mem::take(&mut self.pieces);
        scenario.finish(rules);
        faults.finish(rules);
    }
}

/// Whether a message stands in front of the configuration of a simulated recording only.
fn begins_a_recording(message: &Message) -> bool {
    matches!(
        message,
        Message::Truth(
            TruthMessage::Seed(_) | TruthMessage::Scenario(_) | TruthMessage::Faults { .. }
        )
    )
}

fn report(rules: &mut Rules, place: Place, sequence: u16, continuity: SequenceCheck) {
    match continuity {
        SequenceCheck::Next => {}
        SequenceCheck::Lost(frames) => {
            let text = format_args!("{frames} frames lost");
            rules.refuse(place, Reason::Lost, text);
        }
        SequenceCheck::Again => {
            let text = format_args!("repeats frame {sequence}");
            rules.refuse(place, Reason::Repeated, text);
        }
        SequenceCheck::Earlier => {
            let text = format_args!("the sender starts over at frame {sequence}");
            rules.refuse(place, Reason::StartedOver, text);
        }
    }
}

fn take(
    rules: &mut Rules,
    pieces: &mut ChunkedTexts,
    place: Place,
    (sender, message): (Sender, Message),
) -> ControlFlow<()> {
    match message {
        Message::Input(input) => rules.take_input(place, sender, input)?,
        Message::Hello | Message::Calibrate => {}
        Message::Truth(TruthMessage::Pose { stamp_us, pose }) => {
            rules.take_true_pose(place, stamp_us, pose)?;
        }
        Message::Truth(TruthMessage::Scenario(chunk)) => pieces.scenario.extend(place, &chunk),
        Message::Truth(TruthMessage::Faults { seed, text }) => {
            pieces.faults.extend(place, seed, &text)
        }
        Message::Truth(TruthMessage::Seed(seed)) => {
            let kept = *rules.truth().seed.get_or_insert(seed);
            if kept != seed {
                rules.refuse(place, Reason::Repeated, "a second seed");
            }
        }
        message => rules.take_message(place, message)?,
    }
    ControlFlow::Continue(())
}

impl ScenarioText {
    fn extend(&mut self, place: Place, chunk: &[u8]) {
        self.begins.get_or_insert(place);
        self.is_too_long |= self.bytes.len() + chunk.len() > MOST_SCENARIO;
        if !self.is_too_long {
            self.bytes.extend_from_slice(chunk);
        }
    }

    /// Passes on the joined text; an incomplete scenario is refused.
    fn finish(self, rules: &mut Rules) {
        let Some(place) = self.begins else {
            return;
        };
        match String::from_utf8(self.bytes) {
            Ok(text) if !self.is_too_long => rules.truth().scenario = Some(text),
            Ok(_) => rules.refuse(place, Reason::BadScenario, "a scenario of more than 64 KiB"),
            Err(error) => rules.refuse(place, Reason::BadScenario, error.utf8_error()),
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

    /// Passes on the texts; an incomplete one is refused.
    fn finish(self, rules: &mut Rules) {
        if let Some(place) = self.too_long {
            let text = "more than 4 KiB of faults: none are told";
            rules.refuse(place, Reason::BadFaults, text);
            return;
        }
        for (place, seed, bytes) in self.texts {
            match String::from_utf8(bytes) {
                Ok(text) => rules.truth().faults.push((text, seed)),
                Err(error) => rules.refuse(place, Reason::BadFaults, error.utf8_error()),
            }
        }
    }
}
