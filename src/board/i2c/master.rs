//! The I2C master: one transaction at a time over one unit.

use crate::board::i2c::{BusFault, BusTransaction, LONGEST_READ};
use heapless::Vec;

use super::counters::{MasterCounters, count};
use super::limits::{BACK_OFF_US, BYTE_US, LOOKS, STALL_US, STOP_US, USELESS_EVENTS};
use super::recovery::recover;
use super::registers::{I2cRegister, I2cRegisters, cr1, cr2, sr1, sr2};
use super::stage::{Direction, Stage, TransferProgress};
use super::timing::I2cTiming;

/// A master of one bus. Times are microseconds of a clock that does not go back.
///
/// # Why late interrupts do no harm
///
/// The unit has no queue. Served late while bytes move, it loses or doubles one, or
/// acknowledges one too many; ST's advice is the highest priority \[RM 27.3.3, method
/// 1\]. Here the data register is only touched while the unit waits with SCL held low:
/// after an acknowledged address (ADDR) or a byte finished (BTF) with the next one not
/// to be had or not to be put, never on a register merely empty or full (TXE, RXNE);
/// but a single byte sets no BTF and is fetched after its stop, when none follows.
/// A read of three bytes or more ends by \[RM method 2\]. Three places remain in which
/// the unit goes on while it gets a command, for 22 us at most, in the last for 3:
///
/// - one byte: the stop, after the address event is cleared;
/// - two bytes: the refusal of the second, after the address event is cleared;
/// - two or more: taking the last byte but one, after the stop is requested, else the
///   last one is shifted by a bit \[ES F1, wrong data read\].
///
/// These are a few register accesses each and go through [`I2cRegisters::without_interrupts`].
pub struct I2cMaster<R> {
    registers: R,
    timing: I2cTiming,
    stage: Stage,
    transaction: BusTransaction,
    /// Bytes written.
    written: u8,
    answer: Vec<u8, LONGEST_READ, u8>,
    outcome: Result<(), BusFault>,
    begun_us: u64,
    progress_us: u64,
    useless_events: u8,
    /// When a bus that could not be freed is tried again.
    retry_us: Option<u64>,
    /// The next wait of a bus that cannot be freed.
    wait_us: u64,
    counters: MasterCounters,
}

impl<R: I2cRegisters> I2cMaster<R> {
    /// A master whose bus has been freed, since a reset can come in mid-transfer.
    pub fn new(registers: R, timing: I2cTiming, now_us: u64) -> Self {
        let mut master = Self {
            registers,
            timing,
            stage: Stage::Idle,
            transaction: BusTransaction::new(0, &[], 0),
            written: 0,
            answer: Vec::new(),
            outcome: Ok(()),
            begun_us: now_us,
            progress_us: now_us,
            useless_events: 0,
            retry_us: None,
            wait_us: BACK_OFF_US.0,
            counters: MasterCounters::default(),
        };
        master.free_bus(now_us);
        master
    }

    /// Begins a transaction.
    ///
    /// [`TransferProgress::Done`] at once with [`BusFault::HeldLow`] while the bus is held low. A
    /// bus that is busy before its only master has begun is freed first, 150 us at most.
    pub fn begin(&mut self, transaction: &BusTransaction, now_us: u64) -> TransferProgress {
        if self.stage != Stage::Idle {
            return TransferProgress::Refused;
        }
        self.answer.clear();
        self.written = 0;
        if self.retry_us.is_some() || !(self.is_free() || self.recover(now_us)) {
            return self.end(Err(BusFault::HeldLow));
        }
        self.transaction.clone_from(transaction);
        self.begun_us = now_us;
        self.advance(
            Stage::Start(match (transaction.to_write(), transaction.to_read()) {
                ([], 1..) => Direction::Read,
                _ => Direction::Write,
            }),
            now_us,
        );
        // Old flags are cleared by writing zeros.
        self.registers.write(I2cRegister::Sr1, 0);
        self.enable_interrupts(cr2::EVENTS | cr2::ERRORS);
        self.control(cr1::START);
        TransferProgress::Running
    }

    /// Serves the event interrupt.
    pub fn on_event(&mut self, now_us: u64) -> TransferProgress {
        let events = self.registers.read(I2cRegister::Sr1);
        let has = |event| events & event != 0;
        match self.stage {
            Stage::Start(direction) if has(sr1::STARTED) => self.send_address(direction, now_us),
            Stage::Address(Direction::Write) if has(sr1::ADDRESSED) => {
                self.registers.read(I2cRegister::Sr2);
                self.write_on(now_us)
            }
            Stage::Address(Direction::Read) if has(sr1::ADDRESSED) => self.start_reading(now_us),
            Stage::Writing if has(sr1::FINISHED) => self.write_on(now_us),
            Stage::Reading if has(sr1::FINISHED) => self.read_on(now_us),
            Stage::Reading if has(sr1::RECEIVED) && self.transaction.to_read() == 1 => {
                self.take_byte();
                self.stop(Ok(()), now_us)
            }
            _ => self.ignore_event(),
        }
    }

