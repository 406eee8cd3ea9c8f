//! The I2C unit of the F405 as a master, byte by byte, after its manual (RM0090, chapter
//! 27), with the limitations of its errata sheets.
//!
//! The registers' numbers are written out here and not taken from the firmware: a wrong
//! bit there must not be right here.

use std::cell::RefCell;
use std::rc::Rc;

use amiro_ipf::random::{Generator, uniform_below};
use sim_harness::bus::Device;

use amiro_ipf::board::i2c::{Line, Register, Registers};

const PE: u16 = 1 << 0;
const START: u16 = 1 << 8;
const STOP: u16 = 1 << 9;
const ACK: u16 = 1 << 10;
const POS: u16 = 1 << 11;
const SWRST: u16 = 1 << 15;

const ITERREN: u16 = 1 << 8;
const ITEVTEN: u16 = 1 << 9;
const ITBUFEN: u16 = 1 << 10;

const SB: u16 = 1 << 0;
const ADDR: u16 = 1 << 1;
const BTF: u16 = 1 << 2;
const RXNE: u16 = 1 << 6;
const TXE: u16 = 1 << 7;
const BERR: u16 = 1 << 8;
const ARLO: u16 = 1 << 9;
const AF: u16 = 1 << 10;
const ERRORS: u16 = BERR | ARLO | AF;

/// A register access over the peripheral bus with the instructions around it.
const ACCESS_NS: u64 = 60;

/// Half a clock by hand.
const HALF_CLOCK_NS: u64 = 2500;

/// Held until somebody lets go.
pub(crate) const FOR_EVER: u32 = u32::MAX;

/// What happens on the wires at a byte, addresses counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// At its end arbitration is lost.
    ArbitrationLost,
    /// In it the unit reports a bus error where there is none.
    SpuriousBusError,
    /// From its begin SCL is held low.
    ClockLow,
    /// From its begin SDA is held low until so many clocks have been made by hand.
    DataLow(u32),
}

/// A limitation of the silicon that has struck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stuck {
    Not,
    /// BUSY is set on an idle bus, until a software reset.
    Busy,
    /// The same, until both wires have changed and after that a software reset.
    Filter,
    /// No start is made after a misplaced stop, until a software reset.
    Start,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Idle,
    Starting(u64),
    Started,
    Addressing(u8, u64),
    Addressed {
        reading: bool,
    },
    Sending(u8, u64),
    /// Sender with nothing to send: SCL held low.
    Empty,
    /// Receiver before the acknowledgement and after it.
    Receiving(u64),
    Answering {
        acknowledged: bool,
        until: u64,
    },
    /// Receiver with two bytes: SCL held low.
    Full,
    /// After a refusal: waits for a stop or start.
    Refused,
    Stopping(u64),
}

pub(crate) struct Unit {
    pub(crate) now_ns: u64,
    cr1: u16,
    cr2: u16,
    ccr: u16,
    trise: u16,
    sr1: u16,
    /// Flags that the first status register has shown: half of clearing some of them.
    shown: u16,
    busy: bool,
    sender: bool,
    data: u8,
    next_out: Option<u8>,
    shift: Option<u8>,
    incoming: u8,
    /// ACK as it was when the byte before was answered, which is what POS goes by.
    ack_before: bool,
    /// Whether the byte behind a full data register was acknowledged.
    more_to_come: bool,
    phase: Phase,
    bytes: usize,
    by_hand: bool,
    pulls_clock: bool,
    pulls_data: bool,
    clock_toggled: bool,
    data_toggled: bool,
    pub(crate) clock_held: bool,
    /// Clocks until SDA is let go.
    pub(crate) data_held: u32,
    pub(crate) stuck: Stuck,
    fault: Option<(usize, Fault)>,
    /// When it happened.
    pub(crate) struck_ns: u64,
    device: Box<dyn Device>,
    undisturbed: bool,
    /// Whether `undisturbed` keeps interrupts away.
    pub(crate) masks: bool,
    /// Longest interruption between two accesses, nanoseconds.
    pub(crate) interruption_ns: u64,
    generator: Generator,
    /// What the manual forbids and was done.
    pub(crate) wrongs: Vec<&'static str>,
    /// Half clocks waited by hand.
    pub(crate) half_clocks: u32,
}

