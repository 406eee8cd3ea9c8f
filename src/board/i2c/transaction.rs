//! One I2C transaction, from a start to a stop, as a value.

/// Most bytes that a transaction writes: the EEPROM's word address and a page of eight.
pub const LONGEST_WRITE: usize = 9;

/// Most bytes that a transaction reads.
pub const LONGEST_READ: usize = 16;

/// Bytes to write, then bytes to read after a repeated start; either may be none.
///
/// A transaction of neither is an address alone, which probes for a part.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusTransaction {
    address: u8,
    /// Zeros beyond those that are written.
    bytes: [u8; LONGEST_WRITE],
    write: u8,
    read: u8,
}

impl BusTransaction {
    /// Writes `bytes`, of which those beyond [`LONGEST_WRITE`] are cut off, then reads
    /// `read` bytes, at most [`LONGEST_READ`]. The address has seven bits.
    #[must_use]
    pub const fn new(address: u8, bytes: &[u8], read: u8) -> Self {
        let mut kept = [0; LONGEST_WRITE];
        let mut room: &mut [u8] = &mut kept;
        let mut rest = bytes;
        let mut write = 0;
        while let ([place, more @ ..], [byte, later @ ..]) = (room, rest) {
            *place = *byte;
            write += 1;
            room = more;
            rest = later;
        }
        Self {
            address: address & 0x7f,
            bytes: kept,
            write,
            read: if read as usize > LONGEST_READ {
                LONGEST_READ as u8
            } else {
                read
            },
        }
    }

    /// A sensor's transaction on the bus.
    #[must_use]
    pub const fn of_sensor(transaction: &vcnl4020::Transaction) -> Self {
        let read = transaction.read_length() as u8;
        Self::new(transaction.address(), transaction.write_bytes(), read)
    }

    /// A multiplexer's transaction on the bus.
    #[must_use]
    pub const fn of_mux(transaction: &pca9544a::Transaction) -> Self {
        let read = transaction.read_length() as u8;
        Self::new(transaction.address(), transaction.write_bytes(), read)
    }

    /// The part's address, seven bits.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// The bytes to write.
    #[must_use]
    pub fn to_write(&self) -> &[u8] {
        self.bytes
            .get(..usize::from(self.write))
            .unwrap_or_default()
    }

    /// How many bytes to read.
    #[must_use]
    pub const fn to_read(&self) -> usize {
        self.read as usize
    }

    /// How long the transaction holds the bus, in periods of its clock.
    #[must_use]
    pub fn clocks(&self) -> u32 {
        clocks(u32::from(self.write), u32::from(self.read))
    }
}

/// Clock periods of a transaction that writes and reads these numbers of bytes.
///
/// Nine per byte, the addresses included, and one for each start, repeated start and
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
    /// No part acknowledged the address.
    NoSuchPart,
    /// A part refused a byte that was written to it.
    RefusedByte,
    /// Another master, or a disturbance, pulled a line low that should be high.
    ArbitrationLost,
    /// A start or a stop was misplaced.
    Misplaced,
    /// The transaction did not end in its time.
    Overdue,
    /// A line is held low and nine clocks did not free it.
    HeldLow,
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
        let transaction = BusTransaction::new(0x93, &[7; 12], 40);
        assert_eq!(transaction.address(), 0x13);
        assert_eq!(transaction.to_write(), [7; LONGEST_WRITE]);
        assert_eq!(transaction.to_read(), LONGEST_READ);
    }

    #[test]
    fn transactions_of_the_parts_keep_their_bytes() {
        use vcnl4020::transactions::{read_measurement, write_thresholds};

        let mux = crate::board::i2c::muxed_bus::MUX_ADDRESS;
        let select = pca9544a::transactions::select(mux, pca9544a::Channel::Three);
        assert_eq!(
            BusTransaction::of_mux(&select),
            BusTransaction::new(0x77, &[7], 0)
        );
        let read = pca9544a::transactions::read_control(mux);
        assert_eq!(
            BusTransaction::of_mux(&read),
            BusTransaction::new(0x77, &[], 1)
        );
        let thresholds = write_thresholds(0x0102, 0x0304);
        let bytes = [0x8a, 1, 2, 3, 4];
        assert_eq!(
            BusTransaction::of_sensor(&thresholds),
            BusTransaction::new(0x13, &bytes, 0)
        );
        let measurement = BusTransaction::of_sensor(&read_measurement());
        assert_eq!(measurement, BusTransaction::new(0x13, &[0x85], 4));
        assert_eq!(measurement.clocks(), read_measurement().clocks());
        assert_eq!(BusTransaction::of_mux(&select).clocks(), select.clocks());
    }

    #[test]
    fn clocks_count_every_byte_and_every_start() {
        // Start, address, acknowledge, stop.
        assert_eq!(BusTransaction::new(0x13, &[], 0).clocks(), 11);
        assert_eq!(BusTransaction::new(0x13, &[0x80, 7], 0).clocks(), 29);
        assert_eq!(BusTransaction::new(0x77, &[], 1).clocks(), 20);
        assert_eq!(BusTransaction::new(0x13, &[0x85], 4).clocks(), 66);
    }
}
