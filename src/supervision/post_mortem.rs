//! How a life ended: written by whoever notices, read after the reset.

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::checksum::CRC;

/// Most bytes of a place that are kept: its end, which names the file.
pub const PLACE: usize = 24;

/// Words in which a record is kept.
pub const WORDS: usize = 20;

/// Tells a record from memory that was never written: "died" in ASCII.
const MAGIC: u32 = 0x6469_6564;

/// Words of the place.
const PLACE_WORDS: usize = PLACE / 4;

/// Why a life ended. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// The program found itself wrong: place and line say where.
    Panic,
    /// An instruction, an address or a memory access that cannot be: `registers.pc`
    /// says where.
    Fault,
    /// The stack met its guard.
    StackOverflow,
    /// The watchdog was not fed: a task no longer ran.
    Watchdog,
}

/// The core's registers at a fault; zeros where they could not be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Registers {
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

/// How a life ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PostMortem {
    /// Why.
    pub cause: Cause,
    /// Steps of the filter since its configuration.
    pub step: u32,
    /// Age of that life, milliseconds, to 125.
    pub uptime_ms: u32,
    /// The end of the source file's name; empty for faults.
    pub place: String<PLACE, u8>,
    /// The line in it.
    pub line: u32,
    /// The core's registers; zeros for panics.
    pub registers: Registers,
}

impl PostMortem {
    /// A record of a life that ended so; place and registers are still to be filled.
    #[must_use]
    pub const fn new(cause: Cause, step: u32, uptime_ms: u32) -> Self {
        Self {
            cause,
            step,
            uptime_ms,
            place: String::new(),
            line: 0,
            registers: Registers {
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
        let mut start = file.len().saturating_sub(PLACE);
        while !file.is_char_boundary(start) {
            start += 1;
        }
        self.place.clear();
        // Cut to what fits.
        let _ = self.place.push_str(file.get(start..).unwrap_or_default());
        self.line = line;
        self
    }

    /// The record as words, with a checksum at the end.
    #[must_use]
    pub fn to_words(&self) -> [u32; WORDS] {
        let Registers {
            pc,
            lr,
            psr,
            sp,
            cfsr,
            hfsr,
            address,
        } = self.registers;
        let cause = match self.cause {
            Cause::Panic => 0,
            Cause::Fault => 1,
            Cause::StackOverflow => 2,
            Cause::Watchdog => 3,
        };
        let mut place = [0; PLACE_WORDS];
        for (word, bytes) in place.iter_mut().zip(self.place.as_bytes().chunks(4)) {
            *word = bytes
                .iter()
                .rev()
                .fold(0, |word, byte| word << 8 | u32::from(*byte));
        }
        let [p0, p1, p2, p3, p4, p5] = place;
        let length = self.place.len() as u32;
        let mut words = [
            MAGIC,
            cause,
            self.step,
            self.uptime_ms,
            self.line,
            length,
            p0,
            p1,
            p2,
            p3,
            p4,
            p5,
            pc,
            lr,
            psr,
            sp,
            cfsr,
            hfsr,
            address,
            0,
        ];
        let sum = checksum(&words);
        if let Some(last) = words.last_mut() {
            *last = sum;
        }
        words
    }

    /// The record in some words; `None` if they hold none, or a damaged one.
    #[must_use]
    pub fn from_words(words: &[u32; WORDS]) -> Option<Self> {
        let [
            magic,
            cause,
            step,
            uptime_ms,
            line,
            length,
            p0,
            p1,
            p2,
            p3,
            p4,
            p5,
            pc,
            lr,
            psr,
            sp,
            cfsr,
            hfsr,
            address,
            sum,
        ] = *words;
        if magic != MAGIC || sum != checksum(words) {
            return None;
        }
        let cause = match cause {
            0 => Cause::Panic,
            1 => Cause::Fault,
            2 => Cause::StackOverflow,
            3 => Cause::Watchdog,
            _ => return None,
        };
        let bytes = [p0, p1, p2, p3, p4, p5].map(u32::to_le_bytes);
        let name = bytes.as_flattened().get(..length as usize)?;
        let name = core::str::from_utf8(name).ok()?;
        let mut record = Self::new(cause, step, uptime_ms).at(name, line);
        record.registers = Registers {
            pc,
            lr,
            psr,
            sp,
            cfsr,
            hfsr,
            address,
        };
        Some(record)
    }
}

/// CRC of all words but the last.
fn checksum(words: &[u32; WORDS]) -> u32 {
    let mut digest = CRC.digest();
    for word in words.iter().take(WORDS - 1) {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> PostMortem {
        let mut record =
            PostMortem::new(Cause::Fault, 263, 12_345).at("some/where/else/src/filter/step.rs", 77);
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
        for word in 0..WORDS {
            for bit in 0..32 {
                let mut words = good;
                words[word] ^= 1 << bit;
                assert_eq!(PostMortem::from_words(&words), None, "{word}, {bit}");
            }
        }
        assert_eq!(PostMortem::from_words(&[0xa5a5_a5a5; WORDS]), None);
        assert_eq!(PostMortem::from_words(&[0; WORDS]), None);
    }

    #[test]
    fn a_place_is_cut_between_characters() {
        let name = "ü".repeat(30);
        let record = PostMortem::new(Cause::Panic, 0, 0).at(&name, 1);
        assert_eq!(record.place.len(), PLACE);
        let odd = format!("{name}x");
        let record = PostMortem::new(Cause::Panic, 0, 0).at(&odd, 1);
        assert_eq!(record.place.len(), PLACE - 1);
    }
}
