//! The record of a failed boot: written before the reset, read after it.

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::checksum::CRC;

/// Most bytes of a place that are kept: its end, which names the file.
pub const MAX_PLACE_BYTES: usize = 24;

/// Words that the longest record is encoded in: 76 bytes.
const ENCODED: usize = 19;

/// Words in which a record is kept: a mark, the encoding, a checksum.
pub const RECORD_WORDS: usize = ENCODED + 2;

/// Distinguishes a record from memory that was never written: "died" in ASCII.
const MAGIC: u32 = 0x6469_6564;

/// Why a boot failed. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailureCause {
    /// The program panicked at this place and line. Or an exception without a handler
    /// occurred: the place is `unhandled exception`, the line is its number.
    Panic,
    /// An invalid instruction, address or memory access, at `registers.pc`.
    Fault,
    /// The stack reached its guard.
    StackOverflow,
    /// The watchdog was not fed: a task no longer ran.
    Watchdog,
    /// The crystal stopped; the next boot runs on the internal oscillator.
    Clock,
}

/// The core's registers at a fault or an exception without a handler; zeros where they
/// could not be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CoreRegisters {
    /// The instruction that failed.
    pub pc: u32,
    /// Where its function returns to.
    pub lr: u32,
    /// Program status.
    pub psr: u32,
    /// Stack pointer at the fault.
    pub sp: u32,
    /// Configurable fault status: which fault it was.
    pub cfsr: u32,
    /// Hard fault status.
    pub hfsr: u32,
    /// The address that could not be accessed, where `cfsr` says that it is valid.
    pub address: u32,
}

/// How a boot failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PostMortem {
    /// Why.
    pub cause: FailureCause,
    /// Steps of the filter since its configuration.
    pub step: u32,
    /// Uptime, milliseconds, to 125.
    pub uptime_ms: u32,
    /// The end of the source file's name; empty for faults.
    pub place: String<MAX_PLACE_BYTES, u8>,
    /// The line in it, or the number of an exception without a handler.
    pub line: u32,
    /// The core's registers; zeros for a panic of the program.
    pub registers: CoreRegisters,
}

impl PostMortem {
    /// A record without place and registers.
    #[must_use]
    pub const fn new(cause: FailureCause, step: u32, uptime_ms: u32) -> Self {
        Self {
            cause,
            step,
            uptime_ms,
            place: String::new(),
            line: 0,
            registers: CoreRegisters {
                pc: 0,
                lr: 0,
                psr: 0,
                sp: 0,
                cfsr: 0,
                hfsr: 0,
                address: 0,
            },
        }
    }

    /// The record with the end of a file's name and a line in it.
    #[must_use]
    pub fn at(mut self, file: &str, line: u32) -> Self {
        let mut start = file.len().saturating_sub(MAX_PLACE_BYTES);
        while !file.is_char_boundary(start) {
            start += 1;
        }
        self.place.clear();
        // Cut to what fits.
        let _ = self.place.push_str(file.get(start..).unwrap_or_default());
        self.line = line;
        self
    }

    /// The record as words, in the wire's encoding, with a checksum at the end.
    #[must_use]
    pub fn to_words(&self) -> [u32; RECORD_WORDS] {
        let mut bytes = [[0; 4]; ENCODED];
        // The longest record fits; a test holds that.
        let _ = postcard::to_slice(self, bytes.as_flattened_mut());
        let mut words = [0; RECORD_WORDS];
        let [magic, encoded @ .., _] = &mut words;
        *magic = MAGIC;
        for (word, bytes) in encoded.iter_mut().zip(bytes) {
            *word = u32::from_le_bytes(bytes);
        }
        let sum = checksum(&words);
        let [.., last] = &mut words;
        *last = sum;
        words
    }

    /// The record in some words; `None` if they hold none, or a damaged one.
    #[must_use]
    pub fn from_words(words: &[u32; RECORD_WORDS]) -> Option<Self> {
        let [magic, encoded @ .., sum] = words;
        if *magic != MAGIC || *sum != checksum(words) {
            return None;
        }
        let mut bytes = [[0; 4]; ENCODED];
        for (place, word) in bytes.iter_mut().zip(encoded) {
            *place = word.to_le_bytes();
        }
        postcard::from_bytes(bytes.as_flattened()).ok()
    }
}

/// CRC of all words but the last.
fn checksum(words: &[u32; RECORD_WORDS]) -> u32 {
    let mut digest = CRC.digest();
    for word in words.iter().take(RECORD_WORDS - 1) {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> PostMortem {
        let mut record = PostMortem::new(FailureCause::Fault, 263, 12_345)
            .at("some/where/else/src/filter/step.rs", 77);
        record.registers.pc = 0x0800_1234;
        record.registers.address = 0x6000_0000;
        record
    }

    #[test]
    fn f55_what_was_written_is_read() {
        let record = record();
        assert_eq!(record.place, "e/else/src/filter/step.rs"[1..]);
        assert_eq!(PostMortem::from_words(&record.to_words()), Some(record));
    }

    #[test]
    fn f55_no_changed_bit_is_believed() {
        let good = record().to_words();
        for word in 0..RECORD_WORDS {
            for bit in 0..32 {
                let mut words = good;
                words[word] ^= 1 << bit;
                assert_eq!(PostMortem::from_words(&words), None, "{word}, {bit}");
            }
        }
        assert_eq!(PostMortem::from_words(&[0xa5a5_a5a5; RECORD_WORDS]), None);
        assert_eq!(PostMortem::from_words(&[0; RECORD_WORDS]), None);
    }

    #[test]
    fn the_longest_record_is_kept_whole() {
        let mut record = PostMortem::new(FailureCause::Clock, u32::MAX, u32::MAX)
            .at(&"x".repeat(MAX_PLACE_BYTES), u32::MAX);
        record.registers = CoreRegisters {
            pc: u32::MAX,
            lr: u32::MAX,
            psr: u32::MAX,
            sp: u32::MAX,
            cfsr: u32::MAX,
            hfsr: u32::MAX,
            address: u32::MAX,
        };
        assert_eq!(PostMortem::from_words(&record.to_words()), Some(record));
    }

    #[test]
    fn a_place_is_cut_between_characters() {
        let name = "ü".repeat(30);
        let record = PostMortem::new(FailureCause::Panic, 0, 0).at(&name, 1);
        assert_eq!(record.place.len(), MAX_PLACE_BYTES);
        let odd = format!("{name}x");
        let record = PostMortem::new(FailureCause::Panic, 0, 0).at(&odd, 1);
        assert_eq!(record.place.len(), MAX_PLACE_BYTES - 1);
    }
}