impl Unit {
    pub(crate) fn new(device: Box<dyn Device>, seed: u64) -> Self {
        Self {
            now_ns: 0,
            cr1: 0,
            cr2: 0,
            ccr: 0,
            trise: 2,
            sr1: 0,
            shown: 0,
            busy: false,
            sender: false,
            data: 0,
            next_out: None,
            shift: None,
            incoming: 0,
            ack_before: false,
            more_to_come: false,
            phase: Phase::Idle,
            bytes: 0,
            by_hand: false,
            pulls_clock: false,
            pulls_data: false,
            clock_toggled: false,
            data_toggled: false,
            clock_held: false,
            data_held: 0,
            stuck: Stuck::Not,
            fault: None,
            struck_ns: 0,
            device,
            undisturbed: false,
            masks: true,
            interruption_ns: 0,
            generator: Generator::seeded(seed),
            wrongs: Vec::new(),
            half_clocks: 0,
        }
    }

    /// Lets something happen at a byte from here on; addresses count.
    pub(crate) fn strike(&mut self, byte: usize, fault: Fault) {
        self.fault = Some((self.bytes + byte, fault));
    }

    /// Whether nobody uses the bus and the unit can make a start.
    pub(crate) fn is_idle(&self) -> bool {
        self.phase == Phase::Idle && !self.shows_busy() && self.stuck == Stuck::Not
    }

    pub(crate) fn event_line(&self) -> bool {
        let buffer = if self.cr2 & ITBUFEN != 0 {
            RXNE | TXE
        } else {
            0
        };
        self.cr2 & ITEVTEN != 0 && self.sr1 & (SB | ADDR | BTF | buffer) != 0
    }

    pub(crate) fn error_line(&self) -> bool {
        self.cr2 & ITERREN != 0 && self.sr1 & ERRORS != 0
    }

    /// When the unit does something next by itself.
    pub(crate) fn next_ns(&self) -> Option<u64> {
        if self.clock_held {
            return None;
        }
        match self.phase {
            Phase::Starting(until)
            | Phase::Addressing(_, until)
            | Phase::Sending(_, until)
            | Phase::Receiving(until)
            | Phase::Answering { until, .. } => Some(until),
            Phase::Stopping(until) if !self.data_low() => Some(until),
            _ => None,
        }
    }

    /// Lets time pass.
    pub(crate) fn pass(&mut self, ns: u64) {
        let end = self.now_ns + ns;
        while let Some(next) = self.next_ns().filter(|next| *next <= end) {
            self.now_ns = self.now_ns.max(next);
            self.move_on();
        }
        self.now_ns = end;
        self.device.pass(end);
        self.try_to_start();
    }

    /// Three CCR cycles of the bus clock.
    fn bit_ns(&self) -> u64 {
        u64::from(self.ccr & 0xfff) * 3 * 1000 / u64::from(self.cr2 & 0x3f).max(1)
    }

    fn in_bits(&self, bits: u64) -> u64 {
        self.now_ns + bits * self.bit_ns()
    }

    fn data_low(&self) -> bool {
        self.data_held > 0
    }

    fn shows_busy(&self) -> bool {
        self.busy
            || matches!(self.stuck, Stuck::Busy | Stuck::Filter)
            || self.data_low()
            || self.clock_held
    }

