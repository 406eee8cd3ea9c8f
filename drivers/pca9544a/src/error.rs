//! What can fail.

use crate::control::Selection;

/// Why an operation failed; `E` is the bus's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// A transaction failed on the bus.
    Bus(E),
    /// Another selection was read back than the one that was written.
    WrongSelection(Selection),
    /// The selection is unknown, so there is nothing to confirm; select or deselect first.
    UnknownSelection,
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::WrongSelection(found) => write!(f, "another selection was read back: {found:?}"),
            Self::UnknownSelection => f.write_str("the selection is unknown"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for Error<E> {}
