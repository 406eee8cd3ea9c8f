//! Identifies the board that answers a greeting of this session.
//!
//! Bytes of an earlier session may still be in a line: in an adapter, a network, a pipe.
//! A host therefore numbers its frames from a random number, and a board's answer carries
//! the number of the `Hello` that it answers (`docs/protocol.md`, section 7). One answer
//! of an earlier session passes with a chance of 1 in 65 536; two greetings in a row with
//! numbers that do not depend on each other, 1 in 4 294 967 296.

use std::hash::{BuildHasher, RandomState};

use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::board::supervision::PostMortem;
use amiro_ipf::link::{Boot, Frame, Message};

use super::LinkError;

/// Frames from the `Boot` of an answer to its `Answer`: `PostMortem` and `Offsets` may
/// lie between them.
const LONGEST_ANSWER: u16 = 3;

/// Resets within one greeting after which the greeting fails because of them.
const RESETS_IN_A_LOOP: u32 = 10;

/// First numbers of sessions.
pub(super) type Numbers = Box<dyn FnMut() -> u16 + Send>;

/// Numbers that no two sessions share but by chance.
///
/// They are no secret: the standard library's hash keys are random once per process and
/// differ from one to the next.
pub(super) fn random_numbers() -> Numbers {
    Box::new(|| {
        let [low, high, ..] = RandomState::new().hash_one(0_u8).to_le_bytes();
        u16::from_le_bytes([low, high])
    })
}

/// A board's answer to a greeting.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answerer {
    pub(super) boot: Boot,
    pub(super) boot_id: u8,
    pub(super) offsets: Option<OffsetReport>,
    pub(super) post_mortem: Option<PostMortem>,
    /// Number of the frame with the `Boot`.
    sequence: u16,
}

impl Answerer {
    /// Whether a frame is of the answer that began with the `Boot`.
    fn is_followed_by(&self, frame: &Frame) -> bool {
        let behind = frame.sequence.wrapping_sub(self.sequence);
        self.boot_id == frame.boot_id && (1..=LONGEST_ANSWER).contains(&behind)
    }
}

/// Frames that come while a host greets.
#[derive(Debug, Default)]
pub(super) struct Greeting {
    candidate: Option<Answerer>,
    answers_others: bool,
    /// Boot id and number of the last `Boot`, of this greeting or one before it.
    last_boot_frame: Option<(u8, u16)>,
    resets: u32,
}

impl Greeting {
    /// The next greeting of the same board: only the resets are carried over.
    pub(super) fn next(&self) -> Self {
        Self {
            last_boot_frame: self.last_boot_frame,
            resets: self.resets,
            ..Self::default()
        }
    }

    /// Takes the next frame; the board that answers the `Hello` with the number `hello`.
    ///
    /// The board is the one whose `Boot` lies directly in front of the `Answer`.
    pub(super) fn take(&mut self, frame: &Frame, hello: u16) -> Option<Answerer> {
        match &frame.message {
            Message::Boot(boot) => {
                // A board numbers its frames from 0 after a reset.
                let found = (frame.boot_id, frame.sequence);
                let before = self.last_boot_frame.replace(found);
                let is_reset = before.is_some_and(|(boot_id, sequence)| {
                    boot_id != frame.boot_id || frame.sequence <= sequence
                });
                self.resets += u32::from(is_reset);
                self.candidate = Some(Answerer {
                    boot: *boot,
                    boot_id: frame.boot_id,
                    offsets: None,
                    post_mortem: None,
                    sequence: frame.sequence,
                });
            }
            message => {
                let candidate = self.candidate.as_mut();
                let candidate = candidate.filter(|board| board.is_followed_by(frame));
                match (message, candidate) {
                    (Message::Answer { input, .. }, Some(board)) if *input == hello => {
                        return Some(board.clone());
                    }
                    (Message::Answer { .. }, _) => self.answers_others = true,
                    (Message::Offsets(offsets), Some(board)) => board.offsets = Some(*offsets),
                    (Message::PostMortem(record), Some(board)) => {
                        board.post_mortem = Some(record.clone());
                    }
                    _ => {}
                }
            }
        }
        None
    }

    /// The last `Boot`, of an answer or not.
    pub(super) fn last_boot(&self) -> Option<&Boot> {
        self.candidate.as_ref().map(|board| &board.boot)
    }

    /// Observed resets of the board.
    pub(super) fn resets(&self) -> u32 {
        self.resets
    }

    /// Why there was no answer to this session's greeting.
    pub(super) fn failure(&self) -> LinkError {
        match self.resets {
            resets @ RESETS_IN_A_LOOP.. => LinkError::KeepsResetting { resets },
            _ if self.answers_others => LinkError::OtherSession,
            _ => LinkError::NoBoot,
        }
    }
}

#[cfg(test)]
mod tests {
    use amiro_ipf::board::clock_choice::ClockSource;
    use amiro_ipf::link::WIRE_VERSION;

    use super::*;

    const BOOT: Boot = Boot {
        wire_version: WIRE_VERSION,
        build_id: 0,
        capacity: 8,
        window: 8,
        baud: 0,
        clock: ClockSource::Host,
        core_hz: 0,
    };

    fn boot(boot_id: u8, sequence: u16) -> Frame {
        frame(boot_id, sequence, Message::Boot(BOOT))
    }

    fn answer(boot_id: u8, sequence: u16, input: u16) -> Frame {
        let refused = None;
        frame(boot_id, sequence, Message::Answer { input, refused })
    }

    fn frame(boot_id: u8, sequence: u16, message: Message) -> Frame {
        Frame {
            boot_id,
            sequence,
            message,
        }
    }

    /// Boot id of the board that answers the greeting 700 in these frames.
    fn answerer(frames: impl IntoIterator<Item = Frame>) -> Option<u8> {
        let mut greeting = Greeting::default();
        let mut frames = frames.into_iter();
        frames.find_map(|frame| Some(greeting.take(&frame, 700)?.boot_id))
    }

    #[test]
    fn stale_frames_of_another_board_do_not_introduce_it() {
        let stale = [boot(9, 40), answer(9, 41, 0)];
        assert_eq!(answerer(stale.clone()), None);
        let real = [boot(3, 7), answer(3, 8, 700)];
        assert_eq!(answerer(stale.into_iter().chain(real)), Some(3));
        // The answer is the real board's, the introduction is not.
        assert_eq!(answerer([boot(9, 40), answer(3, 41, 700)]), None);
    }

    #[test]
    fn a_stale_introduction_of_the_same_boot_is_not_taken_for_the_answer() {
        assert_eq!(answerer([boot(3, 7), answer(3, 5000, 700)]), None);
        assert_eq!(answerer([boot(3, 65_535), answer(3, 2, 700)]), Some(3));
        assert_eq!(answerer([boot(3, 65_535), answer(3, 3, 700)]), None);
        assert_eq!(answerer([answer(3, 6, 700), boot(3, 7)]), None);
    }

    #[test]
    fn first_numbers_differ_from_session_to_session() {
        let mut numbers = random_numbers();
        let drawn: std::collections::BTreeSet<u16> = (0..64).map(|_| numbers()).collect();
        // 64 of 65 536 numbers: three pairs of equal ones have a chance below 1e-5.
        assert!(drawn.len() > 61, "{drawn:?}");
    }
}
