//! What is said to a VCNL4020, and what its answers mean.

use super::registers::{
    ADDRESS, Ambient, Command, InterruptControl, InterruptStatus, LedCurrent, Measurement,
    ProximityRate, Register,
};
use crate::driver::Transaction;

/// How the part measures by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Configuration {
    /// Proximity measurements a second.
    pub rate: ProximityRate,
    /// Current of the infrared diode. More reaches farther and warms the part.
    pub led: LedCurrent,
    /// How ambient light is measured.
    pub ambient: Ambient,
}

impl Configuration {
    /// As AMiRo-OS leaves it: 125 proximity results a second at 200 mA.
    pub const AMIRO: Self = Self {
        rate: ProximityRate::Hz125,
        led: LedCurrent::MAX,
        ambient: Ambient::AMIRO,
    };
}

/// Reads one byte from a register.
fn read(register: Register) -> Transaction {
    Transaction::new(ADDRESS, &[register as u8], 1)
}

/// Writes one byte to a register.
fn write(register: Register, value: u8) -> Transaction {
    Transaction::new(ADDRESS, &[register as u8, value], 0)
}

/// Asks for the identity, one byte: [`IDENTITY`](super::IDENTITY).
#[must_use]
pub fn identify() -> Transaction {
    read(Register::Identity)
}

/// Asks for the command register, one byte: [`Command`].
#[must_use]
pub fn read_command() -> Transaction {
    read(Register::Command)
}

/// Writes the command register. Rates may change only after [`Command::STOP`].
#[must_use]
pub fn command(command: Command) -> Transaction {
    write(Register::Command, command.0)
}

/// Sets rate, current and ambient parameters in one transfer.
#[must_use]
pub fn configure(configuration: &Configuration) -> Transaction {
    let bytes = [
        Register::ProximityRate as u8,
        configuration.rate.bits(),
        configuration.led.bits(),
        configuration.ambient.bits(),
    ];
    Transaction::new(ADDRESS, &bytes, 0)
}

/// Sets the proximity rate.
#[must_use]
pub fn set_proximity_rate(rate: ProximityRate) -> Transaction {
    write(Register::ProximityRate, rate.bits())
}

/// Sets the diode's current, at any time.
#[must_use]
pub fn set_led_current(current: LedCurrent) -> Transaction {
    write(Register::LedCurrent, current.bits())
}

/// Sets how ambient light is measured.
#[must_use]
pub fn set_ambient(ambient: Ambient) -> Transaction {
    write(Register::Ambient, ambient.bits())
}

/// Asks for both results in one transfer; see [`measurement`].
#[must_use]
pub fn read_result() -> Transaction {
    Transaction::new(ADDRESS, &[Register::Result as u8], 4)
}

/// Asks for the proximity result alone; see [`proximity`].
#[must_use]
pub fn read_proximity() -> Transaction {
    Transaction::new(ADDRESS, &[Register::ProximityResult as u8], 2)
}

/// Sets both thresholds, low then high.
#[must_use]
pub fn set_thresholds(low: u16, high: u16) -> Transaction {
    let [low_high, low_low] = low.to_be_bytes();
    let [high_high, high_low] = high.to_be_bytes();
    let register = Register::LowThreshold as u8;
    Transaction::new(
        ADDRESS,
        &[register, low_high, low_low, high_high, high_low],
        0,
    )
}

/// Sets when the interrupt pin is pulled.
#[must_use]
pub fn set_interrupts(control: InterruptControl) -> Transaction {
    write(Register::InterruptControl, control.bits())
}

/// Asks why the interrupt pin is pulled, one byte: [`InterruptStatus`].
#[must_use]
pub fn read_interrupts() -> Transaction {
    read(Register::InterruptStatus)
}

/// Clears these reasons.
#[must_use]
pub fn clear_interrupts(status: InterruptStatus) -> Transaction {
    write(Register::InterruptStatus, status.0 & InterruptStatus::ALL.0)
}

/// The answer to [`read_result`]; `None` unless it has four bytes.
#[must_use]
pub fn measurement(answer: &[u8]) -> Option<Measurement> {
    let [ambient_high, ambient_low, high, low] = *answer else {
        return None;
    };
    Some(Measurement {
        ambient: u16::from_be_bytes([ambient_high, ambient_low]),
        proximity: u16::from_be_bytes([high, low]),
    })
}

/// The answer to [`read_proximity`]; `None` unless it has two bytes.
#[must_use]
pub fn proximity(answer: &[u8]) -> Option<u16> {
    let [high, low] = *answer else {
        return None;
    };
    Some(u16::from_be_bytes([high, low]))
}
