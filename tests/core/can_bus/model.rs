//! A model of the bxCAN unit and of the wire it hangs on; a bit takes a microsecond.
//!
//! After the reference manual RM0090, section 32. It is stricter than the unit: what the
//! manual forbids panics here instead of doing something else.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use amiro_ipf::board::can::{CanRegister, CanRegisters};

/// What the wire does to frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wire {
    /// Somebody acknowledges.
    Healthy,
    /// Nobody else is there.
    Alone,
    /// Every frame is destroyed, and the wire is recessive in between.
    Destroying,
    /// No bit is recessive.
    Dominant,
}

/// A frame as the wire carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WireFrame {
    /// 11 or 29 bits.
    pub(crate) identifier: u32,
    pub(crate) is_extended: bool,
    pub(crate) is_remote: bool,
    pub(crate) length_code: u8,
    pub(crate) bytes: [u8; 8],
}

impl WireFrame {
    pub(crate) fn data(identifier: u32, bytes: [u8; 8]) -> Self {
        Self {
            identifier,
            is_extended: false,
            is_remote: false,
            length_code: 8,
            bytes,
        }
    }

    /// The four words of a mailbox or of the FIFO, without the request bit.
    fn words(&self) -> [u32; 4] {
        let [a, b, c, d, e, f, g, h] = self.bytes;
        let identifier = if self.is_extended {
            self.identifier << 3 | 1 << 2
        } else {
            self.identifier << 21
        };
        [
            identifier | u32::from(self.is_remote) << 1,
            u32::from(self.length_code),
            u32::from_le_bytes([a, b, c, d]),
            u32::from_le_bytes([e, f, g, h]),
        ]
    }

    fn of_words([identifier, length, low, high]: [u32; 4]) -> Self {
        let is_extended = identifier & 1 << 2 != 0;
        let mut bytes = [0; 8];
        bytes[..4].copy_from_slice(&low.to_le_bytes());
        bytes[4..].copy_from_slice(&high.to_le_bytes());
        Self {
            identifier: identifier >> if is_extended { 3 } else { 21 },
            is_extended,
            is_remote: identifier & 1 << 1 != 0,
            length_code: (length & 0xf) as u8,
            bytes,
        }
    }

    /// What a 16-bit filter looks at.
    fn pattern(&self) -> u16 {
        let (top, low) = if self.is_extended {
            (self.identifier >> 18, self.identifier >> 15 & 7)
        } else {
            (self.identifier, 0)
        };
        (top << 5) as u16
            | u16::from(self.is_remote) << 4
            | u16::from(self.is_extended) << 3
            | low as u16
    }

    /// Bits on the wire: 47 beside the payload, of 11-bit frames without stuff bits.
    fn bits(&self) -> u64 {
        47 + 8 * u64::from(self.length_code.min(8))
    }
}

/// A mailbox: its words, and whether it is requested since when in the order of filling.
#[derive(Clone, Copy, Debug, Default)]
struct Mailbox {
    words: [u32; 4],
    pending: Option<u64>,
    is_aborted: bool,
}

#[derive(Debug)]
pub(crate) struct Bxcan {
    /// Whether there is a unit; without one everything reads 0.
    pub(crate) is_present: bool,
    pub(crate) wire: Wire,
    /// Whether releasing a FIFO's frame takes until the next bit.
    pub(crate) is_release_slow: bool,
    /// What the unit sent and somebody acknowledged.
    pub(crate) on_wire: Vec<WireFrame>,
    /// Accesses to registers so far.
    pub(crate) accesses: u32,
    pub(crate) now_us: u64,
    plain: BTreeMap<usize, u32>,
    is_in_initialisation: bool,
    recessive: u32,
    recovery: u32,
    is_off: bool,
    error_flag: bool,
    transmit_errors: u32,
    fifo: VecDeque<WireFrame>,
    is_overrun: bool,
    is_releasing: bool,
    mailboxes: [Mailbox; 3],
    transmit_status: u32,
    filled: u64,
    sending: Option<(usize, u64)>,
}

const MCR: usize = 0x00;
const MSR: usize = 0x04;
const TSR: usize = 0x08;
const RF0R: usize = 0x0c;
const IER: usize = 0x14;
const ESR: usize = 0x18;
const BTR: usize = 0x1c;
const FMR: usize = 0x200;
const FM1R: usize = 0x204;
const FS1R: usize = 0x20c;
const FFA1R: usize = 0x214;
const FA1R: usize = 0x21c;

