//! The last words on a bus, for the report of a failure.

use std::collections::VecDeque;
use std::fmt;

use super::LineFault;

/// Number of words that are kept.
const KEPT: usize = 256;

/// A word on the wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// An address after a start, and whether it was acknowledged.
    Address {
        /// Seven bits.
        address: u8,
        /// For reading.
        read: bool,
        /// Whether the addressed part acknowledged it.
        acknowledged: bool,
    },
    /// A byte from the master.
    Written {
        /// The byte.
        byte: u8,
        /// Whether the part acknowledged it.
        acknowledged: bool,
    },
    /// A byte for the master.
    Read {
        /// The byte as the master saw it.
        byte: u8,
        /// Whether the master acknowledged it, which requests another byte.
        acknowledged: bool,
    },
    /// A stop.
    Stop,
    /// Nothing was transferred, because of the wires.
    Failed(LineFault),
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = |acknowledged: bool| if acknowledged { '+' } else { '-' };
        match *self {
            Self::Address {
                address,
                read,
                acknowledged,
            } => {
                let way = if read { 'r' } else { 'w' };
                write!(f, "[{address:02x}{way}{}", sign(acknowledged))
            }
            Self::Written { byte, acknowledged } => write!(f, "{byte:02x}{}", sign(acknowledged)),
            Self::Read { byte, acknowledged } => write!(f, "<{byte:02x}{}", sign(acknowledged)),
            Self::Stop => f.write_str("]"),
            Self::Failed(fault) => write!(f, "!{fault}!"),
        }
    }
}

/// The last words on a bus.
///
/// Shown as `[77w+ 05+ ]` for a start with address 0x77 for writing, a byte and a stop;
/// `<` marks bytes for the master, `+` and `-` whether there was an acknowledgement.
#[derive(Clone, Debug, Default)]
pub struct Transcript {
    words: VecDeque<(u64, Word)>,
}

impl Transcript {
    /// The words with the number of bytes before each, oldest first.
    pub fn words(&self) -> impl Iterator<Item = (u64, Word)> {
        self.words.iter().copied()
    }

    pub(super) fn note(&mut self, bytes_before: u64, word: Word) {
        if self.words.len() == KEPT {
            self.words.pop_front();
        }
        self.words.push_back((bytes_before, word));
    }
}

impl fmt::Display for Transcript {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((bytes_before, _)) = self.words.front() {
            write!(f, "from byte {bytes_before}:")?;
        }
        self.words
            .iter()
            .try_for_each(|(_, word)| write!(f, " {word}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_words_are_kept() {
        let mut transcript = Transcript::default();
        for byte in 0..=255 {
            let word = Word::Written {
                byte,
                acknowledged: byte != 255,
            };
            transcript.note(u64::from(byte), word);
        }
        transcript.note(256, Word::Stop);
        let shown = transcript.to_string();
        assert!(shown.starts_with("from byte 1: 01+ 02+"), "{shown}");
        assert!(shown.ends_with("fe+ ff- ]"), "{shown}");
    }
}
