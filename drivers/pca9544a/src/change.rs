//! Change and confirmation of the selection, without a bus.

use crate::control::{Address, Channel, Interrupts, Selection, interrupts, selection};
use crate::error::Error;
use crate::transactions::{Transaction, deselect, read_control, select};

/// Change of the selection, as a state machine that an executor runs.
///
/// What is written is read back. From an unknown selection all channels are disconnected
/// first, which is read back too: two parts with one address are so never connected at
/// once, even if another multiplexer shares the bus and is handled alike.
///
/// [`Pca9544a`](crate::Pca9544a) and `Pca9544aAsync` run it; a program with its own bus
/// driver does so:
///
/// ```
/// use pca9544a::{Address, Change, Channel, Error, Selection, Transaction};
///
/// /// Starts a transfer and waits for its end; here the register keeps what is written.
/// fn transfer(transaction: &Transaction, register: &mut u8) -> Result<u8, &'static str> {
///     if let [value] = transaction.write_bytes() {
///         *register = *value;
///     }
///     Ok(*register)
/// }
///
/// let address = Address::from_pins(true, true, true);
/// let mut change = Change::new(address, Selection::Unknown, Some(Channel::One));
/// let (mut register, mut answer) = (0, 0);
/// while let Some(transaction) = change.next(&[answer])? {
///     answer = transfer(&transaction, &mut register).map_err(Error::Bus)?;
/// }
/// assert_eq!(register, 0x05);
/// # Ok::<(), Error<&'static str>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Change {
    address: Address,
    to: Option<Channel>,
    stage: ChangeStage,
}

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum ChangeStage {
    Deselect,
    ReadDeselected,
    CheckDeselected,
    Select(Channel),
    ReadSelected(Channel),
    CheckSelected(Channel),
    Done,
}

impl Change {
    /// The change from a selection to a channel or, with `None`, to no channel.
    #[must_use]
    pub const fn new(address: Address, from: Selection, to: Option<Channel>) -> Self {
        let stage = match (from, to) {
            (Selection::Unknown, _) | (_, None) => ChangeStage::Deselect,
            (_, Some(channel)) => ChangeStage::Select(channel),
        };
        Self { address, to, stage }
    }

    /// Takes the answer to the transaction before, and gives the next one; `None` when the
    /// new selection is read back. At most four transactions, 8 bytes, 800 or 200 us.
    ///
    /// The answer to a transaction that reads nothing is ignored. After an error,
    /// including one of the bus, the selection is unknown and the change is over.
    ///
    /// # Errors
    /// [`Error::WrongSelection`].
    pub fn next<E>(&mut self, answer: &[u8]) -> Result<Option<Transaction>, Error<E>> {
        if self.stage == ChangeStage::CheckDeselected {
            check(Selection::None, answer)?;
            self.stage = self.to.map_or(ChangeStage::Done, ChangeStage::Select);
        }
        let (transaction, stage) = match self.stage {
            ChangeStage::Deselect => (deselect(self.address), ChangeStage::ReadDeselected),
            ChangeStage::ReadDeselected => {
                (read_control(self.address), ChangeStage::CheckDeselected)
            }
            ChangeStage::Select(channel) => (
                select(self.address, channel),
                ChangeStage::ReadSelected(channel),
            ),
            ChangeStage::ReadSelected(channel) => (
                read_control(self.address),
                ChangeStage::CheckSelected(channel),
            ),
            ChangeStage::CheckSelected(channel) => {
                check(Selection::Channel(channel), answer)?;
                self.stage = ChangeStage::Done;
                return Ok(None);
            }
            ChangeStage::CheckDeselected | ChangeStage::Done => return Ok(None),
        };
        self.stage = stage;
        Ok(Some(transaction))
    }
}

/// Compares a control register that was read with the selection that it should have, and
/// gives its interrupt bits.
///
/// # Errors
/// [`Error::WrongSelection`] if another one is connected; [`Error::UnknownSelection`] if
/// it should have no particular one.
pub fn confirm<E>(expected: Selection, answer: &[u8]) -> Result<Interrupts, Error<E>> {
    if expected == Selection::Unknown {
        return Err(Error::UnknownSelection);
    }
    check(expected, answer)?;
    Ok(interrupts(answer))
}

fn check<E>(expected: Selection, answer: &[u8]) -> Result<(), Error<E>> {
    let found = selection(answer);
    if found == expected {
        Ok(())
    } else {
        Err(Error::WrongSelection(found))
    }
}
