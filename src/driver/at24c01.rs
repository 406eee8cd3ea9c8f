//! Atmel's AT24C01: 128 bytes that survive without power.
//!
//! A transfer of reads runs through the memory and wraps at its end. A transfer of
//! writes wraps within a page of eight bytes, so a longer one is split at the pages'
//! bounds. After each page the part is busy for up to 5 ms and answers to nobody, which
//! is how its end is found. Facts from the maker's data sheet as open drivers tell it.
//! Up to 400 kHz.
//!
//! # Example
//!
//! ```
//! use amiro_ipf::driver::at24c01::{ADDRESS_AMIRO, writes};
//!
//! // Ten bytes from address 5: three to the end of the page, then seven.
//! let parts: Vec<_> = writes(ADDRESS_AMIRO, 5, &[9; 10]).collect();
//! assert_eq!(parts[0].to_write(), [5, 9, 9, 9]);
//! assert_eq!(parts[1].to_write(), [8, 9, 9, 9, 9, 9, 9, 9]);
//! ```

use embedded_hal::i2c::{Error as _, ErrorKind, I2c};

use super::{LONGEST_READ, Transaction};

/// The address with all three address pins low, as on the AMiRo.
pub const ADDRESS_AMIRO: u8 = 0x50;

/// Bytes in the memory.
pub const BYTES: usize = 128;

/// Bytes in a page.
pub const PAGE: usize = 8;

/// The longest write cycle, microseconds.
pub const WRITE_CYCLE_US: u32 = 5_000;

/// The transactions that read `length` bytes from `start` on, 16 at most each.
///
/// What lies beyond the memory's end is not read. Bytes on the bus: 3 a transaction
/// and 1 for each that is read.
pub fn reads(address: u8, start: u8, length: usize) -> impl Iterator<Item = Transaction> {
    let end = usize::from(start).saturating_add(length).min(BYTES);
    let mut next = usize::from(start);
    core::iter::from_fn(move || {
        let part = end.saturating_sub(next).min(LONGEST_READ);
        if part == 0 {
            return None;
        }
        let transaction = Transaction::new(address, &[next as u8], part as u8);
        next += part;
        Some(transaction)
    })
}

/// The transactions that write `bytes` from `start` on, each within a page.
///
/// What does not fit before the memory's end is not written. Between any two of them
/// the part must have answered to [`ask_whether_ready`]. Bytes on the bus: 2 a
/// transaction and 1 for each that is written.
pub fn writes(address: u8, start: u8, bytes: &[u8]) -> impl Iterator<Item = Transaction> {
    let room = BYTES.saturating_sub(usize::from(start));
    let mut rest = bytes.get(..room).unwrap_or(bytes);
    let mut next = usize::from(start);
    core::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (part, later) = rest
            .split_at_checked(PAGE - next % PAGE)
            .unwrap_or((rest, &[]));
        let mut message = [0; 1 + PAGE];
        let [word_address, data @ ..] = &mut message;
        *word_address = next as u8;
        for (place, byte) in data.iter_mut().zip(part) {
            *place = *byte;
        }
        rest = later;
        next += part.len();
        let used = message.get(..1 + part.len()).unwrap_or(&message);
        Some(Transaction::new(address, used, 0))
    })
}

/// An address alone: refused as [`NoSuchPart`](super::BusFault::NoSuchPart) as long as a
/// page is being written. 1 byte, 110 or 28 us.
#[must_use]
pub fn ask_whether_ready(address: u8) -> Transaction {
    Transaction::new(address, &[], 0)
}

