//! What can fail.

use crate::registers::IDENTITY;

/// Why an operation failed; `E` is the bus's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// A transaction failed on the bus.
    Bus(E),
    /// Another part is at the address; the value of its identity register.
    WrongIdentity(u8),
    /// The result is not ready.
    NotReady,
    /// Self-timed measuring is off: it was never started, or the sensor was reset since.
    NotRunning,
    /// Self-timed measuring is on, and the sensor would ignore the new setting.
    Running,
    /// An answer has another length than its transaction; never from this crate's drivers.
    WrongLength,
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::WrongIdentity(identity) => {
                write!(f, "identity is {identity:#04x} instead of {IDENTITY:#04x}")
            }
            Self::NotReady => f.write_str("the result is not ready"),
            Self::NotRunning => f.write_str("self-timed measuring is off"),
            Self::Running => f.write_str("self-timed measuring is on; stop it to change rates"),
            Self::WrongLength => f.write_str("the answer has a wrong length"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for Error<E> {}
