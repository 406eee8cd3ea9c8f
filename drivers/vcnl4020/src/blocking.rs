//! The sensor on a bus whose transfers block.

use embedded_hal::i2c::I2c;

use crate::error::Error;
use crate::registers::{
    Ambient, Command, Configuration, InterruptControl, InterruptStatus, LedCurrent, Measurement,
    ProximityRate,
};
use crate::sequences::{self, Sequence, Step};
use crate::transactions::{LONGEST_READ, Transaction};

/// A VCNL4020, VCNL4010 or VCNL3020 on a blocking bus of embedded-hal.
///
/// No method waits longer than its transfers take; the costs are bytes on the bus, and
/// time at 100 and at 400 kHz. Every method may fail with [`Error::Bus`].
#[derive(Debug)]
pub struct Vcnl4020<I2C> {
    i2c: I2C,
}

impl<I2C: I2c> Vcnl4020<I2C> {
    /// The sensor on this bus; no transfer.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c }
    }

    /// Gives the bus back.
    pub fn release(self) -> I2C {
        self.i2c
    }

    /// Runs a sequence to its end.
    ///
    /// # Errors
    /// Those of the sequence; [`Error::Bus`].
    pub fn run<S: Sequence>(&mut self, mut sequence: S) -> Result<S::Output, Error<I2C::Error>> {
        let mut buffer = [0; LONGEST_READ];
        let mut answer: &[u8] = &[];
        loop {
            match sequence.next(answer)? {
                Step::Execute(transaction) => {
                    answer = self
                        .execute(&transaction, &mut buffer)
                        .map_err(Error::Bus)?;
                }
                Step::Done(output) => return Ok(output),
            }
        }
    }

    /// Executes one transaction and gives the bytes that were read.
    ///
    /// # Errors
    /// The bus's own.
    pub fn execute<'a>(
        &mut self,
        transaction: &Transaction,
        buffer: &'a mut [u8; LONGEST_READ],
    ) -> Result<&'a [u8], I2C::Error> {
        let (address, bytes) = (transaction.address(), transaction.write_bytes());
        let read = buffer
            .get_mut(..transaction.read_length())
            .unwrap_or_default();
        if read.is_empty() {
            self.i2c.write(address, bytes)?;
        } else {
            self.i2c.write_read(address, bytes, read)?;
        }
        Ok(read)
    }

    /// Checks that the identity register is that of the supported parts. 4 bytes, 390 or
    /// 98 us.
    ///
    /// # Errors
    /// [`Error::WrongIdentity`].
    pub fn check_identity(&mut self) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::check_identity())
    }

    /// Checks the identity, writes the configuration and starts self-timed measuring. 15
    /// bytes, 1.44 or 0.36 ms.
    ///
    /// # Errors
    /// [`Error::WrongIdentity`]; nothing was written then.
    pub fn start(&mut self, configuration: &Configuration) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::start(configuration))
    }

    /// Ends self-timed measuring. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn stop(&mut self) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::stop())
    }

    /// Reads the command register: what is ready, and whether the sensor still measures.
    /// 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn command(&mut self) -> Result<Command, Error<I2C::Error>> {
        self.run(sequences::command())
    }

    /// Reads a new proximity result of a started sensor, counts; never a mixture of two.
    /// 14 bytes, 1.35 or 0.34 ms; 19 bytes if it changed meanwhile.
    ///
    /// # Errors
    /// [`Error::NotReady`] if there is none since the last reading; [`Error::NotRunning`]
    /// if the sensor was reset since its start.
    pub fn proximity(&mut self) -> Result<u16, Error<I2C::Error>> {
        self.run(sequences::proximity())
    }

    /// Reads a new ambient light result of a started sensor, in units of
    /// [`LUX_PER_COUNT`](crate::LUX_PER_COUNT); as [`Vcnl4020::proximity`] otherwise.
    /// Never ready on a VCNL3020.
    ///
    /// # Errors
    /// [`Error::NotReady`]; [`Error::NotRunning`].
    pub fn ambient(&mut self) -> Result<u16, Error<I2C::Error>> {
        self.run(sequences::ambient())
    }

    /// Measures ambient light and proximity once, with up to `polls` readings of the
    /// command register. Ends self-timed measuring. 10 bytes and 4 per poll, 390 or 98 us
    /// each.
    ///
    /// The polls follow each other without a delay: some 300 cover an ambient light
    /// result of 32 conversions at 100 kHz.
    ///
    /// # Errors
    /// [`Error::NotReady`] after the last poll.
    pub fn measure_once(&mut self, polls: u16) -> Result<Measurement, Error<I2C::Error>> {
        self.run(sequences::measure_once(polls))
    }

    /// Measures proximity once, counts, with up to `polls` readings of the command
    /// register. Ends self-timed measuring. 8 bytes and 4 per poll, 390 or 98 us each.
    ///
    /// # Errors
    /// [`Error::NotReady`] after the last poll; 10 polls are enough.
    pub fn measure_proximity_once(&mut self, polls: u16) -> Result<u16, Error<I2C::Error>> {
        self.run(sequences::measure_proximity_once(polls))
    }

    /// Sets the proximity rate of a stopped sensor. 7 bytes, 680 or 170 us.
    ///
    /// # Errors
    /// [`Error::Running`].
    pub fn set_proximity_rate(&mut self, rate: ProximityRate) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::set_proximity_rate(rate))
    }

    /// Sets the ambient light parameters of a stopped sensor; not on a VCNL3020. 7 bytes,
    /// 680 or 170 us.
    ///
    /// # Errors
    /// [`Error::Running`].
    pub fn set_ambient(&mut self, ambient: Ambient) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::set_ambient(ambient))
    }

    /// Sets the infrared diode's current, at any time. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_led_current(&mut self, current: LedCurrent) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::set_led_current(current))
    }

    /// Sets both thresholds, counts. 6 bytes, 560 or 140 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_thresholds(&mut self, low: u16, high: u16) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::set_thresholds(low, high))
    }

    /// Sets which events pull the interrupt pin low. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn set_interrupts(&mut self, control: InterruptControl) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::set_interrupts(control))
    }

    /// Reads which events pull the interrupt pin low. 4 bytes, 390 or 98 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn interrupts(&mut self) -> Result<InterruptStatus, Error<I2C::Error>> {
        self.run(sequences::interrupts())
    }

    /// Clears these events; the pin is released when none is left. 3 bytes, 290 or 73 us.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub fn clear_interrupts(&mut self, events: InterruptStatus) -> Result<(), Error<I2C::Error>> {
        self.run(sequences::clear(events))
    }
}