/// What went wrong with an AT24C01.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed; its own words.
    Bus(E),
    /// The range goes beyond the memory's end; nothing was said to the part.
    OutOfRange,
    /// The part was still writing a page at the last poll.
    Busy,
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::OutOfRange => f.write_str("the range goes beyond the memory's end"),
            Self::Busy => f.write_str("the part is still writing"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for Error<E> {}

/// An AT24C01 on a bus that waits for the end of each transaction.
#[derive(Debug)]
pub struct At24c01<I2C> {
    bus: I2C,
    address: u8,
}

impl<I2C: I2c> At24c01<I2C> {
    /// The part at an address, 0x50 to 0x57; says nothing to it yet.
    pub const fn new(bus: I2C, address: u8) -> Self {
        Self { bus, address }
    }

    /// The bus back.
    pub fn release(self) -> I2C {
        self.bus
    }

    /// Fills `bytes` from `start` on. 3 bytes for every 16 and those that are read: 16
    /// take 1.74 or 0.44 ms.
    ///
    /// # Errors
    /// [`Error::OutOfRange`]; [`Error::Bus`], also when the part is writing; `bytes`
    /// may be half filled then.
    pub fn read(&mut self, start: u8, bytes: &mut [u8]) -> Result<(), Error<I2C::Error>> {
        check(start, bytes.len())?;
        let parts = reads(self.address, start, bytes.len());
        for (place, part) in bytes.chunks_mut(LONGEST_READ).zip(parts) {
            let answer = part.exchange_on(&mut self.bus).map_err(Error::Bus)?;
            for (byte, read) in place.iter_mut().zip(&answer) {
                *byte = *read;
            }
        }
        Ok(())
    }

    /// Writes `bytes` from `start` on, and asks up to `polls` times after each page
    /// whether it is done. 2 bytes a page and those written, 1 a poll: a page takes
    /// 0.92 or 0.23 ms and up to 5 ms of polls, 46 or 182 of them.
    ///
    /// No delay lies between the polls. On success the last page is written, not only
    /// sent.
    ///
    /// # Errors
    /// [`Error::OutOfRange`]; [`Error::Busy`] after the last poll; [`Error::Bus`]. The
    /// pages before are written then.
    pub fn write(&mut self, start: u8, bytes: &[u8], polls: u16) -> Result<(), Error<I2C::Error>> {
        check(start, bytes.len())?;
        for part in writes(self.address, start, bytes) {
            part.exchange_on(&mut self.bus).map_err(Error::Bus)?;
            self.wait(polls)?;
        }
        Ok(())
    }

    fn wait(&mut self, polls: u16) -> Result<(), Error<I2C::Error>> {
        for _ in 0..polls {
            match ask_whether_ready(self.address).exchange_on(&mut self.bus) {
                Ok(_) => return Ok(()),
                Err(error) if matches!(error.kind(), ErrorKind::NoAcknowledge(_)) => {}
                Err(error) => return Err(Error::Bus(error)),
            }
        }
        Err(Error::Busy)
    }
}

const fn check<E>(start: u8, length: usize) -> Result<(), Error<E>> {
    if (start as usize).saturating_add(length) > BYTES {
        return Err(Error::OutOfRange);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::NoAcknowledgeSource;
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};

    use super::*;

    const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

    fn memory(expected: &[Expected]) -> At24c01<Mock> {
        At24c01::new(Mock::new(expected), ADDRESS_AMIRO)
    }

    fn write(bytes: &[u8]) -> Expected {
        Expected::write(0x50, bytes.to_vec())
    }

    fn read(start: u8, answer: &[u8]) -> Expected {
        Expected::write_read(0x50, vec![start], answer.to_vec())
    }

    #[test]
    fn writes_of_every_range_arrive_in_a_memory_that_wraps_within_pages() {
        for start in (0..=130_u8).step_by(if cfg!(miri) { 43 } else { 1 }) {
            for length in 0..40 {
                let bytes: Vec<u8> = (1..=length).collect();
                let mut memory = [0; BYTES];
                for part in writes(0x50, start, &bytes) {
                    let [first, data @ ..] = part.to_write() else {
                        panic!("no word address")
                    };
                    for (index, byte) in data.iter().enumerate() {
                        let first = usize::from(*first);
                        memory[first / PAGE * PAGE + (first + index) % PAGE] = *byte;
                    }
                }
                let mut expected = [0; BYTES];
                for (place, byte) in expected.iter_mut().skip(start.into()).zip(&bytes) {
                    *place = *byte;
                }
                assert_eq!(memory, expected, "{length} bytes from {start}");
            }
        }
    }

    #[test]
    fn reads_cover_the_range_once_and_end_with_the_memory() {
        for start in (0..=130_u8).step_by(if cfg!(miri) { 43 } else { 1 }) {
            for length in 0..60 {
                let mut covered = Vec::new();
                for part in reads(0x50, start, length) {
                    let first = usize::from(part.to_write()[0]);
                    covered.extend(first..first + part.to_read());
                }
                let end = (usize::from(start) + length).min(BYTES);
                let expected: Vec<usize> = (usize::from(start)..end).collect();
                assert_eq!(covered, expected, "{length} bytes from {start}");
            }
        }
    }

    #[test]
    fn a_range_is_read_in_parts_of_sixteen() {
        let mut memory = memory(&[read(0x14, &[1; 16]), read(0x24, &[2; 4])]);
        let mut bytes = [0; 20];
        assert_eq!(memory.read(0x14, &mut bytes), Ok(()));
        assert_eq!(bytes[..16], [1; 16]);
        assert_eq!(bytes[16..], [2; 4]);
        memory.release().done();
    }

    #[test]
    fn a_failing_bus_ends_a_read() {
        let expected = [
            read(0x14, &[1; 16]),
            read(0x24, &[2; 4]).with_error(ErrorKind::Bus),
        ];
        let mut memory = memory(&expected);
        let outcome = memory.read(0x14, &mut [0; 20]);
        assert_eq!(outcome, Err(Error::Bus(ErrorKind::Bus)));
        memory.release().done();
    }

    #[test]
    fn each_page_is_waited_for() {
        let mut memory = memory(&[
            write(&[6, 1, 2]),
            write(&[]).with_error(NACK),
            write(&[]).with_error(NACK),
            write(&[]),
            write(&[8, 3]),
            write(&[]),
        ]);
        assert_eq!(memory.write(6, &[1, 2, 3], 3), Ok(()));
        memory.release().done();
    }

    #[test]
    fn a_part_that_never_gets_ready_is_given_up_after_the_last_poll() {
        let mut memory = memory(&[
            write(&[0, 1]),
            write(&[]).with_error(NACK),
            write(&[]).with_error(NACK),
        ]);
        assert_eq!(memory.write(0, &[1], 2), Err(Error::Busy));
        memory.release().done();
    }

    #[test]
    fn a_failing_bus_is_no_busy_part() {
        let error = ErrorKind::ArbitrationLoss;
        let mut polled = memory(&[write(&[0, 1]), write(&[]).with_error(error)]);
        assert_eq!(polled.write(0, &[1], 9), Err(Error::Bus(error)));
        polled.release().done();
        let mut refused = memory(&[write(&[0, 1]).with_error(NACK)]);
        assert_eq!(refused.write(0, &[1], 9), Err(Error::Bus(NACK)));
        refused.release().done();
    }

    #[test]
    fn beyond_the_end_nothing_is_said() {
        let mut memory = memory(&[]);
        assert_eq!(memory.read(120, &mut [0; 9]), Err(Error::OutOfRange));
        assert_eq!(memory.write(127, &[1, 2], 9), Err(Error::OutOfRange));
        assert_eq!(memory.write(128, &[], 9), Ok(()));
        memory.release().done();
    }

    #[test]
    fn documented_costs_are_those_of_the_transactions() {
        // In microseconds at 100 kHz.
        let read: u32 = reads(0x50, 0, 16).map(|part| part.clocks() * 10).sum();
        let page: u32 = writes(0x50, 0, &[0; 8])
            .map(|part| part.clocks() * 10)
            .sum();
        assert_eq!((read, page), (1740, 920));
        let poll = ask_whether_ready(0x50).clocks() * 10;
        assert_eq!(poll, 110);
        assert_eq!(WRITE_CYCLE_US.div_ceil(poll), 46);
        // 400 kHz: 27.5 us.
        assert_eq!((2 * WRITE_CYCLE_US).div_ceil(55), 182);
    }
}
