//! Operations of several transactions, as state machines that an executor runs.
//!
//! A [`Sequence`] is the only implementation of its operation: [`Vcnl4020`](crate::Vcnl4020)
//! runs it on a blocking bus, `Vcnl4020Async` on an asynchronous one, and a program with
//! its own bus driver as follows.
//!
//! ```
//! use vcnl4020::{Error, Sequence, Step, Transaction, sequences};
//!
//! /// Starts a transfer and waits for its end; here each sensor register reads 0x21.
//! fn transfer(transaction: &Transaction) -> Result<Vec<u8>, &'static str> {
//!     Ok(vec![0x21; transaction.read_length()])
//! }
//!
//! let mut sequence = sequences::check_identity();
//! let mut answer = Vec::new();
//! loop {
//!     match sequence.next(&answer)? {
//!         Step::Execute(transaction) => answer = transfer(&transaction).map_err(Error::Bus)?,
//!         Step::Done(()) => break,
//!     }
//! }
//! # Ok::<(), Error<&'static str>>(())
//! ```

use crate::error::Error;
use crate::registers::{
    Ambient, Command, Configuration, IDENTITY, InterruptControl, InterruptStatus, LedCurrent,
    Measurement, ProximityRate,
};
use crate::transactions::{
    Transaction, byte, clear_interrupts, measurement, read_ambient, read_command, read_identity,
    read_interrupt_status, read_measurement, read_proximity, result, write_ambient, write_command,
    write_configuration, write_interrupt_control, write_led_current, write_proximity_rate,
    write_thresholds,
};

/// Transactions in turn, each chosen by the answers before it, with one output.
pub trait Sequence {
    /// Result of the whole.
    type Output;

    /// Takes the answer to the transaction before, and gives the next one or the output.
    ///
    /// The first call's answer is ignored. After the output or an error, including one of
    /// the bus, the sequence is over and not called again.
    ///
    /// # Errors
    /// Those of the operation; never [`Error::Bus`].
    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<Self::Output>, Error<E>>;
}

/// What a [`Sequence`] wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Step<T> {
    /// This transaction is to be executed.
    Execute(Transaction),
    /// The operation is complete.
    Done(T),
}

/// One transaction and the decoder of its answer.
#[derive(Clone, Copy, Debug)]
pub struct Single<T> {
    transaction: Transaction,
    decode: fn(&[u8]) -> Option<T>,
    is_sent: bool,
}

impl<T> Single<T> {
    const fn new(transaction: Transaction, decode: fn(&[u8]) -> Option<T>) -> Self {
        Self {
            transaction,
            decode,
            is_sent: false,
        }
    }
}

impl Single<()> {
    const fn write(transaction: Transaction) -> Self {
        Self::new(transaction, |_| Some(()))
    }
}

impl<T> Sequence for Single<T> {
    type Output = T;

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<T>, Error<E>> {
        if !self.is_sent {
            self.is_sent = true;
            return Ok(Step::Execute(self.transaction));
        }
        (self.decode)(answer)
            .map(Step::Done)
            .ok_or(Error::WrongLength)
    }
}

/// Ends self-timed measuring. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn stop() -> Single<()> {
    Single::write(write_command(Command::STOP))
}

/// Reads the command register. 4 bytes, 390 or 98 us.
#[must_use]
pub const fn command() -> Single<Command> {
    Single::new(read_command(), decode_command)
}

/// Writes the infrared diode's current. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn set_led_current(current: LedCurrent) -> Single<()> {
    Single::write(write_led_current(current))
}

/// Writes both thresholds. 6 bytes, 560 or 140 us.
#[must_use]
pub const fn set_thresholds(low: u16, high: u16) -> Single<()> {
    Single::write(write_thresholds(low, high))
}

/// Writes which events pull the interrupt pin low. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn set_interrupts(control: InterruptControl) -> Single<()> {
    Single::write(write_interrupt_control(control))
}

/// Reads which events pull the interrupt pin low. 4 bytes, 390 or 98 us.
#[must_use]
pub const fn interrupts() -> Single<InterruptStatus> {
    Single::new(read_interrupt_status(), |answer| {
        byte(answer).map(InterruptStatus)
    })
}

/// Clears these events. 3 bytes, 290 or 73 us.
#[must_use]
pub const fn clear(events: InterruptStatus) -> Single<()> {
    Single::write(clear_interrupts(events))
}

/// Check of the identity register; see [`check_identity`].
#[derive(Clone, Copy, Debug)]
pub struct CheckIdentity(Single<u8>);

/// Reads the identity register and compares it. 4 bytes, 390 or 98 us.
#[must_use]
pub const fn check_identity() -> CheckIdentity {
    CheckIdentity(Single::new(read_identity(), byte))
}

impl Sequence for CheckIdentity {
    type Output = ();

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<()>, Error<E>> {
        match self.0.next(answer)? {
            Step::Execute(transaction) => Ok(Step::Execute(transaction)),
            Step::Done(IDENTITY) => Ok(Step::Done(())),
            Step::Done(other) => Err(Error::WrongIdentity(other)),
        }
    }
}

