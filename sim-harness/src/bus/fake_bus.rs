//! A bus of two wires with parts and injected faults.

use std::fmt;

use super::{Device, InjectedBusFault, Script, Transcript, Word};

/// Nine clocks at 400 kHz.
const BYTE_NS: u64 = 22_500;
/// An address that no part has: the parts get it in place of an address that is to find no
/// acknowledgement.
const UNADDRESSED: u8 = 0x7f;

/// Why a start, byte or stop did not happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFault {
    /// SDA was low where the master left it high; the master has left the bus.
    ArbitrationLost,
    /// SDA is held low, so that there can be no start or stop.
    SdaLow,
    /// SCL is held low: nothing can happen until it is released.
    SclLow,
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArbitrationLost => "arbitration is lost",
            Self::SdaLow => "SDA is low",
            Self::SclLow => "SCL is low",
        })
    }
}

/// State of the master's transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TransferPhase {
    Idle,
    /// The next byte is an address.
    Address,
    Write,
    Read,
}

/// A bus with parts on it, a script of faults, and a clock.
///
/// The clock runs by bytes ([`Self::set_byte_time`]) and by hand ([`Self::advance`]); it
/// starts at 0. Drivers use it through [`embedded_hal::i2c::I2c`], a model of an I2C unit
/// through [`Self::start`], [`Self::send`], [`Self::receive`], [`Self::stop`] and
/// [`Self::pulse`]. A byte without a start is not acknowledged.
#[derive(Debug)]
pub struct FakeBus<P> {
    parts: P,
    /// The faults to inject.
    pub script: Script,
    transcript: Transcript,
    now_ns: u64,
    byte_ns: u64,
    /// Bytes so far: the number of the next one.
    bytes: u64,
    /// The next byte's faults have struck.
    struck: bool,
    refused: bool,
    lost: bool,
    phase: TransferPhase,
    /// Clocks until SDA is released.
    sda_clocks: u32,
    scl_until_ns: u64,
}

impl<P: Device> FakeBus<P> {
    /// A quiet bus of 400 kHz whose power has just come up.
    #[must_use]
    pub fn new(parts: P) -> Self {
        Self {
            parts,
            script: Script::default(),
            transcript: Transcript::default(),
            now_ns: 0,
            byte_ns: BYTE_NS,
            bytes: 0,
            struck: false,
            refused: false,
            lost: false,
            phase: TransferPhase::Idle,
            sda_clocks: 0,
            scl_until_ns: 0,
        }
    }

    /// Sets how long a byte with its acknowledgement takes: 90 000 ns at 100 kHz.
    pub fn set_byte_time(&mut self, byte_ns: u64) {
        self.byte_ns = byte_ns;
    }

    /// Nanoseconds since the power came up.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Number of bytes so far, which is the number of the next one for a [`Script`].
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The last words on the bus.
    #[must_use]
    pub const fn transcript(&self) -> &Transcript {
        &self.transcript
    }

    /// The parts.
    #[must_use]
    pub const fn parts(&self) -> &P {
        &self.parts
    }

    /// The parts at the current time.
    pub fn parts_mut(&mut self) -> &mut P {
        self.parts.pass(self.now_ns);
        &mut self.parts
    }

    /// Lets time pass.
    pub fn advance(&mut self, by_ns: u64) {
        self.now_ns = self.now_ns.saturating_add(by_ns);
        self.parts.pass(self.now_ns);
    }

    /// Lets time pass until the given time; nothing if that is over.
    pub fn advance_to(&mut self, now_ns: u64) {
        self.advance(now_ns.saturating_sub(self.now_ns));
    }

    /// Whether a part holds SDA low.
    #[must_use]
    pub const fn sda_is_low(&self) -> bool {
        self.sda_clocks > 0
    }

    /// Whether a part holds SCL low.
    #[must_use]
    pub const fn scl_is_low(&self) -> bool {
        self.now_ns < self.scl_until_ns
    }

    /// When SCL is released, if it is held for a limited time.
    #[must_use]
    pub const fn scl_until_ns(&self) -> u64 {
        self.scl_until_ns
    }

