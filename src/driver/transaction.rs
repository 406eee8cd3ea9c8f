//! What goes over an I2C bus between a start and a stop, as a value.

use embedded_hal::i2c::{Error, ErrorKind, I2c, NoAcknowledgeSource};
use heapless::Vec;

/// Most bytes that a transaction writes: a memory's word address and a page of eight.
pub const LONGEST_WRITE: usize = 9;

/// Most bytes that a transaction reads.
pub const LONGEST_READ: usize = 16;

/// Bytes to write, then bytes to read after a repeated start; either may be none.
///
/// A transaction of neither is an address alone, which asks whether a part is there.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transaction {
    address: u8,
    write: Vec<u8, LONGEST_WRITE, u8>,
    read: u8,
}

impl Transaction {
    /// Writes `bytes`, of which those beyond [`LONGEST_WRITE`] are cut off, then reads
    /// `read` bytes, at most [`LONGEST_READ`]. The address has seven bits.
    #[must_use]
    pub fn new(address: u8, bytes: &[u8], read: u8) -> Self {
        let mut write = Vec::new();
        for byte in bytes {
            if write.push(*byte).is_err() {
                break;
            }
        }
        Self {
            address: address & 0x7f,
            write,
            read: read.min(LONGEST_READ as u8),
        }
    }

    /// The part's address, seven bits.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// The bytes to write.
    #[must_use]
    pub fn to_write(&self) -> &[u8] {
        &self.write
    }

    /// How many bytes to read.
    #[must_use]
    pub const fn to_read(&self) -> usize {
        self.read as usize
    }

    /// Executes the transaction on a bus that waits for its end.
    ///
    /// Answers with the bytes that were read.
    ///
    /// # Errors
    /// What the bus says went wrong.
    pub fn run_on<I: I2c>(&self, bus: &mut I) -> Result<Vec<u8, LONGEST_READ, u8>, BusFault> {
        self.exchange_on(bus)
            .map_err(|error| BusFault::from(error.kind()))
    }

    /// As [`Transaction::run_on`], with the error in the bus's own words.
    ///
    /// # Errors
    /// The bus's own.
    pub fn exchange_on<I: I2c>(&self, bus: &mut I) -> Result<Vec<u8, LONGEST_READ, u8>, I::Error> {
        let mut answer = Vec::new();
        // `read` is at most the capacity.
        let _ = answer.resize(self.to_read(), 0);
        match (self.write.is_empty(), self.read) {
            (_, 0) => bus.write(self.address, &self.write),
            (true, _) => bus.read(self.address, &mut answer),
            (false, _) => bus.write_read(self.address, &self.write, &mut answer),
        }?;
        Ok(answer)
    }

    /// How long the transaction holds the bus, in periods of its clock.
    #[must_use]
    pub fn clocks(&self) -> u32 {
        clocks(self.write.len() as u32, u32::from(self.read))
    }
}

/// Clock periods of a transaction that writes and reads so many bytes.
///
/// Nine a byte, the addresses included, and one for each start, repeated start and
/// stop. A part that stretches the clock takes longer; none on the robot does.
#[must_use]
pub const fn clocks(write: u32, read: u32) -> u32 {
    if write == 0 || read == 0 {
        2 + 9 * (1 + write + read)
    } else {
        3 + 9 * (2 + write + read)
    }
}

/// How a transaction failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusFault {
    /// Nobody answered to the address.
    NoSuchPart,
    /// A part refused a byte that was written to it.
    RefusedByte,
    /// Another master, or a disturbance, pulled a line that was to be high.
    ArbitrationLost,
    /// A start or a stop came where none may be.
    Misplaced,
    /// The transaction did not end in its time.
    Overdue,
    /// A line is held low and nine clocks did not free it.
    HeldLow,
}

impl From<ErrorKind> for BusFault {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data) => Self::RefusedByte,
            ErrorKind::NoAcknowledge(_) => Self::NoSuchPart,
            ErrorKind::ArbitrationLoss => Self::ArbitrationLost,
            ErrorKind::Overrun => Self::Overdue,
            // `Bus`, and whatever else an implementation does not tell apart.
            _ => Self::Misplaced,
        }
    }
}

impl Error for BusFault {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoSuchPart => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Self::RefusedByte => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            Self::ArbitrationLost => ErrorKind::ArbitrationLoss,
            Self::Misplaced | Self::HeldLow => ErrorKind::Bus,
            Self::Overdue => ErrorKind::Other,
        }
    }
}

impl core::fmt::Display for BusFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoSuchPart => "no part answers to the address",
            Self::RefusedByte => "a part refused a byte",
            Self::ArbitrationLost => "arbitration was lost",
            Self::Misplaced => "a start or stop was misplaced",
            Self::Overdue => "the transaction did not end in its time",
            Self::HeldLow => "a line of the bus is held low",
        })
    }
}

impl core::error::Error for BusFault {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_cut_off() {
        let transaction = Transaction::new(0x93, &[7; 12], 40);
        assert_eq!(transaction.address(), 0x13);
        assert_eq!(transaction.to_write(), [7; LONGEST_WRITE]);
        assert_eq!(transaction.to_read(), LONGEST_READ);
    }

    #[test]
    fn clocks_count_every_byte_and_every_start() {
        // Start, address, acknowledge, stop.
        assert_eq!(Transaction::new(0x13, &[], 0).clocks(), 11);
        assert_eq!(Transaction::new(0x13, &[0x80, 7], 0).clocks(), 29);
        assert_eq!(Transaction::new(0x77, &[], 1).clocks(), 20);
        assert_eq!(Transaction::new(0x13, &[0x85], 4).clocks(), 66);
    }
}
