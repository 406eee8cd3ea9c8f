//! The multiplexer on a bus whose transfers are awaited.

use embedded_hal_async::i2c::I2c;

use crate::change::{Change, confirm};
use crate::control::{Address, Channel, Interrupts, Selection};
use crate::error::Error;
use crate::transactions::{Transaction, read_control};

/// A PCA9544A on a bus of embedded-hal-async.
///
/// After any error, and after a method's future was dropped before its end, the selection is [`Selection::Unknown`], and the next change begins
/// with a deselection that is read back. No method waits longer than its transfers take;
/// the costs are bytes on the bus, and time at 100 and at 400 kHz. Every method may fail
/// with [`Error::Bus`].
#[derive(Debug)]
pub struct Pca9544aAsync<I2C> {
    i2c: I2C,
    address: Address,
    selection: Selection,
}

impl<I2C: I2c> Pca9544aAsync<I2C> {
    /// The multiplexer at this address, its selection unknown; no transfer.
    ///
    /// A channel may be connected since before the program started.
    pub const fn new(i2c: I2C, address: Address) -> Self {
        Self {
            i2c,
            address,
            selection: Selection::Unknown,
        }
    }

    /// Gives the bus back.
    pub fn release(self) -> I2C {
        self.i2c
    }

    /// The bus, for the parts on the selected channel.
    ///
    /// Drivers that own their bus take `&mut` of it: `Part::new(mux.bus())`.
    pub fn bus(&mut self) -> &mut I2C {
        &mut self.i2c
    }

    /// The selection as it was read back last; no transfer.
    pub const fn selection(&self) -> Selection {
        self.selection
    }

    /// Connects a channel and reads it back. 4 bytes, 400 or 100 us; twice that from an
    /// unknown selection.
    ///
    /// # Errors
    /// [`Error::WrongSelection`].
    pub async fn select(&mut self, channel: Channel) -> Result<(), Error<I2C::Error>> {
        self.change(Some(channel)).await
    }

    /// Connects no channel and reads it back. 4 bytes, 400 or 100 us.
    ///
    /// # Errors
    /// [`Error::WrongSelection`].
    pub async fn deselect(&mut self) -> Result<(), Error<I2C::Error>> {
        self.change(None).await
    }

    /// Reads back that the selection is still the same: after a part was read, before its
    /// answer is used. 2 bytes, 200 or 50 us.
    ///
    /// # Errors
    /// [`Error::WrongSelection`]; [`Error::UnknownSelection`], without a transfer.
    pub async fn confirm(&mut self) -> Result<(), Error<I2C::Error>> {
        self.interrupts().await.map(|_| ())
    }

    /// Reads which interrupt inputs are low, and confirms the selection. 2 bytes, 200 or
    /// 50 us.
    ///
    /// # Errors
    /// As [`Self::confirm`].
    pub async fn interrupts(&mut self) -> Result<Interrupts, Error<I2C::Error>> {
        let expected = core::mem::replace(&mut self.selection, Selection::Unknown);
        if expected == Selection::Unknown {
            return Err(Error::UnknownSelection);
        }
        let answer = self.execute(&read_control(self.address)).await?;
        let interrupts = confirm(expected, &answer)?;
        self.selection = expected;
        Ok(interrupts)
    }

    async fn change(&mut self, to: Option<Channel>) -> Result<(), Error<I2C::Error>> {
        let mut change = Change::new(self.address, self.selection, to);
        self.selection = Selection::Unknown;
        let mut answer = [0];
        while let Some(transaction) = change.next(&answer)? {
            answer = self.execute(&transaction).await?;
        }
        self.selection = to.map_or(Selection::None, Selection::Channel);
        Ok(())
    }

    /// Executes a transaction and gives the byte that was read; 0 if none was.
    async fn execute(&mut self, transaction: &Transaction) -> Result<[u8; 1], Error<I2C::Error>> {
        let mut answer = [0];
        if transaction.read_length() == 0 {
            self.i2c
                .write(transaction.address(), transaction.write_bytes())
                .await
        } else {
            self.i2c.read(transaction.address(), &mut answer).await
        }
        .map_err(Error::Bus)?;
        Ok(answer)
    }
}
