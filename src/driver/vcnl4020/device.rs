//! A VCNL4020 on a bus that waits for the end of each transaction.

use embedded_hal::i2c::I2c;

use super::registers::{
    Ambient, Command, IDENTITY, InterruptControl, InterruptStatus, LedCurrent, Measurement,
    ProximityRate,
};
use super::transactions::{self as say, Configuration};
use crate::driver::Transaction;

/// What went wrong with a VCNL4020.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed; its own words.
    Bus(E),
    /// Another part answers at the address; its identity byte.
    WrongIdentity(u8),
    /// No result is ready yet.
    NotReady,
    /// The part does not measure by itself: it was never started, or reset since.
    NotRunning,
    /// The part measures by itself and would ignore the setting.
    Running,
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::WrongIdentity(identity) => {
                write!(f, "identity is {identity:#04x} instead of {IDENTITY:#04x}")
            }
            Self::NotReady => f.write_str("no result is ready"),
            Self::NotRunning => f.write_str("the part does not measure by itself"),
            Self::Running => f.write_str("the part measures by itself and takes no rate"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for Error<E> {}

/// A VCNL4020 that the bus reaches, directly or through a multiplexer's channel.
///
/// No method waits or repeats beyond what its arguments say.
#[derive(Debug)]
pub struct Vcnl4020<I2C> {
    bus: I2C,
}

impl<I2C: I2c> Vcnl4020<I2C> {
    /// The part on this bus; says nothing to it yet.
    pub const fn new(bus: I2C) -> Self {
        Self { bus }
    }

    /// The bus back.
    pub fn release(self) -> I2C {
        self.bus
    }

    fn tell(&mut self, transaction: &Transaction) -> Result<(), Error<I2C::Error>> {
        transaction
            .exchange_on(&mut self.bus)
            .map(|_| ())
            .map_err(Error::Bus)
    }

    fn ask(&mut self, transaction: &Transaction) -> Result<u8, Error<I2C::Error>> {
        let answer = transaction.exchange_on(&mut self.bus).map_err(Error::Bus)?;
        Ok(answer.first().copied().unwrap_or_default())
    }

    /// Whether this is a VCNL4020. 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::WrongIdentity`]; [`Error::Bus`].
    pub fn check_identity(&mut self) -> Result<(), Error<I2C::Error>> {
        match self.ask(&say::identify())? {
            IDENTITY => Ok(()),
            other => Err(Error::WrongIdentity(other)),
        }
    }

    /// Checks the identity, sets everything and lets the part measure by itself.
    /// 15 bytes, 1.44 or 0.36 ms.
    ///
    /// # Errors
    /// [`Error::WrongIdentity`], then nothing was written; [`Error::Bus`].
    pub fn start(&mut self, configuration: &Configuration) -> Result<(), Error<I2C::Error>> {
        self.check_identity()?;
        self.stop()?;
        self.tell(&say::configure(configuration))?;
        self.tell(&say::command(Command::SELF_TIMED))
    }

    /// Ends self-timed measuring. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn stop(&mut self) -> Result<(), Error<I2C::Error>> {
        self.tell(&say::command(Command::STOP))
    }

    /// The command register. 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn command(&mut self) -> Result<Command, Error<I2C::Error>> {
        self.ask(&say::read_command()).map(Command)
    }

    /// Whether a part that was started has been reset since. 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn was_reset(&mut self) -> Result<bool, Error<I2C::Error>> {
        Ok(!self.command()?.is_self_timed())
    }

    fn while_stopped(&mut self, setting: &Transaction) -> Result<(), Error<I2C::Error>> {
        if self.command()?.is_self_timed() {
            return Err(Error::Running);
        }
        self.tell(setting)
    }

    /// Sets the proximity rate of a stopped part. 7 bytes, 680 or 170 us.
    ///
    /// # Errors
    /// [`Error::Running`]; [`Error::Bus`].
    pub fn set_proximity_rate(&mut self, rate: ProximityRate) -> Result<(), Error<I2C::Error>> {
        self.while_stopped(&say::set_proximity_rate(rate))
    }

    /// Sets how a stopped part measures ambient light. 7 bytes, 680 or 170 us.
    ///
    /// # Errors
    /// [`Error::Running`]; [`Error::Bus`].
    pub fn set_ambient(&mut self, ambient: Ambient) -> Result<(), Error<I2C::Error>> {
        self.while_stopped(&say::set_ambient(ambient))
    }

    /// Sets the diode's current. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_led_current(&mut self, current: LedCurrent) -> Result<(), Error<I2C::Error>> {
        self.tell(&say::set_led_current(current))
    }

    /// The newest result of a started part, once. 11 bytes, 1.05 or 0.26 ms.
    ///
    /// A result that arrives during the last byte may mix with the one before: about
    /// one in 50 at 100 kHz and 125 results a second. Read at a pace of your own, and
    /// ask [`Vcnl4020::proximity`] again where that matters; see
    /// [`Branch`](crate::driver::Branch), which does.
    ///
    /// # Errors
    /// [`Error::NotRunning`]; [`Error::NotReady`]; [`Error::Bus`].
    pub fn result(&mut self) -> Result<Measurement, Error<I2C::Error>> {
        let command = self.command()?;
        if !command.is_self_timed() {
            return Err(Error::NotRunning);
        }
        if !command.proximity_ready() {
            return Err(Error::NotReady);
        }
        self.read_result()
    }

    fn read_result(&mut self) -> Result<Measurement, Error<I2C::Error>> {
        let answer = say::read_result()
            .exchange_on(&mut self.bus)
            .map_err(Error::Bus)?;
        // The transaction reads the four bytes that the decoder wants.
        say::measurement(&answer).ok_or(Error::NotReady)
    }

    /// The proximity register as it is, ready or not. 5 bytes, 480 or 120 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn proximity(&mut self) -> Result<u16, Error<I2C::Error>> {
        let answer = say::read_proximity()
            .exchange_on(&mut self.bus)
            .map_err(Error::Bus)?;
        say::proximity(&answer).ok_or(Error::NotReady)
    }

    /// Measures both results once and asks up to `polls` times whether they are ready.
    /// Ends self-timed measuring. 10 bytes and 4 a poll.
    ///
    /// The polls follow each other at once, 390 or 98 us each; 32 averaged ambient
    /// conversions take far longer than the proximity measurement.
    ///
    /// # Errors
    /// [`Error::NotReady`] after the last poll; [`Error::Bus`].
    pub fn measure_once(&mut self, polls: u16) -> Result<Measurement, Error<I2C::Error>> {
        self.tell(&say::command(Command::ON_DEMAND))?;
        for _ in 0..polls {
            let command = self.command()?;
            if command.proximity_ready() && command.ambient_ready() {
                return self.read_result();
            }
        }
        Err(Error::NotReady)
    }

    /// Sets both thresholds. 6 bytes, 560 or 140 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_thresholds(&mut self, low: u16, high: u16) -> Result<(), Error<I2C::Error>> {
        self.tell(&say::set_thresholds(low, high))
    }

    /// Sets when the interrupt pin is pulled. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_interrupts(&mut self, control: InterruptControl) -> Result<(), Error<I2C::Error>> {
        self.tell(&say::set_interrupts(control))
    }

    /// Why the interrupt pin is pulled. 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn interrupts(&mut self) -> Result<InterruptStatus, Error<I2C::Error>> {
        self.ask(&say::read_interrupts()).map(InterruptStatus)
    }

    /// Clears these reasons; the pin is let go when none is left. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn clear_interrupts(&mut self, status: InterruptStatus) -> Result<(), Error<I2C::Error>> {
        self.tell(&say::clear_interrupts(status))
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};

    use super::super::{AmbientRate, Watched};
    use super::*;

    const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

    fn write(bytes: &[u8]) -> Expected {
        Expected::write(0x13, bytes.to_vec())
    }

    fn read(register: u8, answer: &[u8]) -> Expected {
        Expected::write_read(0x13, vec![register], answer.to_vec())
    }

    /// Runs `call` against exactly these transactions.
    fn on<R>(
        expected: &[Expected],
        call: impl FnOnce(&mut Vcnl4020<Mock>) -> Result<R, Error<ErrorKind>>,
    ) -> Result<R, Error<ErrorKind>> {
        let mut part = Vcnl4020::new(Mock::new(expected));
        let answer = call(&mut part);
        part.release().done();
        answer
    }

    /// Runs `call` once for each transaction, which then fails: the error must come
    /// out and nothing be said after it.
    fn fails_at_every_transaction<R: core::fmt::Debug + PartialEq>(
        expected: &[Expected],
        call: impl Fn(&mut Vcnl4020<Mock>) -> Result<R, Error<ErrorKind>>,
    ) {
        for index in 0..expected.len() {
            let mut cut = expected[..=index].to_vec();
            let last = cut.pop().unwrap().with_error(NACK);
            cut.push(last);
            assert_eq!(on(&cut, &call), Err(Error::Bus(NACK)), "at {index}");
        }
    }

    #[test]
    fn identity_is_checked() {
        assert_eq!(on(&[read(0x81, &[0x21])], Vcnl4020::check_identity), Ok(()));
        assert_eq!(
            on(&[read(0x81, &[0x22])], Vcnl4020::check_identity),
            Err(Error::WrongIdentity(0x22))
        );
        fails_at_every_transaction(&[read(0x81, &[0x21])], Vcnl4020::check_identity);
    }

    #[test]
    fn starting_stops_first_and_enables_last() {
        let expected = [
            read(0x81, &[0x21]),
            write(&[0x80, 0x00]),
            write(&[0x82, 0x06, 0x14, 0x15]),
            write(&[0x80, 0x07]),
        ];
        let start = |part: &mut Vcnl4020<Mock>| part.start(&Configuration::AMIRO);
        assert_eq!(on(&expected, start), Ok(()));
        fails_at_every_transaction(&expected, start);
    }

    #[test]
    fn a_stranger_is_not_written_to() {
        let start = |part: &mut Vcnl4020<Mock>| part.start(&Configuration::AMIRO);
        assert_eq!(
            on(&[read(0x81, &[0x55])], start),
            Err(Error::WrongIdentity(0x55))
        );
    }

    #[test]
    fn stopping_clears_the_command_register() {
        assert_eq!(on(&[write(&[0x80, 0x00])], Vcnl4020::stop), Ok(()));
        fails_at_every_transaction(&[write(&[0x80, 0x00])], Vcnl4020::stop);
    }

    #[test]
    fn a_reset_shows_in_the_command_register() {
        assert_eq!(on(&[read(0x80, &[0x80])], Vcnl4020::was_reset), Ok(true));
        assert_eq!(on(&[read(0x80, &[0x87])], Vcnl4020::was_reset), Ok(false));
        assert_eq!(
            on(&[read(0x80, &[0xa7])], Vcnl4020::command),
            Ok(Command(0xa7))
        );
        fails_at_every_transaction(&[read(0x80, &[0x87])], Vcnl4020::was_reset);
    }

    #[test]
    fn rates_are_set_only_while_stopped() {
        let rate = |part: &mut Vcnl4020<Mock>| part.set_proximity_rate(ProximityRate::Hz250);
        let expected = [read(0x80, &[0x80]), write(&[0x82, 0x07])];
        assert_eq!(on(&expected, rate), Ok(()));
        fails_at_every_transaction(&expected, rate);
        assert_eq!(on(&[read(0x80, &[0x87])], rate), Err(Error::Running));

        let settings = Ambient {
            continuous: false,
            rate: AmbientRate::Hz10,
            auto_offset: true,
            conversions_log2: 0,
        };
        let ambient = |part: &mut Vcnl4020<Mock>| part.set_ambient(settings);
        let expected = [read(0x80, &[0x80]), write(&[0x84, 0x78])];
        assert_eq!(on(&expected, ambient), Ok(()));
        fails_at_every_transaction(&expected, ambient);
        assert_eq!(on(&[read(0x80, &[0x87])], ambient), Err(Error::Running));
    }

    #[test]
    fn current_is_set_at_any_time() {
        let current = LedCurrent::from_milliamperes(50).unwrap();
        let set = |part: &mut Vcnl4020<Mock>| part.set_led_current(current);
        assert_eq!(on(&[write(&[0x83, 5])], set), Ok(()));
        fails_at_every_transaction(&[write(&[0x83, 5])], set);
    }

    #[test]
    fn a_result_is_read_only_when_ready() {
        let expected = [read(0x80, &[0xa7]), read(0x85, &[0x01, 0x02, 0x09, 0x92])];
        assert_eq!(
            on(&expected, Vcnl4020::result),
            Ok(Measurement {
                ambient: 0x0102,
                proximity: 2450,
            })
        );
        fails_at_every_transaction(&expected, Vcnl4020::result);
        // Only the ambient result is ready.
        assert_eq!(
            on(&[read(0x80, &[0xc7])], Vcnl4020::result),
            Err(Error::NotReady)
        );
        assert_eq!(
            on(&[read(0x80, &[0xa0])], Vcnl4020::result),
            Err(Error::NotRunning)
        );
    }

    #[test]
    fn proximity_alone_is_two_bytes() {
        let expected = [read(0x87, &[0x09, 0x92])];
        assert_eq!(on(&expected, Vcnl4020::proximity), Ok(2450));
        fails_at_every_transaction(&expected, Vcnl4020::proximity);
    }

    #[test]
    fn one_measurement_polls_as_often_as_allowed_and_no_more() {
        let once = |part: &mut Vcnl4020<Mock>| part.measure_once(3);
        let ready = [
            write(&[0x80, 0x18]),
            read(0x80, &[0x98]),
            read(0x80, &[0xb8]),
            read(0x80, &[0xe0]),
            read(0x85, &[0, 9, 0xff, 0xff]),
        ];
        assert_eq!(
            on(&ready, once),
            Ok(Measurement {
                ambient: 9,
                proximity: super::super::SATURATED,
            })
        );
        fails_at_every_transaction(&ready, once);
        let never = [
            write(&[0x80, 0x18]),
            read(0x80, &[0x98]),
            read(0x80, &[0x98]),
            read(0x80, &[0xb8]),
        ];
        assert_eq!(on(&never, once), Err(Error::NotReady));
        assert_eq!(
            on(&[write(&[0x80, 0x18])], |part| part.measure_once(0)),
            Err(Error::NotReady)
        );
    }

    #[test]
    fn thresholds_go_out_high_byte_first() {
        let expected = [write(&[0x8a, 0x01, 0x02, 0x03, 0x04])];
        let set = |part: &mut Vcnl4020<Mock>| part.set_thresholds(0x0102, 0x0304);
        assert_eq!(on(&expected, set), Ok(()));
        fails_at_every_transaction(&expected, set);
    }

    #[test]
    fn interrupts_are_set_read_and_cleared_by_writing_ones() {
        let control = InterruptControl {
            results_log2: 2,
            thresholds: Some(Watched::Proximity),
            ..InterruptControl::default()
        };
        let set = |part: &mut Vcnl4020<Mock>| part.set_interrupts(control);
        assert_eq!(on(&[write(&[0x89, 0b0100_0010])], set), Ok(()));
        fails_at_every_transaction(&[write(&[0x89, 0b0100_0010])], set);
        let asked = [read(0x8e, &[0x02])];
        let status = on(&asked, Vcnl4020::interrupts);
        assert_eq!(status, Ok(InterruptStatus(2)));
        fails_at_every_transaction(&asked, Vcnl4020::interrupts);
        // Bits that have no reason are never written.
        let clear = |part: &mut Vcnl4020<Mock>| part.clear_interrupts(InterruptStatus(0xf2));
        assert_eq!(on(&[write(&[0x8e, 0x02])], clear), Ok(()));
        fails_at_every_transaction(&[write(&[0x8e, 0x02])], clear);
    }

    #[test]
    fn documented_costs_are_those_of_the_transactions() {
        // In microseconds at 100 kHz.
        let cost = |list: &[Transaction]| list.iter().map(|t| t.clocks() * 10).sum::<u32>();
        assert_eq!(cost(&[say::identify()]), 390);
        assert_eq!(cost(&[say::command(Command::STOP)]), 290);
        assert_eq!(cost(&[say::read_command(), say::read_result()]), 1050);
        assert_eq!(cost(&[say::read_proximity()]), 480);
        assert_eq!(cost(&[say::set_thresholds(0, 0)]), 560);
        let start = [
            say::identify(),
            say::command(Command::STOP),
            say::configure(&Configuration::AMIRO),
            say::command(Command::SELF_TIMED),
        ];
        assert_eq!(cost(&start), 1440);
    }
}
