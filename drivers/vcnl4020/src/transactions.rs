//! Transactions as values, and the decoders of their answers.
//!
//! For programs that drive the bus themselves, such as by interrupts or DMA: execute
//! [`Transaction::write_bytes`] and [`Transaction::read_length`] in one transfer, then
//! give the bytes that were read to the decoder. Everything here is `const`, takes some
//! ten instructions and cannot panic.
//!
//! ```
//! use vcnl4020::transactions::{measurement, read_measurement};
//!
//! let transaction = read_measurement();
//! assert_eq!(transaction.address(), 0x13);
//! assert_eq!(transaction.write_bytes(), [0x85]);
//! assert_eq!(transaction.read_length(), 4);
//! // What the bus read.
//! let measured = measurement(&[0x00, 0x64, 0x0a, 0x00]).unwrap();
//! assert_eq!((measured.ambient, measured.proximity), (100, 2_560));
//! ```

use crate::registers::{
    ADDRESS, Ambient, Command, Configuration, InterruptControl, InterruptStatus, LedCurrent,
    Measurement, ProximityRate, Register,
};

/// Most bytes that a transaction writes: a register's address and two thresholds.
pub const LONGEST_WRITE: usize = 5;

/// Most bytes that a transaction reads: both results.
pub const LONGEST_READ: usize = 4;

/// Bytes to write and, after a repeated start, bytes to read; 7 bytes of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transaction {
    bytes: [u8; LONGEST_WRITE],
    write: u8,
    read: u8,
}

impl Transaction {
    const fn read(register: Register, length: u8) -> Self {
        Self {
            bytes: [register as u8, 0, 0, 0, 0],
            write: 1,
            read: length,
        }
    }

    const fn write(register: Register, value: u8) -> Self {
        Self {
            bytes: [register as u8, value, 0, 0, 0],
            write: 2,
            read: 0,
        }
    }

    /// Address of the part, 7 bits: [`ADDRESS`].
    #[must_use]
    pub const fn address(&self) -> u8 {
        ADDRESS
    }

    /// Bytes to write: the address of a register, then its new values if there are any.
    #[must_use]
    pub const fn write_bytes(&self) -> &[u8] {
        match self.bytes.split_at_checked(self.write as usize) {
            Some((written, _)) => written,
            None => &self.bytes,
        }
    }

    /// Number of bytes to read after a repeated start; 0 for none, up to
    /// [`LONGEST_READ`].
    #[must_use]
    pub const fn read_length(&self) -> usize {
        self.read as usize
    }

    /// Time on the bus in periods of its clock: 9 for each byte and each address, 1 for
    /// each start, repeated start and stop.
    #[must_use]
    pub const fn clocks(&self) -> u32 {
        let write = self.write as u32;
        if self.read == 0 {
            2 + 9 * (1 + write)
        } else {
            3 + 9 * (2 + write + self.read as u32)
        }
    }
}

/// Reads the identity register, one byte: [`IDENTITY`](crate::IDENTITY). 4 bytes, 390 or
/// 98 us.
#[must_use]
pub const fn read_identity() -> Transaction {
    Transaction::read(Register::Identity, 1)
}

/// Reads the command register, one byte: [`Command`]. 4 bytes, 390 or 98 us.
#[must_use]
pub const fn read_command() -> Transaction {
    Transaction::read(Register::Command, 1)
}

/// Writes the command register. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn write_command(command: Command) -> Transaction {
    Transaction::write(Register::Command, command.0)
}

/// Writes rate, current and, if there are any, ambient light parameters. 4 or 5 bytes,
/// 380 or 470 us, 95 or 118 us.
///
/// Takes effect on the rates only while self-timed measuring is off.
#[must_use]
pub const fn write_configuration(configuration: &Configuration) -> Transaction {
    let (ambient, write) = match configuration.ambient {
        Some(ambient) => (ambient.bits(), 4),
        None => (0, 3),
    };
    Transaction {
        bytes: [
            Register::ProximityRate as u8,
            configuration.rate.bits(),
            configuration.led.bits(),
            ambient,
            0,
        ],
        write,
        read: 0,
    }
}

/// Writes the proximity rate; ignored while self-timed measuring is on. 3 bytes, 290 or
/// 73 us.
#[must_use]
pub const fn write_proximity_rate(rate: ProximityRate) -> Transaction {
    Transaction::write(Register::ProximityRate, rate.bits())
}

/// Writes the infrared diode's current. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn write_led_current(current: LedCurrent) -> Transaction {
    Transaction::write(Register::LedCurrent, current.bits())
}