    /// Whether both lines are high and no transfer is under way.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.phase == TransferPhase::Idle && !self.sda_is_low() && !self.scl_is_low()
    }

    /// A start, or a repeated one.
    ///
    /// # Errors
    /// [`LineFault::SclLow`] or [`LineFault::SdaLow`] while a line is held.
    pub fn start(&mut self) -> Result<(), LineFault> {
        self.lines_are_high()?;
        self.phase = TransferPhase::Address;
        Ok(())
    }

    /// A byte from the master, after a start an address and the direction in bit 0;
    /// whether it was acknowledged.
    ///
    /// # Errors
    /// [`LineFault::SclLow`] if nothing has happened yet; the call may be repeated later.
    /// [`LineFault::ArbitrationLost`] if SDA was low where the byte has a 1.
    pub fn send(&mut self, byte: u8) -> Result<bool, LineFault> {
        let begun_ns = self.begin_byte()?;
        // The master detects a low line at the byte's first 1.
        let zeros = byte.leading_zeros();
        if self.sda_clocks > zeros && byte != 0 {
            self.sda_clocks -= zeros + 1;
            return Err(self.leave());
        }
        let held_to_the_end = self.sda_clocks > 8;
        self.sda_clocks = self.sda_clocks.saturating_sub(9);
        let refused = core::mem::take(&mut self.refused);
        if refused {
            self.script.count_hit();
        }
        let (address, read) = (byte >> 1, byte & 1 != 0);
        let taken = match self.phase {
            TransferPhase::Address => {
                let sought = if refused { UNADDRESSED } else { address };
                self.parts.start(sought, read, begun_ns)
            }
            TransferPhase::Write if !refused => self.parts.write(byte, begun_ns),
            TransferPhase::Write | TransferPhase::Read | TransferPhase::Idle => false,
        };
        let acknowledged = taken || held_to_the_end;
        if self.phase == TransferPhase::Address {
            self.phase = if read {
                TransferPhase::Read
            } else {
                TransferPhase::Write
            };
            self.note(Word::Address {
                address,
                read,
                acknowledged,
            });
        } else {
            self.note(Word::Written { byte, acknowledged });
        }
        Ok(acknowledged)
    }

    /// A byte for the master, which acknowledges it to read another one.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn receive(&mut self, acknowledge: bool) -> Result<u8, LineFault> {
        let begun_ns = self.begin_byte()?;
        // Here the master acknowledges; a part cannot refuse.
        self.refused = false;
        let byte = match self.phase {
            TransferPhase::Read => self.parts.read(begun_ns),
            TransferPhase::Idle | TransferPhase::Address | TransferPhase::Write => 0xff,
        };
        let byte = byte & 0xff_u8.checked_shr(self.sda_clocks).unwrap_or(0);
        self.sda_clocks = self.sda_clocks.saturating_sub(9);
        self.note(Word::Read {
            byte,
            acknowledged: acknowledge,
        });
        Ok(byte)
    }

    /// A stop.
    ///
    /// # Errors
    /// As [`Self::start`]; the transfer is then not over.
    pub fn stop(&mut self) -> Result<(), LineFault> {
        self.lines_are_high()?;
        self.parts.stop(self.now_ns);
        self.phase = TransferPhase::Idle;
        self.note(Word::Stop);
        Ok(())
    }

    /// One clock with SDA left high; nothing while SCL is held low.
    pub fn pulse(&mut self) {
        if !self.scl_is_low() {
            self.sda_clocks = self.sda_clocks.saturating_sub(1);
            self.advance(self.byte_ns / 9);
        }
    }

    /// The master leaves the bus in the middle of a transfer.
    pub fn abandon(&mut self) {
        self.phase = TransferPhase::Idle;
    }

    fn lines_are_high(&mut self) -> Result<(), LineFault> {
        let fault = match (self.scl_is_low(), self.sda_is_low()) {
            (true, _) => LineFault::SclLow,
            (false, true) => LineFault::SdaLow,
            (false, false) => return Ok(()),
        };
        self.note(Word::Failed(fault));
        Err(fault)
    }

    /// Injects the next byte's faults and lets its time pass; returns when it began.
    fn begin_byte(&mut self) -> Result<u64, LineFault> {
        self.parts.pass(self.now_ns);
        if !self.struck {
            self.struck = true;
            for fault in self.script.strikes(self.bytes, self.now_ns) {
                self.inject(fault);
            }
        }
        if self.scl_is_low() {
            self.note(Word::Failed(LineFault::SclLow));
            return Err(LineFault::SclLow);
        }
        let begun_ns = self.now_ns;
        self.struck = false;
        self.bytes += 1;
        self.now_ns += self.byte_ns;
        if core::mem::take(&mut self.lost) {
            self.script.count_hit();
            return Err(self.leave());
        }
        Ok(begun_ns)
    }

    fn inject(&mut self, fault: InjectedBusFault) {
        let struck = match fault {
            // Counted where they have an effect.
            InjectedBusFault::NoAcknowledge => {
                self.refused = true;
                false
            }
            InjectedBusFault::ArbitrationLost => {
                self.lost = true;
                false
            }
            InjectedBusFault::SdaLow { clocks } => {
                self.sda_clocks = self.sda_clocks.max(clocks);
                clocks > 0
            }
            InjectedBusFault::SclLow { for_ns } => {
                let until_ns = self.now_ns.saturating_add(for_ns);
                self.scl_until_ns = self.scl_until_ns.max(until_ns);
                for_ns > 0
            }
            InjectedBusFault::Mux(_) | InjectedBusFault::Sensor { .. } => {
                self.parts.inject(fault, self.now_ns)
            }
        };
        if struck {
            self.script.count_hit();
        }
    }

    fn leave(&mut self) -> LineFault {
        self.refused = false;
        self.phase = TransferPhase::Idle;
        self.note(Word::Failed(LineFault::ArbitrationLost));
        LineFault::ArbitrationLost
    }

    fn note(&mut self, word: Word) {
        let before = match word {
            Word::Address { .. } | Word::Written { .. } | Word::Read { .. } => self.bytes - 1,
            Word::Stop | Word::Failed(_) => self.bytes,
        };
        self.transcript.note(before, word);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::{At24c01Model, Vcnl4020Fault, Vcnl4020Model};

    /// A memory of 0xa5, its word address at 0.
    fn memory() -> FakeBus<At24c01Model> {
        let mut bus = FakeBus::new(At24c01Model::new(0x50));
        bus.parts_mut().bytes_mut().fill(0xa5);
        bus
    }

    fn address(bus: &mut FakeBus<At24c01Model>, byte: u8) -> Result<bool, LineFault> {
        bus.start()?;
        bus.send(byte)
    }

    #[test]
    fn every_byte_takes_its_time_and_nothing_else_does() {
        let mut bus = memory();
        assert_eq!(address(&mut bus, 0xa1), Ok(true));
        assert_eq!(bus.receive(true), Ok(0xa5));
        assert_eq!(bus.receive(false), Ok(0xa5));
        assert_eq!(bus.stop(), Ok(()));
        assert_eq!((bus.bytes(), bus.now_ns()), (3, 67_500));
        bus.set_byte_time(90_000);
        assert_eq!(address(&mut bus, 0xa2), Ok(false));
        assert_eq!(bus.now_ns(), 157_500);
        bus.advance_to(1);
        assert_eq!(bus.now_ns(), 157_500);
        assert_eq!(
            bus.transcript().to_string(),
            "from byte 0: [50r+ <a5+ <a5- ] [51w-"
        );
    }

    #[test]
    fn a_byte_without_a_start_is_not_acknowledged() {
        let mut bus = memory();
        assert_eq!(bus.send(0xa0), Ok(false));
        assert_eq!(bus.receive(true), Ok(0xff));
        assert_eq!(address(&mut bus, 0xa1), Ok(true));
        assert_eq!(bus.send(7), Ok(false));
    }

    #[test]
    fn a_fault_strikes_the_byte_that_it_is_for() {
        for at in 0..4 {
            let mut bus = memory();
            bus.script.at_byte(at, InjectedBusFault::NoAcknowledge);
            let bytes = [0xa0, 0x00, 0x11, 0x22];
            bus.start().unwrap();
            let taken = bytes.map(|byte| bus.send(byte).unwrap());
            let expected = core::array::from_fn(|byte| match at {
                0 => false,
                _ => byte as u64 != at,
            });
            assert_eq!(taken, expected, "at {at}: {}", bus.transcript());
            assert_eq!(bus.script.hits(), 1);
        }
    }

    #[test]
    fn a_byte_that_is_read_cannot_be_refused() {
        let mut bus = memory();
        bus.script.at_byte(1, InjectedBusFault::NoAcknowledge);
        assert_eq!(address(&mut bus, 0xa1), Ok(true));
        assert_eq!(bus.receive(false), Ok(0xa5));
        bus.stop().unwrap();
        assert_eq!(address(&mut bus, 0xa1), Ok(true), "nor is the next one");
        assert_eq!(bus.script.hits(), 0);
    }

    #[test]
    fn who_loses_arbitration_has_left_and_may_come_again() {
        let mut bus = memory();
        bus.script.at_byte(1, InjectedBusFault::ArbitrationLost);
        assert_eq!(address(&mut bus, 0xa0), Ok(true));
        assert!(!bus.is_idle());
        assert_eq!(bus.send(0x10), Err(LineFault::ArbitrationLost));
        assert!(bus.is_idle());
        assert_eq!(bus.send(0x10), Ok(false), "it has left");
        assert_eq!(address(&mut bus, 0xa0), Ok(true));
        assert_eq!(bus.script.hits(), 1);
    }

    #[test]
    fn a_held_data_line_spoils_what_it_lasts_for() {
        // A byte that is read loses its leading ones.
        for (clocks, byte) in [(0, 0xa5), (1, 0x25), (3, 0x05), (8, 0x00), (9, 0x00)] {
            let mut bus = memory();
            bus.script.at_byte(1, InjectedBusFault::SdaLow { clocks });
            assert_eq!(address(&mut bus, 0xa1), Ok(true));
            assert_eq!(bus.receive(false), Ok(byte), "{clocks} clocks");
            assert_eq!(bus.stop(), Ok(()));
        }
        // 0x10 has its first 1 at the fourth clock.
        let written = |clocks| {
            let mut bus = memory();
            bus.script.at_byte(1, InjectedBusFault::SdaLow { clocks });
            assert_eq!(address(&mut bus, 0xa0), Ok(true));
            (bus.send(0x10), bus.sda_is_low())
        };
        assert_eq!(written(3), (Ok(true), false));
        assert_eq!(written(4), (Err(LineFault::ArbitrationLost), false));
        assert_eq!(written(5), (Err(LineFault::ArbitrationLost), true));
    }

    #[test]
    fn a_held_data_line_prevents_start_and_stop_until_its_clocks_are_counted() {
        let mut bus = memory();
        bus.script
            .at_byte(1, InjectedBusFault::SdaLow { clocks: 12 });
        assert_eq!(address(&mut bus, 0xa1), Ok(true));
        assert_eq!(bus.receive(false), Ok(0));
        for _ in 0..3 {
            assert_eq!(bus.stop(), Err(LineFault::SdaLow));
            assert_eq!(bus.start(), Err(LineFault::SdaLow));
            assert!(!bus.is_idle());
            bus.pulse();
        }
        assert_eq!(bus.stop(), Ok(()));
        assert!(bus.is_idle());
        assert_eq!(bus.now_ns(), 2 * 22_500 + 3 * 2_500);
    }

    #[test]
    fn a_held_clock_line_delays_a_byte_and_loses_none() {
        let mut bus = memory();
        bus.script
            .at_byte(1, InjectedBusFault::SclLow { for_ns: 50_000 });
        assert_eq!(address(&mut bus, 0xa1), Ok(true));
        assert_eq!(bus.receive(false), Err(LineFault::SclLow));
        assert_eq!(bus.stop(), Err(LineFault::SclLow));
        bus.pulse();
        assert_eq!((bus.bytes(), bus.now_ns()), (1, 22_500));
        bus.advance(50_000 - 1);
        assert_eq!(bus.receive(false), Err(LineFault::SclLow));
        bus.advance(1);
        assert_eq!(bus.receive(false), Ok(0xa5));
        assert_eq!(bus.stop(), Ok(()));
        assert_eq!(bus.script.hits(), 1);
    }

    #[test]
    fn a_clock_line_held_for_ever_is_never_let_go() {
        let mut bus = memory();
        bus.script
            .from_time(0, InjectedBusFault::SclLow { for_ns: u64::MAX });
        assert_eq!(address(&mut bus, 0xa1), Err(LineFault::SclLow));
        bus.advance(u64::MAX / 2);
        assert_eq!(bus.send(0xa1), Err(LineFault::SclLow));
        assert_eq!(bus.bytes(), 0);
    }

    #[test]
    fn a_measurement_can_be_put_between_the_halves_of_a_result() {
        for (at, expected) in [(4, [2, 0]), (5, [1, 0]), (6, [1, 0xff])] {
            let mut bus = FakeBus::new(Vcnl4020Model::default());
            let fault = InjectedBusFault::Sensor {
                channel: 0,
                fault: Vcnl4020Fault::Measures,
            };
            bus.parts_mut().queue_signals([0x01ff, 0x0200]);
            bus.start().unwrap();
            for byte in [0x26, 0x80, 0x03] {
                assert_eq!(bus.send(byte), Ok(true));
            }
            bus.stop().unwrap();
            bus.advance(1_000_000);
            let first = bus.bytes();
            bus.script.at_byte(first + at - 1, fault);
            bus.start().unwrap();
            bus.send(0x26).unwrap();
            bus.send(0x87).unwrap();
            bus.start().unwrap();
            bus.send(0x27).unwrap();
            let halves = [bus.receive(true), bus.receive(false)].map(Result::unwrap);
            bus.stop().unwrap();
            assert_eq!(halves, expected, "at {at}: {}", bus.transcript());
        }
    }
}