/// Start of self-timed measuring; see [`start`].
#[derive(Clone, Copy, Debug)]
pub struct Start {
    identity: CheckIdentity,
    writes: [Transaction; 3],
    written: usize,
}

/// Checks the identity, stops, writes the configuration and starts. 14 or 15 bytes, 1.35
/// or 1.44 ms, 0.34 or 0.36 ms.
///
/// A part with another identity is not written to.
#[must_use]
pub const fn start(configuration: &Configuration) -> Start {
    Start {
        identity: check_identity(),
        writes: [
            write_command(Command::STOP),
            write_configuration(configuration),
            write_command(configuration.command()),
        ],
        written: 0,
    }
}

impl Sequence for Start {
    type Output = ();

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<()>, Error<E>> {
        if self.written == 0
            && let Step::Execute(transaction) = self.identity.next(answer)?
        {
            return Ok(Step::Execute(transaction));
        }
        let write = self.writes.get(self.written);
        self.written += 1;
        Ok(write.map_or(Step::Done(()), |write| Step::Execute(*write)))
    }
}

/// Change of a setting that the sensor takes only while stopped; see
/// [`set_proximity_rate`] and [`set_ambient`].
#[derive(Clone, Copy, Debug)]
pub struct SetWhileStopped {
    command: Single<Command>,
    setting: Single<()>,
}

impl SetWhileStopped {
    const fn new(setting: Transaction) -> Self {
        Self {
            command: command(),
            setting: Single::write(setting),
        }
    }
}

/// Writes the proximity rate of a stopped sensor. 7 bytes, 680 or 170 us.
#[must_use]
pub const fn set_proximity_rate(rate: ProximityRate) -> SetWhileStopped {
    SetWhileStopped::new(write_proximity_rate(rate))
}

/// Writes the ambient light parameters of a stopped sensor. 7 bytes, 680 or 170 us.
#[must_use]
pub const fn set_ambient(ambient: Ambient) -> SetWhileStopped {
    SetWhileStopped::new(write_ambient(ambient))
}

impl Sequence for SetWhileStopped {
    type Output = ();

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<()>, Error<E>> {
        if !self.setting.is_sent {
            match self.command.next(answer)? {
                Step::Execute(transaction) => return Ok(Step::Execute(transaction)),
                Step::Done(command) if command.is_self_timed() => return Err(Error::Running),
                Step::Done(_) => {}
            }
        }
        self.setting.next(answer)
    }
}

/// Reading of a result of self-timed measuring; see [`proximity`] and [`ambient`].
#[derive(Clone, Copy, Debug)]
pub struct ReadResult {
    command: Single<Command>,
    is_ready: fn(Command) -> bool,
    read: Transaction,
    reads: u8,
    last: u16,
}

/// Reads the proximity result if a new one is ready, counts. 14 bytes, 1.35 or 0.34 ms;
/// 19 bytes, 1.83 or 0.46 ms if it changed meanwhile.
///
/// The documents do not promise that the two bytes of a result belong together, and a new
/// result may come between them. So the register is read until two readings are equal, at
/// most three times: the third is whole, since results lie at least 4 ms apart, if the
/// bus runs at 50 kHz or more.
#[must_use]
pub const fn proximity() -> ReadResult {
    ReadResult::new(Command::proximity_ready, read_proximity())
}

/// Reads the ambient light result if a new one is ready,
/// [`LUX_PER_COUNT`](crate::LUX_PER_COUNT); as [`proximity`] otherwise.
#[must_use]
pub const fn ambient() -> ReadResult {
    ReadResult::new(Command::ambient_ready, read_ambient())
}

impl ReadResult {
    const fn new(is_ready: fn(Command) -> bool, read: Transaction) -> Self {
        Self {
            command: command(),
            is_ready,
            read,
            reads: 0,
            last: 0,
        }
    }

    fn read_again<T>(&mut self) -> Step<T> {
        self.reads += 1;
        Step::Execute(self.read)
    }
}

impl Sequence for ReadResult {
    type Output = u16;

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<u16>, Error<E>> {
        if self.reads == 0 {
            return match self.command.next(answer)? {
                Step::Execute(transaction) => Ok(Step::Execute(transaction)),
                Step::Done(command) if !command.is_self_timed() => Err(Error::NotRunning),
                Step::Done(command) if !(self.is_ready)(command) => Err(Error::NotReady),
                Step::Done(_) => Ok(self.read_again()),
            };
        }
        let value = result(answer).ok_or(Error::WrongLength)?;
        let is_whole = match self.reads {
            1 => false,
            2 => value == self.last,
            _ => true,
        };
        self.last = value;
        Ok(if is_whole {
            Step::Done(value)
        } else {
            self.read_again()
        })
    }
}

/// A measurement on demand; see [`measure_once`] and [`measure_proximity_once`].
#[derive(Clone, Copy, Debug)]
pub struct MeasureOnce<T> {
    trigger: Single<()>,
    command: Single<Command>,
    is_ready: fn(Command) -> bool,
    polls: u16,
    read: Single<T>,
}

