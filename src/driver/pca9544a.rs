//! NXP's PCA9544A: one bus becomes one of four.
//!
//! The part has a single register that is written and read without an address. Bit 2
//! enables a channel, bits 1 and 0 name it, bits 4 to 7 read the channels' interrupt
//! lines. It is no switch with a bit for each channel, as the PCA9548A is: at most one
//! channel is connected. A channel is connected at the stop after the write; after a
//! reset of the part there is none. Facts from NXP's data sheet as open drivers tell
//! it. Up to 400 kHz.
//!
//! # Example
//!
//! ```
//! use amiro_ipf::driver::pca9544a::{ADDRESS_AMIRO, Channel, Error, Pca9544a, Selection};
//! use embedded_hal::i2c::{ErrorType, I2c, Operation};
//!
//! /// The part's register, with the interrupt line of channel 3 pulled.
//! struct Register(u8);
//!
//! impl ErrorType for Register {
//!     type Error = core::convert::Infallible;
//! }
//!
//! impl I2c for Register {
//!     fn transaction(&mut self, _: u8, list: &mut [Operation<'_>]) -> Result<(), Self::Error> {
//!         for operation in list {
//!             match operation {
//!                 Operation::Write(bytes) => self.0 = bytes[0] & 7,
//!                 Operation::Read(bytes) => bytes[0] = self.0 | 0x80,
//!             }
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let mut mux = Pca9544a::new(Register(0), ADDRESS_AMIRO);
//! mux.select(Channel::Two)?;
//! assert_eq!(mux.selection(), Selection::Channel(Channel::Two));
//! assert!(mux.interrupts()?.contains(Channel::Three));
//! # Ok::<(), Error<core::convert::Infallible>>(())
//! ```

use embedded_hal::i2c::I2c;

use super::Transaction;

/// The address with all three address pins high, as on the AMiRo.
pub const ADDRESS_AMIRO: u8 = 0x77;

/// One of the four channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(missing_docs, reason = "the names say it all")]
pub enum Channel {
    Zero,
    One,
    Two,
    Three,
}

impl Channel {
    /// All of them, ascending.
    pub const ALL: [Self; 4] = [Self::Zero, Self::One, Self::Two, Self::Three];

    /// Its number, 0 to 3.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }
}

/// Which channel is connected, as far as anyone knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Selection {
    /// None.
    None,
    /// This one.
    Channel(Channel),
    /// Anything may be: nothing was said yet, or something failed.
    Unknown,
}

/// The interrupt lines that are pulled, by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interrupts(u8);

impl Interrupts {
    /// Whether the line of this channel is pulled.
    #[must_use]
    pub const fn contains(self, channel: Channel) -> bool {
        self.0 & 1 << channel.number() != 0
    }