impl Bxcan {
    /// A unit out of reset on a healthy wire.
    fn out_of_reset() -> Self {
        Self {
            is_present: true,
            wire: Wire::Healthy,
            is_release_slow: false,
            on_wire: Vec::new(),
            accesses: 0,
            now_us: 0,
            plain: BTreeMap::from([(MCR, 0x0001_0002), (FMR, 0x2a1c_0e01)]),
            is_in_initialisation: false,
            recessive: 0,
            recovery: 0,
            is_off: false,
            error_flag: false,
            transmit_errors: 0,
            fifo: VecDeque::new(),
            is_overrun: false,
            is_releasing: false,
            mailboxes: [Mailbox::default(); 3],
            transmit_status: 0,
            filled: 0,
            sending: None,
        }
    }

    pub(crate) fn plain(&self, offset: usize) -> u32 {
        self.plain.get(&offset).copied().unwrap_or(0)
    }

    /// Whether the interrupt of FIFO 0 is raised.
    pub(crate) fn is_interrupting(&self) -> bool {
        self.plain(IER) & 1 << 1 != 0 && !self.fifo.is_empty()
    }

    /// Lets bits pass.
    pub(crate) fn pass(&mut self, bits: u64) {
        for _ in 0..bits {
            self.bit();
        }
    }

    /// Somebody else's frame.
    pub(crate) fn receives(&mut self, frame: &WireFrame) {
        let listens = self.is_present
            && !self.is_in_initialisation
            && !self.is_off
            && self.plain(MCR) & 0b11 == 0
            && self.plain(FMR) & 1 == 0;
        if !listens || !self.lets_in(frame) {
            return;
        }
        if self.fifo.len() == 3 {
            assert_eq!(self.plain(MCR) & 1 << 3, 0, "the FIFO is locked");
            self.fifo.pop_back();
            self.is_overrun = true;
        }
        self.fifo.push_back(*frame);
    }

    fn lets_in(&self, frame: &WireFrame) -> bool {
        (0..14)
            .filter(|bank| self.plain(FA1R) & 1 << bank != 0)
            .any(|bank| {
                let has = |register: usize| self.plain(register) & 1 << bank != 0;
                assert!(has(FM1R) && !has(FS1R) && !has(FFA1R), "bank {bank}");
                [0x240, 0x244].iter().any(|word| {
                    let bits = self.plain(word + 8 * bank);
                    [bits as u16, (bits >> 16) as u16].contains(&frame.pattern())
                })
            })
    }

    fn bit(&mut self) {
        self.now_us += 1;
        self.is_releasing = false;
        if !self.is_present {
            return;
        }
        self.recessive = match self.wire {
            Wire::Dominant => 0,
            _ => self.recessive + 1,
        };
        let wants_initialisation = self.plain(MCR) & 1 != 0;
        if wants_initialisation {
            self.is_in_initialisation |= self.sending.is_none();
        } else if self.is_in_initialisation && self.recessive >= 11 {
            self.is_in_initialisation = false;
        }
        if self.is_in_initialisation {
            return;
        }
        if self.is_off {
            return self.recover();
        }
        self.send();
    }

    /// 128 times 11 recessive bits, if the unit may come back by itself.
    fn recover(&mut self) {
        if self.plain(MCR) & 1 << 6 == 0 || self.wire == Wire::Dominant {
            self.recovery = 0;
            return;
        }
        self.recovery += 1;
        if self.recovery == 128 * 11 {
            self.recovery = 0;
            self.is_off = false;
            self.transmit_errors = 0;
        }
    }

    fn send(&mut self) {
        let Some((mailbox, left)) = self.sending else {
            let waiting = self.mailboxes.iter().enumerate();
            // In the order of filling, as TXFP has it.
            let next = waiting
                .filter_map(|(index, mailbox)| Some((mailbox.pending?, index)))
                .min();
            if let Some((_, index)) = next {
                assert_ne!(self.plain(MCR) & 1 << 2, 0, "sent by identifier");
                let frame = WireFrame::of_words(self.mailboxes[index].words);
                self.sending = Some((index, frame.bits()));
            }
            return;
        };
        if left > 1 {
            self.sending = Some((mailbox, left - 1));
            return;
        }
        self.sending = None;
        match self.wire {
            Wire::Healthy => {
                self.transmit_errors = self.transmit_errors.saturating_sub(1);
                let frame = WireFrame::of_words(self.mailboxes[mailbox].words);
                self.on_wire.push(frame);
                self.finish(mailbox, 0b11);
                return;
            }
            // A passive unit no longer counts a missing acknowledgement.
            Wire::Alone if self.transmit_errors >= 128 => {}
            _ => self.transmit_errors += 8,
        }
        if self.transmit_errors > 255 {
            self.is_off = true;
            self.recovery = 0;
            self.error_flag |= self.plain(IER) & 1 << 10 != 0;
        }
        if self.mailboxes[mailbox].is_aborted {
            self.finish(mailbox, 0b01);
        }
    }

