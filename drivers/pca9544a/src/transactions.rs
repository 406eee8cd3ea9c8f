//! Transactions as values, and the decoders of their answers.
//!
//! For programs that drive the bus themselves, such as by interrupts or DMA: execute
//! [`Transaction::write_bytes`] or [`Transaction::read_length`] in one transfer, then
//! give the byte that was read to [`selection`] and [`interrupts`]. Everything here is
//! `const`, takes some ten instructions and cannot panic.
//!
//! ```
//! use pca9544a::transactions::{read_control, select, selection};
//! use pca9544a::{Address, Channel, Selection};
//!
//! const MUX: Address = Address::from_pins(true, true, true);
//! let write = select(MUX, Channel::Two);
//! assert_eq!((write.address(), write.write_bytes()), (0x77, &[0x06][..]));
//! assert_eq!(read_control(MUX).read_length(), 1);
//! // What the bus read: channel 2, no interrupts.
//! assert_eq!(selection(&[0x06]), Selection::Channel(Channel::Two));
//! ```

use crate::control::{Address, Channel, Selection};

pub use crate::control::{interrupts, selection};

/// The control register, written or read; 3 bytes of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transaction {
    address: Address,
    /// The register's new value; `None` reads it.
    control: Option<u8>,
}

impl Transaction {
    /// Address of the part, 7 bits.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address.bits()
    }

    /// Bytes to write: the control register's new value, or none.
    #[must_use]
    pub const fn write_bytes(&self) -> &[u8] {
        self.control.as_slice()
    }

    /// Number of bytes to read: 1 if none is written, else 0.
    #[must_use]
    pub const fn read_length(&self) -> usize {
        match self.control {
            Some(_) => 0,
            None => 1,
        }
    }

    /// Time on the bus in periods of its clock: 9 for each byte and the address, 1 for
    /// start and stop each.
    #[must_use]
    pub const fn clocks(&self) -> u32 {
        2 + 9 * 2
    }
}

/// Connects a channel, at the stop. 2 bytes, 200 or 50 us.
#[must_use]
pub const fn select(address: Address, channel: Channel) -> Transaction {
    write(address, Selection::Channel(channel))
}

/// Connects no channel. 2 bytes, 200 or 50 us.
#[must_use]
pub const fn deselect(address: Address) -> Transaction {
    write(address, Selection::None)
}

/// Reads the control register, one byte: [`selection`] and [`interrupts`]. 2 bytes, 200
/// or 50 us.
#[must_use]
pub const fn read_control(address: Address) -> Transaction {
    Transaction {
        address,
        control: None,
    }
}

const fn write(address: Address, selection: Selection) -> Transaction {
    Transaction {
        address,
        control: Some(selection.bits()),
    }
}
