//! An I2C unit of the chip and its two pins on port B, for the master.

use core::ops::Deref;

use stm32f4xx_hal::gpio::{Alternate, OpenDrain, Output, Pin, PinMode, PinState};
use stm32f4xx_hal::pac::i2c1::RegisterBlock;

use amiro_ipf::board::i2c::{BusLine, I2cRegister, I2cRegisters};

/// The rate of half clocks by hand: 2.5 us.
const HALF_CLOCK_HZ: u32 = 400_000;

/// A pin of port B, driven by the unit or by hand. Open drain either way, without a
/// pull: the board has resistors.
enum Wire<const N: u8> {
    Unit(Pin<'B', N, Alternate<4, OpenDrain>>),
    Hand(Pin<'B', N, Output<OpenDrain>>),
    /// From one to the other.
    Changing,
}

impl<const N: u8> Wire<N> {
    fn new<M: PinMode>(pin: Pin<'B', N, M>) -> Self {
        Self::Hand(Output::new(pin, PinState::High))
    }

    fn take(&mut self) {
        *self = match core::mem::replace(self, Self::Changing) {
            Self::Unit(pin) => Self::new(pin),
            other => other,
        };
        self.release();
    }

    fn hand_back(&mut self) {
        *self = match core::mem::replace(self, Self::Changing) {
            Self::Hand(pin) => Self::Unit(pin.into_mode()),
            other => other,
        };
    }

    fn pull(&mut self) {
        if let Self::Hand(pin) = self {
            pin.set_low();
        }
    }

    fn release(&mut self) {
        if let Self::Hand(pin) = self {
            pin.set_high();
        }
    }

    /// The wire's level, which an output of this chip reads as well.
    fn is_high(&self) -> bool {
        match self {
            Self::Hand(pin) => pin.is_high(),
            Self::Unit(_) | Self::Changing => false,
        }
    }
}

/// One I2C unit with SCL and SDA on the pins of these numbers.
pub(crate) struct Port<I, const SCL: u8, const SDA: u8> {
    unit: I,
    clock: Wire<SCL>,
    data: Wire<SDA>,
    half_clock_cycles: u32,
}

impl<I, const SCL: u8, const SDA: u8> Port<I, SCL, SDA> {
    /// A port of a unit that is clocked; its pins are taken and released.
    pub(crate) fn new<C: PinMode, D: PinMode>(
        unit: I,
        clock: Pin<'B', SCL, C>,
        data: Pin<'B', SDA, D>,
        core_hz: u32,
    ) -> Self {
        Self {
            unit,
            clock: Wire::new(clock),
            data: Wire::new(data),
            half_clock_cycles: core_hz.div_ceil(HALF_CLOCK_HZ),
        }
    }
}

impl<I, const SCL: u8, const SDA: u8> I2cRegisters for Port<I, SCL, SDA>
where
    I: Deref<Target = RegisterBlock>,
{
    fn read(&mut self, register: I2cRegister) -> u16 {
        match register {
            I2cRegister::Cr1 => self.unit.cr1().read().bits(),
            I2cRegister::Cr2 => self.unit.cr2().read().bits(),
            I2cRegister::Dr => self.unit.dr().read().bits(),
            I2cRegister::Sr1 => self.unit.sr1().read().bits(),
            I2cRegister::Sr2 => self.unit.sr2().read().bits(),
            I2cRegister::Ccr => self.unit.ccr().read().bits(),
            I2cRegister::Trise => self.unit.trise().read().bits(),
        }
    }

    fn write(&mut self, register: I2cRegister, value: u16) {
        write_to(&self.unit, register, value);
    }

    fn take_pins(&mut self) {
        self.clock.take();
        self.data.take();
    }

    fn return_pins(&mut self) {
        self.clock.hand_back();
        self.data.hand_back();
    }

    fn pull(&mut self, line: BusLine) {
        match line {
            BusLine::Clock => self.clock.pull(),
            BusLine::Data => self.data.pull(),
        }
    }

    fn release(&mut self, line: BusLine) {
        match line {
            BusLine::Clock => self.clock.release(),
            BusLine::Data => self.data.release(),
        }
    }

    fn is_high(&mut self, line: BusLine) -> bool {
        match line {
            BusLine::Clock => self.clock.is_high(),
            BusLine::Data => self.data.is_high(),
        }
    }

    fn wait_half_clock(&mut self) {
        cortex_m::asm::delay(self.half_clock_cycles);
    }

    fn without_interrupts<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        cortex_m::interrupt::free(|_| work(self))
    }
}

#[expect(unsafe_code, reason = "the registers take raw numbers")]
/// Writes a register of an I2C unit.
fn write_to(unit: &RegisterBlock, register: I2cRegister, value: u16) {
    // SAFETY: an I2C unit reaches memory by DMA alone, which is not set up for it:
    // whatever its registers hold, it can but drive two wires and raise interrupts.
    // Reserved bits are never set by the master.
    unsafe {
        match register {
            I2cRegister::Cr1 => unit.cr1().write(|w| w.bits(value)),
            I2cRegister::Cr2 => unit.cr2().write(|w| w.bits(value)),
            I2cRegister::Dr => unit.dr().write(|w| w.bits(value)),
            I2cRegister::Sr1 => unit.sr1().write(|w| w.bits(value)),
            // Read only.
            I2cRegister::Sr2 => value,
            I2cRegister::Ccr => unit.ccr().write(|w| w.bits(value)),
            I2cRegister::Trise => unit.trise().write(|w| w.bits(value)),
        };
    }
}