    fn finish(&mut self, mailbox: usize, outcome: u32) {
        self.mailboxes[mailbox].pending = None;
        self.mailboxes[mailbox].is_aborted = false;
        self.transmit_status |= outcome << (8 * mailbox);
    }

    fn read(&self, offset: usize) -> u32 {
        match offset {
            MSR => {
                u32::from(self.is_in_initialisation)
                    | (self.plain(MCR) & 1 << 1)
                    | u32::from(self.error_flag) << 2
            }
            TSR => {
                let empty = |index: usize| u32::from(self.mailboxes[index].pending.is_none());
                self.transmit_status | empty(0) << 26 | empty(1) << 27 | empty(2) << 28
            }
            RF0R => {
                self.fifo.len() as u32
                    | u32::from(self.is_overrun) << 4
                    | u32::from(self.is_releasing) << 5
            }
            ESR => u32::from(self.is_off) << 2 | self.transmit_errors.min(255) << 16,
            0x1b0..0x1c0 => {
                let frame = self.fifo.front().expect("an empty FIFO is read");
                frame.words()[(offset - 0x1b0) / 4]
            }
            _ => self.plain(offset),
        }
    }

    fn write(&mut self, offset: usize, bits: u32) {
        match offset {
            MSR => self.error_flag &= bits & 1 << 2 == 0,
            TSR => self.write_transmit_status(bits),
            RF0R => {
                self.is_overrun &= bits & 1 << 4 == 0;
                if bits & 1 << 5 != 0 {
                    assert!(!self.is_releasing, "released while releasing");
                    self.fifo.pop_front().expect("an empty FIFO is released");
                    self.is_releasing = self.is_release_slow;
                }
            }
            0x180..0x1b0 => {
                let (index, word) = ((offset - 0x180) / 16, offset % 16 / 4);
                let mailbox = &mut self.mailboxes[index];
                assert!(mailbox.pending.is_none(), "a full mailbox is written");
                mailbox.words[word] = bits;
                if word == 0 && bits & 1 != 0 {
                    mailbox.pending = Some(self.filled);
                    self.filled += 1;
                    // A request clears what is known of the last one; here it does not,
                    // so that nobody relies on it.
                }
            }
            BTR => {
                assert!(self.is_in_initialisation, "the timing is locked");
                self.plain.insert(offset, bits);
            }
            FM1R | FS1R | FFA1R | 0x240.. => {
                assert_ne!(self.plain(FMR) & 1, 0, "the filters are locked");
                assert_eq!(self.plain(FA1R) & 0x3fff, 0, "a filter is active");
                self.plain.insert(offset, bits);
            }
            MCR | IER | FMR | FA1R => {
                self.plain.insert(offset, bits);
            }
            _ => unreachable!("{offset:#x} is written"),
        }
    }

    fn write_transmit_status(&mut self, bits: u32) {
        for mailbox in 0..3 {
            let shift = 8 * mailbox;
            if bits & 1 << shift != 0 {
                self.transmit_status &= !(0xf << shift);
            }
            if bits & 1 << (shift + 7) != 0 && self.mailboxes[mailbox].pending.is_some() {
                if self.sending.is_some_and(|(sent, _)| sent == mailbox) {
                    self.mailboxes[mailbox].is_aborted = true;
                } else {
                    self.finish(mailbox, 0b01);
                }
            }
        }
    }
}

/// The unit, for the controller and for the test at once.
#[derive(Clone, Debug)]
pub(crate) struct Unit(pub(crate) Rc<RefCell<Bxcan>>);

impl Unit {
    pub(crate) fn out_of_reset() -> Self {
        Self(Rc::new(RefCell::new(Bxcan::out_of_reset())))
    }
}

impl CanRegisters for Unit {
    fn read(&self, register: CanRegister) -> u32 {
        let mut unit = self.0.borrow_mut();
        unit.accesses += 1;
        if unit.is_present {
            unit.read(register.offset())
        } else {
            0
        }
    }

    fn write(&mut self, register: CanRegister, bits: u32) {
        let mut unit = self.0.borrow_mut();
        unit.accesses += 1;
        if unit.is_present {
            unit.write(register.offset(), bits);
        }
    }
}
