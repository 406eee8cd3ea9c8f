//! Transactions of Atmel's EEPROM AT24C01: 128 bytes, up to 400 kHz.
//!
//! A read runs through the memory and wraps at its end. A write wraps within a page of
//! eight bytes, so a longer one is split at the pages' bounds. After each page the part
//! is busy for up to 5 ms and does not acknowledge its address. Facts from the maker's
//! data sheet as cited by open drivers.
//!
//! # Example
//!
//! ```
//! use amiro_ipf::board::eeprom::{ADDRESS_AMIRO, writes};
//!
//! // Ten bytes from address 5: three to the end of the page, then seven.
//! let parts: Vec<_> = writes(ADDRESS_AMIRO, 5, &[9; 10]).collect();
//! assert_eq!(parts[0].to_write(), [5, 9, 9, 9]);
//! assert_eq!(parts[1].to_write(), [8, 9, 9, 9, 9, 9, 9, 9]);
//! ```

use super::i2c::{BusTransaction, LONGEST_READ};

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
/// Bytes beyond the memory's end are not read. Bytes on the bus: 3 per transaction and 1
/// per byte.
pub fn reads(address: u8, start: u8, length: usize) -> impl Iterator<Item = BusTransaction> {
    let end = usize::from(start).saturating_add(length).min(BYTES);
    let mut next = usize::from(start);
    core::iter::from_fn(move || {
        let part = end.saturating_sub(next).min(LONGEST_READ);
        if part == 0 {
            return None;
        }
        let transaction = BusTransaction::new(address, &[next as u8], part as u8);
        next += part;
        Some(transaction)
    })
}

/// The transactions that write `bytes` from `start` on, each within a page.
///
/// Bytes beyond the memory's end are not written. Between two transactions the part must
/// have acknowledged [`poll_ready`]. Bytes on the bus: 2 per transaction and 1 per byte.
pub fn writes(address: u8, start: u8, bytes: &[u8]) -> impl Iterator<Item = BusTransaction> {
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
        Some(BusTransaction::new(address, used, 0))
    })
}

/// An address alone: fails with [`NoSuchPart`](super::i2c::BusFault::NoSuchPart) while a
/// page is written. 1 byte, 110 us at 100 kHz, 28 us at 400 kHz.
#[must_use]
pub fn poll_ready(address: u8) -> BusTransaction {
    BusTransaction::new(address, &[], 0)
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn documented_costs_are_those_of_the_transactions() {
        // In microseconds at 100 kHz.
        let read: u32 = reads(0x50, 0, 16).map(|part| part.clocks() * 10).sum();
        let page: u32 = writes(0x50, 0, &[0; 8])
            .map(|part| part.clocks() * 10)
            .sum();
        assert_eq!((read, page), (1740, 920));
        let poll = poll_ready(0x50).clocks() * 10;
        assert_eq!(poll, 110);
        assert_eq!(WRITE_CYCLE_US.div_ceil(poll), 46);
        // 400 kHz: 27.5 us.
        assert_eq!((2 * WRITE_CYCLE_US).div_ceil(55), 182);
    }
}