    /// The bits of one phase are over.
    fn move_on(&mut self) {
        match self.phase {
            Phase::Starting(_) => {
                self.cr1 &= !START;
                self.sr1 &= !(BTF | TXE);
                self.raise(SB);
                self.busy = true;
                self.phase = Phase::Started;
            }
            Phase::Addressing(byte, _) => {
                if self.loses_arbitration(byte) {
                    return;
                }
                let reading = byte & 1 == 1;
                if self.device.start(byte >> 1, reading, self.now_ns) || self.data_low() {
                    self.raise(ADDR);
                    self.phase = Phase::Addressed { reading };
                } else {
                    self.refuse();
                }
            }
            Phase::Sending(byte, _) => {
                if self.loses_arbitration(byte) {
                    return;
                }
                if !self.device.write(byte, self.now_ns) && !self.data_low() {
                    self.refuse();
                } else if let Some(next) = self.next_out.take() {
                    self.raise(TXE);
                    self.begin_byte();
                    self.phase = Phase::Sending(next, self.in_bits(9));
                } else {
                    self.raise(TXE | BTF);
                    self.phase = Phase::Empty;
                    self.stop_if_asked();
                }
            }
            Phase::Receiving(_) => {
                let control = self.cr1 & ACK != 0;
                let acknowledged = if self.cr1 & POS != 0 {
                    self.ack_before
                } else {
                    control
                };
                self.ack_before = control;
                self.phase = Phase::Answering {
                    acknowledged,
                    until: self.in_bits(1),
                };
            }
            Phase::Answering { acknowledged, .. } => self.take_in(acknowledged),
            Phase::Stopping(_) => {
                self.cr1 &= !STOP;
                self.busy = false;
                if self.sender {
                    self.sr1 &= !(BTF | TXE);
                }
                // Too late for the byte before the last: the last is shifted by a bit.
                self.shift = self.shift.map(|byte| byte << 1);
                self.device.stop(self.now_ns);
                self.phase = Phase::Idle;
            }
            _ => {}
        }
    }

    /// A byte is complete and answered.
    fn take_in(&mut self, acknowledged: bool) {
        if matches!(self.fault, Some((byte, Fault::ArbitrationLost)) if byte + 1 == self.bytes) {
            self.lose();
            return;
        }
        let byte = if self.data_low() { 0 } else { self.incoming };
        let stops = self.cr1 & STOP != 0;
        if stops && acknowledged {
            self.wrongs.push("stop after an acknowledged byte");
        }
        if self.sr1 & RXNE == 0 {
            self.data = byte;
            self.raise(RXNE);
            if stops {
                self.phase = Phase::Stopping(self.in_bits(1));
            } else {
                self.receive(acknowledged);
            }
        } else {
            self.shift = Some(byte);
            self.raise(BTF);
            self.phase = Phase::Full;
            self.more_to_come = acknowledged;
            self.stop_if_asked();
        }
    }

    /// The next byte begins to come in: the part's if it was asked for, else nobody's.
    fn receive(&mut self, asked_for: bool) {
        self.incoming = if asked_for {
            self.device.read(self.now_ns)
        } else {
            self.wrongs.push("a byte clocked in after a refused one");
            0xff
        };
        self.begin_byte();
        self.phase = Phase::Receiving(self.in_bits(8));
    }

    fn refuse(&mut self) {
        self.raise(AF);
        self.phase = Phase::Refused;
        self.stop_if_asked();
    }

    fn stop_if_asked(&mut self) {
        if self.cr1 & STOP != 0 {
            self.phase = Phase::Stopping(self.in_bits(1) + self.bit_ns() / 2);
        }
    }

    /// A one that is sent while SDA is low belongs to somebody else.
    fn loses_arbitration(&mut self, byte: u8) -> bool {
        let struck =
            matches!(self.fault, Some((at, Fault::ArbitrationLost)) if at + 1 == self.bytes);
        let lost = struck || (self.data_low() && byte != 0);
        if lost {
            self.lose();
        }
        lost
    }

    fn lose(&mut self) {
        self.fault = None;
        self.raise(ARLO);
        self.sr1 &= !(TXE | BTF);
        self.phase = Phase::Idle;
    }

    fn raise(&mut self, flags: u16) {
        self.sr1 |= flags;
        self.shown &= !flags;
    }