    /// Serves the error interrupt.
    ///
    /// A bus error alone ends nothing: the silicon reports it in master mode where
    /// there is none, and the transfer goes on \[ES, spurious bus error\]. If there was
    /// one, the transfer fails by itself or by its time.
    pub fn on_error(&mut self, now_us: u64) -> TransferProgress {
        let errors = self.registers.read(I2cRegister::Sr1);
        // A flag is cleared by writing zero: those that were seen, not one that came since.
        self.registers
            .write(I2cRegister::Sr1, sr1::ERRORS & !errors);
        if errors & sr1::BUS_ERROR != 0 {
            count(&mut self.counters.bus_errors);
        }
        match self.stage {
            Stage::Idle => TransferProgress::Idle,
            Stage::Stop(_) => TransferProgress::Running,
            _ if errors & sr1::ARBITRATION_LOST != 0 => {
                count(&mut self.counters.arbitration);
                // The unit has released the lines by itself: there is nothing to stop, and
                // as a slave, which it is now, it must not acknowledge.
                self.control(0);
                self.end(Err(BusFault::ArbitrationLost))
            }
            stage if errors & sr1::REFUSED != 0 => {
                count(&mut self.counters.nacks);
                let fault = match stage {
                    Stage::Address(_) => BusFault::NoSuchPart,
                    _ => BusFault::RefusedByte,
                };
                self.control(cr1::STOP);
                self.stop(Err(fault), now_us)
            }
            _ => TransferProgress::Running,
        }
    }

    /// Serves deadlines; to be called every 500 us.
    ///
    /// Ends an overdue transaction and frees its bus, 150 us at most; retries a held bus
    /// again when its wait is over.
    pub fn poll(&mut self, now_us: u64) -> TransferProgress {
        let stage = self.stage;
        match stage {
            Stage::Idle => {
                if self.retry_us.is_some_and(|until_us| now_us >= until_us) {
                    self.recover(now_us);
                }
                TransferProgress::Idle
            }
            Stage::Stop(outcome) if self.has_stopped() => self.end(outcome),
            _ if self.is_overdue(now_us) => {
                count(&mut self.counters.overdue);
                let freed = self.recover(now_us);
                self.end(Err(if freed {
                    BusFault::Overdue
                } else {
                    BusFault::HeldLow
                }))
            }
            _ => TransferProgress::Running,
        }
    }

    /// How the last transaction ended, with the bytes it read.
    ///
    /// Meaningful after [`TransferProgress::Done`] and until the next [`I2cMaster::begin`].
    ///
    /// # Errors
    /// The fault; bytes read before it are discarded.
    pub fn result(&self) -> Result<&[u8], BusFault> {
        self.outcome.map(|()| self.answer.as_slice())
    }

    /// Whether the bus could not be freed and waits for another attempt.
    pub const fn is_held_low(&self) -> bool {
        self.retry_us.is_some()
    }

    /// Counts of faults since start.
    pub const fn counters(&self) -> &MasterCounters {
        &self.counters
    }

    /// After the start: the address, with the direction in its lowest bit.
    fn send_address(&mut self, direction: Direction, now_us: u64) -> TransferProgress {
        let reading = u16::from(direction == Direction::Read);
        let address = u16::from(self.transaction.address()) << 1 | reading;
        self.registers.write(I2cRegister::Dr, address);
        self.advance(Stage::Address(direction), now_us)
    }

    /// The unit holds the clock and has nothing to send: the next byte, a repeated
    /// start, or the end.
    fn write_on(&mut self, now_us: u64) -> TransferProgress {
        if let Some(byte) = self.transaction.to_write().get(usize::from(self.written)) {
            self.registers.write(I2cRegister::Dr, u16::from(*byte));
            // At most as many as are to be written.
            self.written += 1;
            return self.advance(Stage::Writing, now_us);
        }
        if self.transaction.to_read() > 0 {
            self.control(cr1::START);
            return self.advance(Stage::Start(Direction::Read), now_us);
        }
        self.control(cr1::STOP);
        self.stop(Ok(()), now_us)
    }

    /// The address is acknowledged and the unit holds the clock until the second
    /// status register is read. The refusal of the last byte is set up now.
    fn start_reading(&mut self, now_us: u64) -> TransferProgress {
        match self.transaction.to_read() {
            // One: it is refused, and the stop follows it [RM, method 2, N = 1].
            1 => {
                self.control(0);
                // A single byte sets no BTF: its arrival is the event.
                self.enable_interrupts(cr2::EVENTS | cr2::ERRORS | cr2::BUFFER);
                self.registers.without_interrupts(|registers| {
                    registers.read(I2cRegister::Sr2);
                    registers.write(I2cRegister::Cr1, cr1::ENABLE | cr1::STOP);
                });
            }
            // Two: the refusal is set while the first comes in [RM, method 2, N = 2]. Set
            // before the address event is cleared it would be for the first.
            2 => {
                self.control(cr1::ACK | cr1::POS);
                self.registers.without_interrupts(|registers| {
                    registers.read(I2cRegister::Sr2);
                    registers.write(I2cRegister::Cr1, cr1::ENABLE | cr1::POS);
                });
            }
            _ => {
                self.control(cr1::ACK);
                self.registers.read(I2cRegister::Sr2);
            }
        }
        self.advance(Stage::Reading, now_us)
    }

