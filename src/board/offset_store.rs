//! The memory of the offsets: read once at start, written after a calibration.

use crate::board::eeprom::{self, ADDRESS_AMIRO};
use crate::board::i2c::{BusFault, BusTransaction};
use crate::board::offsets::{Offsets, STORE_BYTES, StoreFault};

/// Where the offsets begin; what lies before them is AMiRo-OS's.
const OFFSETS_AT: usize = 0x14;
/// How long a memory is left alone after a page, microseconds: its longest write cycle.
const WRITE_CYCLE_US: u64 = eeprom::WRITE_CYCLE_US as u64;
/// Between two questions to a memory that is still writing, microseconds.
const POLL_PERIOD_US: u64 = 1_000;
/// Questions after which it is given up.
const MAX_POLLS: u8 = 20;

/// What the memory is polls next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Idle,
    /// Reads the so-manyth part of what is kept.
    Read(usize),
    /// Writes the so-manyth part of the offsets.
    Write(usize),
    /// Waits for the end of this part's write cycle.
    Settle {
        part: usize,
        poll_us: u64,
        polls: u8,
    },
}

/// Reads and writes the offsets, a transaction at a time.
///
/// A memory without AMiRo's mark is neither believed nor written: what is in it is
/// somebody else's.
#[derive(Clone, Debug)]
pub(super) struct OffsetStore {
    work: Work,
    bytes: [u8; STORE_BYTES],
    filled: usize,
    has_mark: bool,
    /// What was read, if that ended just now; `None` if it cannot be believed.
    read: Option<Option<Offsets>>,
}

impl OffsetStore {
    /// A store that will first be read.
    pub(super) const fn new() -> Self {
        Self {
            work: Work::Read(0),
            bytes: [0; STORE_BYTES],
            filled: 0,
            has_mark: false,
            read: None,
        }
    }

    /// Begins to write offsets, if the memory is one of AMiRo's; whether it is.
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
            // What is stored may be old in part. Both halves are offsets of this ring.
            (Work::Idle | Work::Write(_) | Work::Settle { .. }, _) => Work::Idle,
        };
    }

    /// Keeps a part that was read; after the last one, judges the whole.
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

    /// What was read since the last call.
    pub(super) fn take_read(&mut self) -> Option<Option<Offsets>> {
        self.read.take()
    }
}