/// Measures ambient light and proximity once and reads the command register up to `polls`
/// times until both are ready. 10 bytes and 4 per poll, 390 or 98 us each.
///
/// Ends self-timed measuring. An ambient light result of 32 conversions takes some 100 ms.
#[must_use]
pub const fn measure_once(polls: u16) -> MeasureOnce<Measurement> {
    MeasureOnce {
        trigger: Single::write(write_command(Command::ON_DEMAND)),
        command: command(),
        is_ready: |command| command.ambient_ready() && command.proximity_ready(),
        polls,
        read: Single::new(read_measurement(), measurement),
    }
}

/// Measures proximity once, counts, and reads the command register up to `polls` times
/// until it is ready. 8 bytes and 4 per poll, 390 or 98 us each.
///
/// Ends self-timed measuring. The measurement takes less than 1 ms.
#[must_use]
pub const fn measure_proximity_once(polls: u16) -> MeasureOnce<u16> {
    MeasureOnce {
        trigger: Single::write(write_command(Command::ON_DEMAND_PROXIMITY)),
        command: command(),
        is_ready: Command::proximity_ready,
        polls,
        read: Single::new(read_proximity(), result),
    }
}

impl<T> Sequence for MeasureOnce<T> {
    type Output = T;

    fn next<E>(&mut self, answer: &[u8]) -> Result<Step<T>, Error<E>> {
        if self.read.is_sent {
            return self.read.next(answer);
        }
        if !self.trigger.is_sent {
            self.trigger.is_sent = true;
            return Ok(Step::Execute(self.trigger.transaction));
        }
        if self.command.is_sent {
            let command = decode_command(answer).ok_or(Error::WrongLength)?;
            if (self.is_ready)(command) {
                return self.read.next(answer);
            }
        }
        self.polls = self.polls.checked_sub(1).ok_or(Error::NotReady)?;
        self.command.is_sent = true;
        Ok(Step::Execute(self.command.transaction))
    }
}

fn decode_command(answer: &[u8]) -> Option<Command> {
    byte(answer).map(Command)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes on the bus of a sequence with these answers.
    fn clocks<S: Sequence>(mut sequence: S, answers: &[&[u8]]) -> u32 {
        let mut clocks = 0;
        let mut answers = answers.iter();
        let mut answer: &[u8] = &[];
        while let Ok(Step::Execute(transaction)) = sequence.next::<()>(answer) {
            clocks += transaction.clocks();
            answer = match transaction.read_length() {
                0 => &[],
                _ => answers.next().copied().unwrap_or_default(),
            };
        }
        clocks
    }

    #[test]
    fn documented_costs_are_those_of_the_transactions() {
        let configuration = Configuration::default();
        assert_eq!(clocks(start(&configuration), &[&[0x21]]), 144);
        let configuration = Configuration {
            ambient: None,
            ..configuration
        };
        assert_eq!(clocks(start(&configuration), &[&[0x21]]), 135);
        let rate = ProximityRate::Hz250;
        assert_eq!(clocks(set_proximity_rate(rate), &[&[0x80]]), 68);
        assert_eq!(clocks(proximity(), &[&[0xa3], &[1, 2], &[1, 2]]), 135);
        let torn: [&[u8]; 4] = [&[0xa3], &[1, 2], &[1, 3], &[1, 4]];
        assert_eq!(clocks(proximity(), &torn), 183);
        let ready: [&[u8]; 2] = [&[0xe0], &[0, 9, 1, 2]];
        assert_eq!(clocks(measure_once(1), &ready), 29 + 39 + 66);
        let ready: [&[u8]; 2] = [&[0xa0], &[1, 2]];
        assert_eq!(clocks(measure_proximity_once(1), &ready), 29 + 39 + 48);
    }

    #[test]
    fn an_answer_of_a_wrong_length_is_an_error_wherever_one_is_read() {
        fn outcome<S: Sequence<Output = T>, T>(
            mut sequence: S,
            answers: &[&[u8]],
        ) -> Result<Step<T>, Error<()>> {
            let mut outcome = sequence.next(&[]);
            for answer in answers {
                outcome = sequence.next(answer);
            }
            outcome
        }
        let wrong = Error::WrongLength;
        assert_eq!(outcome(check_identity(), &[&[0x21, 0]]), Err(wrong));
        assert_eq!(
            outcome(start(&Configuration::default()), &[&[]]),
            Err(wrong)
        );
        assert_eq!(
            outcome(set_proximity_rate(ProximityRate::Hz125), &[&[]]),
            Err(wrong)
        );
        assert_eq!(outcome(proximity(), &[&[]]), Err(wrong));
        assert_eq!(outcome(proximity(), &[&[0xa3], &[1]]), Err(wrong));
        assert_eq!(outcome(measure_once(9), &[&[], &[]]), Err(wrong));
        assert_eq!(outcome(measure_once(9), &[&[], &[0xe0], &[1]]), Err(wrong));
    }
}