    fn begin_byte(&mut self) {
        match self.fault {
            Some((at, fault)) if at == self.bytes => {
                self.struck_ns = self.now_ns;
                match fault {
                    // At the byte's end.
                    Fault::ArbitrationLost => {}
                    Fault::SpuriousBusError => self.raise(BERR),
                    Fault::ClockLow => self.clock_held = true,
                    Fault::DataLow(clocks) => self.data_held = clocks,
                }
            }
            _ => {}
        }
        self.bytes += 1;
    }

    fn try_to_start(&mut self) {
        let free = !self.shows_busy() && self.stuck == Stuck::Not;
        let set_up = (self.ccr, self.trise, self.cr2 & 0x3f) == (0x8000 | 35, 13, 42);
        let on = self.cr1 & (PE | SWRST | START) == PE | START;
        if self.phase == Phase::Idle && on && free && set_up && !self.by_hand {
            self.phase = Phase::Starting(self.in_bits(1));
        }
    }

    fn address_cleared(&mut self, reading: bool) {
        self.sr1 &= !ADDR;
        self.sender = !reading;
        if reading {
            self.ack_before = self.cr1 & ACK != 0;
            self.receive(true);
        } else {
            self.raise(TXE);
            self.phase = Phase::Empty;
        }
    }

    fn read_register(&mut self, register: Register) -> u16 {
        match register {
            Register::Cr1 => self.cr1,
            Register::Cr2 => self.cr2,
            Register::Ccr => self.ccr,
            Register::Trise => self.trise,
            Register::Sr1 => {
                self.shown |= self.sr1;
                self.sr1
            }
            Register::Sr2 => {
                let busy = self.shows_busy();
                if let Phase::Addressed { reading } = self.phase
                    && self.shown & ADDR != 0
                {
                    self.address_cleared(reading);
                }
                u16::from(self.phase != Phase::Idle) | u16::from(busy) << 1
            }
            Register::Dr => {
                if self.shown & BTF != 0 {
                    self.sr1 &= !BTF;
                }
                let data = self.data;
                match self.shift.take() {
                    Some(byte) => self.data = byte,
                    None => self.sr1 &= !RXNE,
                }
                if self.phase == Phase::Full {
                    self.receive(self.more_to_come);
                }
                u16::from(data)
            }
        }
    }

    fn write_register(&mut self, register: Register, value: u16) {
        match register {
            Register::Cr1 => self.control(value),
            Register::Cr2 => self.cr2 = value,
            Register::Ccr => self.ccr = value,
            Register::Trise => self.trise = value,
            Register::Sr1 => self.sr1 &= value | !ERRORS,
            Register::Sr2 => self.wrongs.push("SR2 written"),
            Register::Dr => {
                // The register has eight bits.
                let byte = value as u8;
                match self.phase {
                    Phase::Started if self.shown & SB != 0 => {
                        self.sr1 &= !SB;
                        self.begin_byte();
                        self.phase = Phase::Addressing(byte, self.in_bits(9));
                    }
                    Phase::Empty => {
                        if self.shown & BTF != 0 {
                            self.sr1 &= !BTF;
                        }
                        self.begin_byte();
                        self.phase = Phase::Sending(byte, self.in_bits(9));
                    }
                    Phase::Sending(..) if self.next_out.is_none() => {
                        self.next_out = Some(byte);
                        self.sr1 &= !TXE;
                    }
                    _ => self.wrongs.push("DR written where no byte is wanted"),
                }
            }
        }
    }

