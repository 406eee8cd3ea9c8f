//! A board whose units are memory: what the sampler takes for the real one.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

use amiro_ipf::node::SeedSource;
use stm32f4xx_hal::gpio::{Input, PC13};
use stm32f4xx_hal::pac::RCC;
use stm32f4xx_hal::rcc::Rcc;

use amiro_ipf::board::can::{self, CanController};
use amiro_ipf::board::i2c::{self, BusLine, I2cMaster, I2cRegister, I2cRegisters};

#[path = "../../../src/bin/firmware/hal/clocks.rs"]
mod clocks;
#[expect(dead_code, reason = "nobody waits for this board")]
#[path = "../../../src/bin/firmware/hal/robot_lines.rs"]
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

    pub(crate) fn read(&self, register: I2cRegister) -> u16 {
        self.0[register as usize].load(Ordering::Relaxed)
    }

    pub(crate) fn write(&self, register: I2cRegister, value: u16) {
        self.0[register as usize].store(value, Ordering::Relaxed);
    }
}

/// The registers of the CAN unit that are in use: up to the third filter bank.
pub(crate) struct CanCells([AtomicU32; 0x258 / 4]);

impl CanCells {
    pub(crate) const fn new() -> Self {
        Self([const { AtomicU32::new(0) }; 0x258 / 4])
    }

    pub(crate) fn read(&self, register: can::CanRegister) -> u32 {
        self.0[register.offset() / 4].load(Ordering::Relaxed)
    }

    pub(crate) fn write(&self, register: can::CanRegister, bits: u32) {
        self.0[register.offset() / 4].store(bits, Ordering::Relaxed);
    }
}

/// One I2C unit.
pub(crate) struct Port(pub(crate) &'static I2cCells);

/// CR1: make a stop.
pub(crate) const STOP: u16 = 1 << 9;

impl I2cRegisters for Port {
    fn read(&mut self, register: I2cRegister) -> u16 {
        let value = self.0.read(register);
        match register {
            // A stop is made at once: the first look sees it.
            I2cRegister::Cr1 => value & !STOP,
            _ => value,
        }
    }

    fn write(&mut self, register: I2cRegister, value: u16) {
        self.0.write(register, value);
    }

    fn take_pins(&mut self) {}

    fn return_pins(&mut self) {}

    fn pull(&mut self, _: BusLine) {}

    fn release(&mut self, _: BusLine) {}

    fn is_high(&mut self, _: BusLine) -> bool {
        true
    }

    fn wait_half_clock(&mut self) {}

    fn without_interrupts<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        cortex_m::interrupt::free(|_| work(self))
    }
}

/// The CAN unit.
pub(crate) struct CanUnit(pub(crate) &'static CanCells);

impl can::CanRegisters for CanUnit {
    fn read(&self, register: can::CanRegister) -> u32 {
        self.0.read(register)
    }

    fn write(&mut self, register: can::CanRegister, bits: u32) {
        // What is known of the mailboxes stays: each is sent at once.
        if register != can::CanRegister::TSR {
            self.0.write(register, bits);
        }
    }
}

pub(crate) type BusMaster = I2cMaster<Port>;
pub(crate) type Can = CanController<CanUnit>;

/// As the image's.
pub(crate) struct AcquisitionUnits {
    pub(crate) one: BusMaster,
    pub(crate) two: BusMaster,
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
) -> (BusMaster, BusMaster) {
    let timing = i2c::I2cTiming::fast(bus_hz);
    (
        I2cMaster::new(Port(one), timing, 0),
        I2cMaster::new(Port(two), timing, 0),
    )
}