    /// The unit holds the clock with one byte in the data register and one behind it.
    fn read_on(&mut self, now_us: u64) -> TransferProgress {
        let left = self.transaction.to_read() - self.answer.len();
        if left > 2 {
            if left == 3 {
                // The next to come in is the last: it is refused.
                self.control(0);
            }
            self.take_byte();
            return self.advance(Stage::Reading, now_us);
        }
        let last_but_one = self.registers.without_interrupts(|registers| {
            registers.write(I2cRegister::Cr1, cr1::ENABLE | cr1::STOP);
            registers.read(I2cRegister::Dr)
        });
        self.keep(last_but_one);
        self.take_byte();
        self.stop(Ok(()), now_us)
    }

    fn take_byte(&mut self) {
        let byte = self.registers.read(I2cRegister::Dr);
        self.keep(byte);
    }

    fn keep(&mut self, byte: u16) {
        // The register has eight bits, and no more bytes come than a transaction reads.
        let _ = self.answer.push(byte as u8);
    }

    /// A stop has been requested: ends the transaction if the stop is made within a few
    /// microseconds; else the poll does.
    ///
    /// Only a stop that was made proves that the lines are free: while a part holds SDA
    /// low, zeros are read.
    fn stop(&mut self, outcome: Result<(), BusFault>, now_us: u64) -> TransferProgress {
        self.enable_interrupts(0);
        self.advance(Stage::Stop(outcome), now_us);
        if (0..LOOKS).any(|_| self.has_stopped()) {
            return self.end(outcome);
        }
        TransferProgress::Running
    }

    fn has_stopped(&mut self) -> bool {
        self.registers.read(I2cRegister::Cr1) & cr1::STOP == 0
            && self.registers.read(I2cRegister::Sr2) & sr2::BUSY == 0
    }

    /// Whether a start can be made, now or within a stop's time.
    fn is_free(&mut self) -> bool {
        (0..LOOKS).any(|_| self.has_stopped())
    }

    fn end(&mut self, outcome: Result<(), BusFault>) -> TransferProgress {
        self.enable_interrupts(0);
        if !matches!(outcome, Err(BusFault::Overdue | BusFault::HeldLow)) {
            // The bus has carried a transaction: it works.
            self.wait_us = BACK_OFF_US.0;
        }
        self.outcome = outcome;
        self.stage = Stage::Idle;
        TransferProgress::Done
    }

    fn advance(&mut self, stage: Stage, now_us: u64) -> TransferProgress {
        self.stage = stage;
        self.progress_us = now_us;
        self.useless_events = 0;
        TransferProgress::Running
    }

    /// An event that needs no action.
    fn ignore_event(&mut self) -> TransferProgress {
        self.useless_events = self.useless_events.saturating_add(1);
        if self.useless_events >= USELESS_EVENTS {
            self.enable_interrupts(0);
        }
        match self.stage {
            Stage::Idle => TransferProgress::Idle,
            _ => TransferProgress::Running,
        }
    }

    fn is_overdue(&self, now_us: u64) -> bool {
        let write = self.transaction.to_write().len();
        let read = self.transaction.to_read();
        // Two addresses and at most 25 bytes.
        let bytes = (write + read + 2) as u64;
        let stall_us = match self.stage {
            Stage::Stop(_) => STOP_US,
            _ => STALL_US,
        };
        now_us.saturating_sub(self.progress_us) >= stall_us
            || now_us.saturating_sub(self.begun_us) >= STALL_US + BYTE_US * bytes
    }

    /// Frees the bus and counts that; whether it is free.
    fn recover(&mut self, now_us: u64) -> bool {
        count(&mut self.counters.recoveries);
        self.free_bus(now_us)
    }

    /// Frees the bus; if that fails the bus stays unused until the next attempt. The wait
    /// doubles with each attempt.
    fn free_bus(&mut self, now_us: u64) -> bool {
        let free = recover(&mut self.registers, self.timing);
        self.retry_us = None;
        if !free {
            self.retry_us = Some(now_us.saturating_add(self.wait_us));
            self.wait_us = (2 * self.wait_us).min(BACK_OFF_US.1);
        }
        free
    }

    /// Writes the first control register: on, and these.
    ///
    /// Never while a start or stop is pending, which would ask for it again \[RM 27.6.1\].
    fn control(&mut self, bits: u16) {
        self.registers.write(I2cRegister::Cr1, cr1::ENABLE | bits);
    }

    /// Enables these interrupts only.
    fn enable_interrupts(&mut self, interrupts: u16) {
        let bits = self.timing.megahertz | interrupts;
        self.registers.write(I2cRegister::Cr2, bits);
    }
}