/// Writes the ambient light parameters; the rate is ignored while self-timed measuring
/// is on. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn write_ambient(ambient: Ambient) -> Transaction {
    Transaction::write(Register::Ambient, ambient.bits())
}

/// Reads both results, see [`measurement`], and clears their ready bits. 7 bytes, 660 or
/// 165 us.
#[must_use]
pub const fn read_measurement() -> Transaction {
    Transaction::read(Register::AmbientResult, 4)
}

/// Reads the ambient light result, see [`result`], and clears its ready bit. 5 bytes, 480
/// or 120 us.
#[must_use]
pub const fn read_ambient() -> Transaction {
    Transaction::read(Register::AmbientResult, 2)
}

/// Reads the proximity result, see [`result`], and clears its ready bit. 5 bytes, 480 or
/// 120 us.
#[must_use]
pub const fn read_proximity() -> Transaction {
    Transaction::read(Register::ProximityResult, 2)
}

/// Writes both thresholds, counts. 6 bytes, 560 or 140 us.
#[must_use]
pub const fn write_thresholds(low: u16, high: u16) -> Transaction {
    let [low_high, low_low] = low.to_be_bytes();
    let [high_high, high_low] = high.to_be_bytes();
    Transaction {
        bytes: [
            Register::LowThreshold as u8,
            low_high,
            low_low,
            high_high,
            high_low,
        ],
        write: 5,
        read: 0,
    }
}

/// Writes which events pull the interrupt pin low. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn write_interrupt_control(control: InterruptControl) -> Transaction {
    Transaction::write(Register::InterruptControl, control.bits())
}

/// Reads which events pull the interrupt pin low, one byte: [`InterruptStatus`]. 4 bytes,
/// 390 or 98 us.
#[must_use]
pub const fn read_interrupt_status() -> Transaction {
    Transaction::read(Register::InterruptStatus, 1)
}

/// Clears these events; the pin is released when none is left. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn clear_interrupts(events: InterruptStatus) -> Transaction {
    Transaction::write(Register::InterruptStatus, events.0 & InterruptStatus::ALL.0)
}

/// Decodes the answer to [`read_measurement`]; `None` unless it has four bytes.
#[must_use]
pub const fn measurement(answer: &[u8]) -> Option<Measurement> {
    let [ambient_high, ambient_low, high, low] = *answer else {
        return None;
    };
    Some(Measurement {
        ambient: u16::from_be_bytes([ambient_high, ambient_low]),
        proximity: u16::from_be_bytes([high, low]),
    })
}

/// Decodes the answer to [`read_ambient`] or [`read_proximity`], counts; `None` unless it
/// has two bytes.
#[must_use]
pub const fn result(answer: &[u8]) -> Option<u16> {
    let [high, low] = *answer else {
        return None;
    };
    Some(u16::from_be_bytes([high, low]))
}

/// Decodes the answer to a transaction that reads one byte; `None` unless it has one.
#[must_use]
pub const fn byte(answer: &[u8]) -> Option<u8> {
    let [byte] = *answer else {
        return None;
    };
    Some(byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_of_another_length_is_not_decoded() {
        assert_eq!(byte(&[]), None);
        assert_eq!(byte(&[1, 2]), None);
        assert_eq!(result(&[1]), None);
        assert_eq!(result(&[1, 2, 3]), None);
        assert_eq!(measurement(&[1, 2, 3]), None);
        assert_eq!(measurement(&[1, 2, 3, 4, 5]), None);
    }

    #[test]
    fn a_configuration_without_ambient_light_leaves_its_register_alone() {
        let configuration = Configuration {
            rate: ProximityRate::Hz125,
            led: LedCurrent::MAX,
            ambient: None,
        };
        let transaction = write_configuration(&configuration);
        assert_eq!(transaction.write_bytes(), [0x82, 0x06, 0x14]);
    }

    /// Time of each transaction at 100 kHz and at 400 kHz, microseconds, rounded up.
    #[test]
    fn documented_costs_are_those_of_the_transactions() {
        let cost = |transaction: Transaction| {
            let clocks = transaction.clocks();
            (clocks * 10, (clocks * 5).div_ceil(2))
        };
        for (transaction, expected) in [
            (read_identity(), (390, 98)),
            (read_command(), (390, 98)),
            (read_interrupt_status(), (390, 98)),
            (write_command(Command::STOP), (290, 73)),
            (write_configuration(&Configuration::default()), (470, 118)),
            (read_measurement(), (660, 165)),
            (read_ambient(), (480, 120)),
            (read_proximity(), (480, 120)),
            (write_thresholds(0, 0), (560, 140)),
        ] {
            assert_eq!(cost(transaction), expected, "{transaction:?}");
        }
    }
}
