//! What is at the other end of the registers. None of it runs while calls are counted.

use amiro_ipf::board::can::{AmiroModule, StandardId};
use amiro_ipf::board::i2c::muxed_bus::MUX_ADDRESS;
use amiro_ipf::board::{can, eeprom, vcnl4020};

use crate::hal::{CanCells, I2cCells, STOP};
use amiro_ipf::board::i2c::I2cRegister;

/// CR1: make a start.
const START: u16 = 1 << 8;
/// SR1: a start is on the bus; the address was acknowledged; a byte is finished; a byte
/// was received.
const STARTED: u16 = 1 << 0;
const ADDRESSED: u16 = 1 << 1;
const FINISHED: u16 = 1 << 2;
const RECEIVED: u16 = 1 << 6;

/// In the data register while nothing was written to it.
const NOTHING: u16 = u16::MAX;

/// What the sensor says of itself: everything measured and ready.
const ALL_READY: u8 = 0b1110_0111;

/// Address of the multiplexer.
const MUX: u8 = MUX_ADDRESS.bits();

/// How far the unit is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Quiet,
    Started,
    Writing,
    Reading,
    Ending,
}

/// What the next interrupt of a unit is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    /// None: the bus is quiet.
    Nothing,
    /// An event to be served.
    Event,
    /// One that is only there because a repeated start has not been made yet.
    Useless,
}

/// One I2C unit with a multiplexer, sensors and a memory behind it.
pub(crate) struct Parts {
    cells: &'static I2cCells,
    phase: Phase,
    address: u8,
    /// The register or word that is read next.
    pointer: u8,
    is_first_byte: bool,
    channel: u8,
    was_useless: bool,
}

impl Parts {
    pub(crate) const fn new(cells: &'static I2cCells) -> Self {
        Self {
            cells,
            phase: Phase::Quiet,
            address: 0,
            pointer: 0,
            is_first_byte: false,
            channel: 0,
            was_useless: false,
        }
    }

    /// Moves the unit on to its next interrupt. Both bytes of a distance are the given
    /// one.
    pub(crate) fn go_on(&mut self, distance: u8) -> Next {
        let control = self.cells.read(I2cRegister::Cr1);
        let data = self.cells.read(I2cRegister::Dr);
        if control & START != 0 {
            if self.phase == Phase::Writing && self.is_repeated() {
                self.was_useless = true;
                return Next::Useless;
            }
            self.was_useless = false;
            self.cells.write(I2cRegister::Cr1, control & !START);
            return self.interrupt(Phase::Started, STARTED, NOTHING);
        }
        match self.phase {
            Phase::Started => {
                self.address = (data >> 1) as u8;
                self.is_first_byte = true;
                let phase = if data & 1 == 0 {
                    Phase::Writing
                } else {
                    Phase::Reading
                };
                self.interrupt(phase, ADDRESSED, NOTHING)
            }
            Phase::Writing if data != NOTHING => {
                self.take(data as u8);
                self.interrupt(Phase::Writing, FINISHED, NOTHING)
            }
            Phase::Reading => {
                let byte = u16::from(self.give(distance));
                if control & STOP == 0 {
                    self.is_first_byte = false;
                    return self.interrupt(Phase::Reading, FINISHED | RECEIVED, byte);
                }
                if core::mem::replace(&mut self.is_first_byte, false) {
                    // The stop was asked for before the only byte.
                    return self.interrupt(Phase::Ending, RECEIVED, byte);
                }
                self.quiet()
            }
            _ => self.quiet(),
        }
    }

    /// A start after bytes, without a stop between them; one useless event each.
    fn is_repeated(&self) -> bool {
        !self.was_useless && self.cells.read(I2cRegister::Sr1) != 0
    }

    fn interrupt(&mut self, phase: Phase, events: u16, data: u16) -> Next {
        self.phase = phase;
        self.cells.write(I2cRegister::Sr1, events);
        self.cells.write(I2cRegister::Dr, data);
        Next::Event
    }

    fn quiet(&mut self) -> Next {
        self.phase = Phase::Quiet;
        Next::Nothing
    }

    fn take(&mut self, byte: u8) {
        if self.address == MUX {
            self.channel = byte;
        } else if core::mem::replace(&mut self.is_first_byte, false) {
            self.pointer = byte;
        }
    }

    fn give(&mut self, distance: u8) -> u8 {
        let register = self.pointer;
        match self.address {
            MUX => self.channel,
            // Blank: the offsets are the defaults.
            eeprom::ADDRESS_AMIRO => 0xff,
            vcnl4020::ADDRESS => {
                self.pointer = register.wrapping_add(1);
                match register {
                    0x80 => ALL_READY,
                    0x81 => vcnl4020::IDENTITY,
                    0x87 | 0x88 => distance,
                    _ => 0,
                }
            }
            _ => 0xff,
        }
    }
}

/// MSR: in initialisation.
const INAK: u32 = 1;
/// TSR: all three mailboxes empty, each after its frame was sent.
const ALL_SENT: u32 = 7 << 26 | 1 << 17 | 1 << 9 | 1 << 1;

/// Lets the CAN unit into initialisation, and out of it when it is to go.
pub(crate) fn answer_mode(cells: &CanCells) {
    let wanted = cells.read(can::CanRegister::MCR) & INAK;
    cells.write(can::CanRegister::MSR, wanted);
    cells.write(can::CanRegister::TSR, ALL_SENT);
}

/// Puts a frame of the wheels' board into the FIFO: where they are, or how fast they turn.
pub(crate) fn put_frame(cells: &CanCells, device: u8, payload: u64) {
    let identifier = StandardId::of(device, AmiroModule::DiWheelDrive);
    cells.write(can::CanRegister::RI0R, u32::from(identifier.bits()) << 21);
    cells.write(can::CanRegister::RDT0R, 8);
    cells.write(can::CanRegister::RDL0R, payload as u32);
    cells.write(can::CanRegister::RDH0R, (payload >> 32) as u32);
    cells.write(can::CanRegister::RF0R, 1);
}
