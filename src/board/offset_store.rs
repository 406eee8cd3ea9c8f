//! Reads the offsets from the EEPROM at start and writes them after a calibration.

use crate::board::eeprom::{self, ADDRESS_AMIRO};
use crate::board::i2c::{BusFault, BusTransaction};
use crate::board::offsets::{OFFSETS_AT, Offsets, STORE_BYTES, StoreFault};

/// Time after the write of a page without a poll, microseconds: the longest write cycle.
const WRITE_CYCLE_US: u64 = eeprom::WRITE_CYCLE_US as u64;
/// Time between two polls of an EEPROM that is still writing, microseconds.
const POLL_PERIOD_US: u64 = 1_000;
/// Polls after which writing is given up.
const MAX_POLLS: u8 = 20;

/// What the next transaction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Idle,
    /// Reads this part of the stored bytes.
    Read(usize),
    /// Writes this part of the offsets.
    Write(usize),
    /// Waits for the end of this part's write cycle.
    Settle {
        part: usize,
        poll_us: u64,
        polls: u8,
    },
}

/// Reads and writes the offsets, one transaction at a time.
///
/// The contents of an EEPROM without AMiRo's mark are neither used nor overwritten.
#[derive(Clone, Debug)]
pub(super) struct OffsetStore {
    work: Work,
    bytes: [u8; STORE_BYTES],
    filled: usize,
    has_mark: bool,
    /// The offsets that were just read; the inner `None` if they are unusable.
    read: Option<Option<Offsets>>,
}

impl Default for OffsetStore {
    fn default() -> Self {
        Self {
            work: Work::Read(0),
            bytes: [0; STORE_BYTES],
            filled: 0,
            has_mark: false,
            read: None,
        }
    }
}

impl OffsetStore {
    /// Begins to write offsets if the EEPROM has AMiRo's mark; whether it does.
    pub(super) fn write(&mut self, offsets: &Offsets) -> bool {
        if self.has_mark {
            offsets.encode(&mut self.bytes);
            self.work = Work::Write(0);
        }
        self.has_mark
    }

    /// The transaction to execute next.
    pub(super) fn next(&self, now_us: u64) -> Option<BusTransaction> {
        match self.work {
            Work::Idle => None,
            Work::Read(part) => eeprom::reads(ADDRESS_AMIRO, 0, STORE_BYTES).nth(part),
            Work::Write(part) => self.writes().nth(part),
            Work::Settle { poll_us, .. } => {
                (now_us >= poll_us).then(|| eeprom::poll_ready(ADDRESS_AMIRO))
            }
        }
    }

    fn writes(&self) -> impl Iterator<Item = BusTransaction> {
        let offsets = self.bytes.get(OFFSETS_AT..).unwrap_or_default();
        eeprom::writes(ADDRESS_AMIRO, OFFSETS_AT as u8, offsets)
    }

    /// Takes the result of the transaction before.
    pub(super) fn answer(&mut self, now_us: u64, result: Result<&[u8], BusFault>) {
        self.work = match (self.work, result) {
            (Work::Read(part), Ok(answer)) => self.take(part, answer),
            (Work::Read(_), Err(_)) => {
                self.read = Some(None);
                Work::Idle
            }
            (Work::Write(part), Ok(_)) => Work::Settle {
                part,
                poll_us: now_us.saturating_add(WRITE_CYCLE_US),
                polls: 0,
            },
            (Work::Settle { part, .. }, Ok(_)) => match self.writes().nth(part + 1) {
                Some(_) => Work::Write(part + 1),
                None => Work::Idle,
            },
            (Work::Settle { part, polls, .. }, Err(BusFault::NoSuchPart)) if polls < MAX_POLLS => {
                Work::Settle {
                    part,
                    poll_us: now_us.saturating_add(POLL_PERIOD_US),
                    polls: polls + 1,
                }
            }
            // Some of the stored offsets may be the old ones, which fit this ring as well.
            (Work::Idle | Work::Write(_) | Work::Settle { .. }, _) => Work::Idle,
        };
    }

    /// Stores a part that was read; decodes all of them after the last one.
    fn take(&mut self, part: usize, answer: &[u8]) -> Work {
        let rest = self.bytes.get_mut(self.filled..).unwrap_or_default();
        for (place, byte) in rest.iter_mut().zip(answer) {
            *place = *byte;
        }
        self.filled += answer.len();
        if self.filled < STORE_BYTES && !answer.is_empty() {
            return Work::Read(part + 1);
        }
        let decoded = Offsets::decode(&self.bytes);
        self.has_mark = decoded != Err(StoreFault::NoMark);
        self.read = Some(decoded.ok());
        Work::Idle
    }

    /// The offsets that were read since the last call.
    pub(super) fn take_read(&mut self) -> Option<Option<Offsets>> {
        self.read.take()
    }
}
