//! A board whose units are memory: what the sampler takes for the real one.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

use amiro_ipf::node::SeedSource;
use stm32f4xx_hal::gpio::{Input, PC13};
use stm32f4xx_hal::pac::RCC;
use stm32f4xx_hal::rcc::Rcc;

use amiro_ipf::board::can::{self, Controller};
use amiro_ipf::board::i2c::{self, Line, Master, Register, Registers};

#[path = "../../../src/bin/firmware/board/clocks.rs"]
mod clocks;
#[expect(dead_code, reason = "nobody waits for this board")]
#[path = "../../../src/bin/firmware/board/robot_lines.rs"]
mod robot_lines;

pub(crate) use robot_lines::ShutdownLine;

/// The core's clock, hertz. An emulator's timer runs at it, whatever its clock unit says.
pub(crate) const CORE_HZ: u32 = clocks::CORE_HZ;

/// Starts the clocks as the image does.
pub(crate) fn start_clocks(unit: RCC) -> Rcc {
    clocks::start(unit).0
}

/// The registers of one I2C unit.
pub(crate) struct I2cCells([AtomicU16; 7]);

impl I2cCells {
    pub(crate) const fn new() -> Self {
        Self([const { AtomicU16::new(0) }; 7])
    }

    pub(crate) fn read(&self, register: Register) -> u16 {
        self.0[register as usize].load(Ordering::Relaxed)
    }

    pub(crate) fn write(&self, register: Register, value: u16) {
        self.0[register as usize].store(value, Ordering::Relaxed);
    }
}

/// The registers of the CAN unit that are in use: up to the third filter bank.
pub(crate) struct CanCells([AtomicU32; 0x258 / 4]);

impl CanCells {
    pub(crate) const fn new() -> Self {
        Self([const { AtomicU32::new(0) }; 0x258 / 4])
    }

    pub(crate) fn read(&self, register: can::Register) -> u32 {
        self.0[register.offset() / 4].load(Ordering::Relaxed)
    }

    pub(crate) fn write(&self, register: can::Register, bits: u32) {
        self.0[register.offset() / 4].store(bits, Ordering::Relaxed);
    }
}

/// One I2C unit; each of its own type, as the image's are.
pub(crate) struct Port<const UNIT: usize>(pub(crate) &'static I2cCells);

/// CR1: make a stop.
pub(crate) const STOP: u16 = 1 << 9;

impl<const UNIT: usize> Registers for Port<UNIT> {
    fn read(&mut self, register: Register) -> u16 {
        let value = self.0.read(register);
        match register {
            // A stop is made at once: the first look sees it.
            Register::Cr1 => value & !STOP,
            _ => value,
        }
    }

    fn write(&mut self, register: Register, value: u16) {
        self.0.write(register, value);
    }

    fn take_pins(&mut self) {}

    fn return_pins(&mut self) {}

    fn pull(&mut self, _: Line) {}

    fn release(&mut self, _: Line) {}

    fn is_high(&mut self, _: Line) -> bool {
        true
    }

    fn wait_half_clock(&mut self) {}

    fn undisturbed<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        cortex_m::interrupt::free(|_| work(self))
    }
}

/// The CAN unit.
pub(crate) struct CanUnit(pub(crate) &'static CanCells);

impl can::Registers for CanUnit {
    fn read(&self, register: can::Register) -> u32 {
        self.0.read(register)
    }

    fn write(&mut self, register: can::Register, bits: u32) {
        // What is known of the mailboxes stays: each is sent at once.
        if register != can::Register::TSR {
            self.0.write(register, bits);
        }
    }
}

pub(crate) type BusOne = Master<Port<1>>;
pub(crate) type BusTwo = Master<Port<2>>;
pub(crate) type Can = Controller<CanUnit>;

/// As the image's.
pub(crate) struct SenseUnits {
    pub(crate) one: BusOne,
    pub(crate) two: BusTwo,
    pub(crate) can: Can,
    pub(crate) seed: SeedSource,
    pub(crate) shutdown_line: ShutdownLine,
}

/// The shutdown line, on its pin.
pub(crate) fn shutdown_line(pin: PC13<Input>) -> ShutdownLine {
    ShutdownLine::new(pin)
}

/// Masters on these registers.
pub(crate) fn masters(
    one: &'static I2cCells,
    two: &'static I2cCells,
    bus_hz: u32,
) -> (BusOne, BusTwo) {
    let timing = i2c::Timing::fast(bus_hz);
    (
        Master::new(Port(one), timing, 0),
        Master::new(Port(two), timing, 0),
    )
}