    fn control(&mut self, value: u16) {
        let pending = self.cr1 & (START | STOP) != 0;
        if value & SWRST != 0 || value & PE == 0 {
            self.switch_off(value);
            return;
        }
        if pending && self.phase != Phase::Idle {
            self.wrongs
                .push("CR1 written while a start or stop is pending");
        }
        self.cr1 = value;
        if value & STOP != 0 {
            match self.phase {
                Phase::Empty | Phase::Full | Phase::Refused => self.stop_if_asked(),
                // At the end of the byte.
                Phase::Sending(..) | Phase::Receiving(_) | Phase::Answering { .. } => {}
                _ => self.wrongs.push("stop asked for outside a transfer"),
            }
        }
        if value & START != 0 {
            match self.phase {
                Phase::Idle => self.try_to_start(),
                Phase::Empty => self.phase = Phase::Starting(self.in_bits(1)),
                _ => self
                    .wrongs
                    .push("start asked for outside an idle bus or a write's end"),
            }
        }
    }

    fn switch_off(&mut self, value: u16) {
        self.cr1 = value & !(START | STOP);
        self.phase = Phase::Idle;
        self.sr1 = 0;
        self.shift = None;
        self.next_out = None;
        if value & SWRST == 0 {
            return;
        }
        (self.cr2, self.ccr, self.trise) = (0, 0, 2);
        self.busy = false;
        let toggled = self.clock_toggled && self.data_toggled;
        if self.stuck != Stuck::Filter || toggled {
            self.stuck = Stuck::Not;
        }
    }

    fn set_pin(&mut self, line: Line, pulls: bool) {
        assert!(self.by_hand, "a pin was moved that belongs to the unit");
        let clock_high = !self.pulls_clock && !self.clock_held;
        match line {
            Line::Clock => {
                if pulls && clock_high {
                    self.clock_toggled = true;
                    if self.data_held != FOR_EVER {
                        self.data_held = self.data_held.saturating_sub(1);
                    }
                }
                self.pulls_clock = pulls;
            }
            Line::Data => {
                self.data_toggled |= pulls;
                if self.pulls_data && !pulls && clock_high && !self.data_low() {
                    self.device.stop(self.now_ns);
                    self.busy = false;
                }
                self.pulls_data = pulls;
            }
        }
    }

    /// An access, and whatever comes between it and the one before.
    fn access(&mut self) {
        if self.interruption_ns > 0
            && !(self.undisturbed && self.masks)
            && uniform_below(&mut self.generator, 4) == 0
        {
            // Some tens of microseconds.
            let most = self.interruption_ns as u32;
            let pause = uniform_below(&mut self.generator, most);
            self.pass(u64::from(pause));
        }
        self.pass(ACCESS_NS);
    }
}

/// The unit as the master gets it, while the bench keeps its own hold.
pub(crate) struct Wired(pub(crate) Rc<RefCell<Unit>>);

impl Registers for Wired {
    fn read(&mut self, register: Register) -> u16 {
        let mut unit = self.0.borrow_mut();
        unit.access();
        unit.read_register(register)
    }

    fn write(&mut self, register: Register, value: u16) {
        let mut unit = self.0.borrow_mut();
        unit.access();
        unit.write_register(register, value);
    }

    fn take_pins(&mut self) {
        let mut unit = self.0.borrow_mut();
        unit.by_hand = true;
        (unit.pulls_clock, unit.pulls_data) = (false, false);
        (unit.clock_toggled, unit.data_toggled) = (false, false);
    }

    fn return_pins(&mut self) {
        self.0.borrow_mut().by_hand = false;
    }

    fn pull(&mut self, line: Line) {
        self.0.borrow_mut().set_pin(line, true);
    }

    fn release(&mut self, line: Line) {
        self.0.borrow_mut().set_pin(line, false);
    }

    fn is_high(&mut self, line: Line) -> bool {
        let unit = self.0.borrow();
        match line {
            Line::Clock => !unit.pulls_clock && !unit.clock_held,
            Line::Data => !unit.pulls_data && !unit.data_low(),
        }
    }

    fn wait_half_clock(&mut self) {
        let mut unit = self.0.borrow_mut();
        unit.half_clocks += 1;
        unit.pass(HALF_CLOCK_NS);
    }

    fn undisturbed<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        self.0.borrow_mut().undisturbed = true;
        let result = work(self);
        self.0.borrow_mut().undisturbed = false;
        result
    }
}