    /// Whether none is.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Connects a channel. 2 bytes.
#[must_use]
pub fn select(address: u8, channel: Channel) -> Transaction {
    Transaction::new(address, &[0x04 | channel.number()], 0)
}

/// Connects none. 2 bytes.
#[must_use]
pub fn deselect(address: u8) -> Transaction {
    Transaction::new(address, &[0x00], 0)
}

/// Asks for the register, one byte: [`selection`] and [`interrupts`]. 2 bytes.
#[must_use]
pub fn read_back(address: u8) -> Transaction {
    Transaction::new(address, &[], 1)
}

/// What the register says is connected; [`Selection::Unknown`] unless it is one byte.
#[must_use]
pub fn selection(answer: &[u8]) -> Selection {
    let [register] = *answer else {
        return Selection::Unknown;
    };
    match register & 0x07 {
        0x04 => Selection::Channel(Channel::Zero),
        0x05 => Selection::Channel(Channel::One),
        0x06 => Selection::Channel(Channel::Two),
        0x07 => Selection::Channel(Channel::Three),
        // Without the enable bit the number means nothing.
        _ => Selection::None,
    }
}

/// The interrupt lines in the register's upper half.
#[must_use]
pub fn interrupts(answer: &[u8]) -> Interrupts {
    Interrupts(answer.first().copied().unwrap_or_default() >> 4)
}

/// What went wrong with a PCA9544A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed; its own words.
    Bus(E),
    /// The part names another channel than the one it was told.
    WrongChannel(Selection),
    /// Nobody knows what is connected; [`Pca9544a::deselect`] first.
    UnknownSelection,
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::WrongChannel(found) => write!(f, "another selection was read back: {found:?}"),
            Self::UnknownSelection => f.write_str("the selection is unknown; deselect first"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for Error<E> {}

/// A PCA9544A on a bus that waits for the end of each transaction.
///
/// After any error the selection is [`Selection::Unknown`], and [`Pca9544a::deselect`],
/// which reads back that nothing is connected, is the only way out: two parts of one
/// address must never both be connected to a bus that has another multiplexer on it.
#[derive(Debug)]
pub struct Pca9544a<I2C> {
    bus: I2C,
    address: u8,
    selection: Selection,
}

impl<I2C: I2c> Pca9544a<I2C> {
    /// The part at an address, 0x70 to 0x77; says nothing to it yet.
    ///
    /// A reset of the controller may have come at any time, so what is connected is
    /// unknown; the first [`Pca9544a::select`] finds out by deselecting.
    pub const fn new(bus: I2C, address: u8) -> Self {
        Self {
            bus,
            address,
            selection: Selection::Unknown,
        }
    }

    /// The bus back.
    pub fn release(self) -> I2C {
        self.bus
    }

    /// The bus, for the parts behind the connected channel.
    pub fn bus(&mut self) -> &mut I2C {
        &mut self.bus
    }

    /// What is connected, as far as this driver knows; costs nothing.
    pub const fn selection(&self) -> Selection {
        self.selection
    }

    /// Connects a channel and reads it back. 4 bytes, 400 or 100 us; twice that from
    /// an unknown selection, which is left by deselecting first.
    ///
    /// # Errors
    /// [`Error::WrongChannel`]; [`Error::Bus`]. The selection is unknown then.
    pub fn select(&mut self, channel: Channel) -> Result<(), Error<I2C::Error>> {
        if self.selection == Selection::Unknown {
            self.deselect()?;
        }
        self.change(&select(self.address, channel), Selection::Channel(channel))
    }

    /// Connects none and reads it back. 4 bytes, 400 or 100 us.
    ///
    /// # Errors
    /// [`Error::WrongChannel`]; [`Error::Bus`]. The selection is unknown then.
    pub fn deselect(&mut self) -> Result<(), Error<I2C::Error>> {
        self.change(&deselect(self.address), Selection::None)
    }

    fn change(
        &mut self,
        transaction: &Transaction,
        wanted: Selection,
    ) -> Result<(), Error<I2C::Error>> {
        self.selection = Selection::Unknown;
        transaction.exchange_on(&mut self.bus).map_err(Error::Bus)?;
        let answer = read_back(self.address)
            .exchange_on(&mut self.bus)
            .map_err(Error::Bus)?;
        let found = selection(&answer);
        if found != wanted {
            return Err(Error::WrongChannel(found));
        }
        self.selection = wanted;
        Ok(())
    }

    /// Asks whether the selection still is what it was: after a reading, before it is
    /// believed. 2 bytes, 200 or 50 us.
    ///
    /// # Errors
    /// [`Error::WrongChannel`]; [`Error::Bus`]; the selection is unknown then.
    /// [`Error::UnknownSelection`] when it was before.
    pub fn confirm(&mut self) -> Result<(), Error<I2C::Error>> {
        self.interrupts().map(|_| ())
    }

    /// The interrupt lines that are pulled; confirms the selection on the way. 2 bytes,
    /// 200 or 50 us.
    ///
    /// # Errors
    /// As [`Pca9544a::confirm`].
    pub fn interrupts(&mut self) -> Result<Interrupts, Error<I2C::Error>> {
        let before = core::mem::replace(&mut self.selection, Selection::Unknown);
        if before == Selection::Unknown {
            return Err(Error::UnknownSelection);
        }
        let answer = read_back(self.address)
            .exchange_on(&mut self.bus)
            .map_err(Error::Bus)?;
        let found = selection(&answer);
        if found != before {
            return Err(Error::WrongChannel(found));
        }
        self.selection = before;
        Ok(interrupts(&answer))
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};

    use super::*;

    const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

    fn write(byte: u8) -> Expected {
        Expected::write(0x77, vec![byte])
    }

    fn read(byte: u8) -> Expected {
        Expected::read(0x77, vec![byte])
    }

    fn mux(expected: &[Expected]) -> Pca9544a<Mock> {
        Pca9544a::new(Mock::new(expected), ADDRESS_AMIRO)
    }

    #[test]
    fn a_channel_is_a_number_and_not_a_bit() {
        for (channel, byte) in Channel::ALL.into_iter().zip([0x04, 0x05, 0x06, 0x07]) {
            assert_eq!(select(0x77, channel).to_write(), [byte]);
            assert_eq!(selection(&[byte | 0xf0]), Selection::Channel(channel));
        }
    }

    #[test]
    fn every_register_value_has_one_meaning() {
        for register in 0..=u8::MAX {
            let expected = match (register & 4, register & 3) {
                (0, _) => Selection::None,
                (_, number) => Selection::Channel(Channel::ALL[usize::from(number)]),
            };
            assert_eq!(selection(&[register]), expected, "{register:#04x}");
        }
        assert_eq!(selection(&[]), Selection::Unknown);
    }

    #[test]
    fn the_first_selection_deselects_before_it_and_the_next_does_not() {
        let mut mux = mux(&[
            write(0),
            read(0),
            write(0x05),
            read(0x05),
            write(0x07),
            read(0x07),
            write(0),
            read(0),
        ]);
        assert_eq!(mux.selection(), Selection::Unknown);
        assert_eq!(mux.select(Channel::One), Ok(()));
        assert_eq!(mux.selection(), Selection::Channel(Channel::One));
        assert_eq!(mux.select(Channel::Three), Ok(()));
        assert_eq!(mux.deselect(), Ok(()));
        assert_eq!(mux.selection(), Selection::None);
        mux.release().done();
    }

    #[test]
    fn f07_a_lost_write_is_found_and_only_deselecting_makes_up_for_it() {
        let mut mux = mux(&[
            write(0),
            read(0),
            // The write is lost: none is still connected.
            write(0x06),
            read(0x00),
            // The next attempt begins with none, seen with the own eyes.
            write(0),
            read(0),
            write(0x06),
            read(0x06),
        ]);
        let lost = Error::WrongChannel(Selection::None);
        assert_eq!(mux.select(Channel::Two), Err(lost));
        assert_eq!(mux.selection(), Selection::Unknown);
        assert_eq!(mux.confirm(), Err(Error::UnknownSelection));
        assert_eq!(mux.select(Channel::Two), Ok(()));
        mux.release().done();
    }

    #[test]
    fn any_failure_of_the_bus_leaves_the_selection_unknown() {
        let sound = [write(0), read(0), write(0x04), read(0x04), read(0x04)];
        for index in 0..sound.len() {
            let mut expected = sound[..=index].to_vec();
            let last = expected.pop().unwrap().with_error(NACK);
            expected.push(last);
            let mut mux = mux(&expected);
            let outcome = mux.select(Channel::Zero).and_then(|()| mux.confirm());
            assert_eq!(outcome, Err(Error::Bus(NACK)), "at {index}");
            assert_eq!(mux.selection(), Selection::Unknown, "at {index}");
            mux.release().done();
        }
    }

    #[test]
    fn a_selection_that_does_not_go_away_is_an_error() {
        let mut mux = mux(&[write(0), read(0x05)]);
        let stays = Error::WrongChannel(Selection::Channel(Channel::One));
        assert_eq!(mux.deselect(), Err(stays));
        assert_eq!(mux.selection(), Selection::Unknown);
        mux.release().done();
    }

    #[test]
    fn interrupt_bits_are_told_by_channel_and_confirm_the_selection() {
        let mut mux = mux(&[write(0), read(0), read(0x50), read(0x00), read(0x04)]);
        assert_eq!(mux.deselect(), Ok(()));
        let pulled = mux.interrupts().unwrap();
        assert!(pulled.contains(Channel::Zero) && pulled.contains(Channel::Two));
        assert!(!pulled.contains(Channel::One) && !pulled.contains(Channel::Three));
        assert!(mux.interrupts().unwrap().is_empty());
        let other = Error::WrongChannel(Selection::Channel(Channel::Zero));
        assert_eq!(mux.interrupts(), Err(other));
        assert_eq!(mux.selection(), Selection::Unknown);
        mux.release().done();
    }

    #[test]
    fn the_bus_is_at_hand_for_the_parts_behind() {
        let mut mux = mux(&[Expected::write(0x13, vec![0x80])]);
        assert_eq!(mux.bus().write(0x13, &[0x80]), Ok(()));
        mux.release().done();
    }
}
