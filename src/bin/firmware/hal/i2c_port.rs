//! An I2C unit of the chip and its two pins on port B, for the master.

use stm32f4xx_hal::gpio::{Alternate, OpenDrain, Output, Pin, PinMode, PinState};
use stm32f4xx_hal::pac::i2c1::RegisterBlock;
use stm32f4xx_hal::pac::{I2C1, I2C2};

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
}

/// A wire whose number is not in its type.
trait AnyWire {
    fn take(&mut self);
    fn hand_back(&mut self);
    /// Pulls the wire low or releases it, by hand.
    fn drive(&mut self, level: PinState);
    /// The wire's level, which an output of this chip reads as well.
    fn is_high(&self) -> bool;
}

impl<const N: u8> AnyWire for Wire<N> {
    fn take(&mut self) {
        *self = match core::mem::replace(self, Self::Changing) {
            Self::Unit(pin) => Self::new(pin),
            other => other,
        };
        self.drive(PinState::High);
    }

    fn hand_back(&mut self) {
        *self = match core::mem::replace(self, Self::Changing) {
            Self::Hand(pin) => Self::Unit(pin.into_mode()),
            other => other,
        };
    }

    fn drive(&mut self, level: PinState) {
        if let Self::Hand(pin) = self {
            pin.set_state(level);
        }
    }

    fn is_high(&self) -> bool {
        match self {
            Self::Hand(pin) => pin.is_high(),
            Self::Unit(_) | Self::Changing => false,
        }
    }
}

/// One of the two I2C units that the board uses, with its SCL and SDA.
enum Unit {
    One(I2C1, Wire<8>, Wire<9>),
    Two(I2C2, Wire<10>, Wire<11>),
}

/// An I2C unit and its pins. Both units have this type: the master's code is in the image
/// once.
pub(crate) struct Port {
    unit: Unit,
    half_clock_cycles: u32,
}

impl Port {
    /// The port of I2C1, which is clocked; its pins are taken and released.
    pub(crate) fn one<C: PinMode, D: PinMode>(
        unit: I2C1,
        clock: Pin<'B', 8, C>,
        data: Pin<'B', 9, D>,
        core_hz: u32,
    ) -> Self {
        Self::new(Unit::One(unit, Wire::new(clock), Wire::new(data)), core_hz)
    }

    /// The port of I2C2, which is clocked; its pins are taken and released.
    pub(crate) fn two<C: PinMode, D: PinMode>(
        unit: I2C2,
        clock: Pin<'B', 10, C>,
        data: Pin<'B', 11, D>,
        core_hz: u32,
    ) -> Self {
        Self::new(Unit::Two(unit, Wire::new(clock), Wire::new(data)), core_hz)
    }

    fn new(unit: Unit, core_hz: u32) -> Self {
        Self {
            unit,
            half_clock_cycles: core_hz.div_ceil(HALF_CLOCK_HZ),
        }
    }

    fn registers(&self) -> &RegisterBlock {
        match &self.unit {
            Unit::One(unit, ..) => unit,
            Unit::Two(unit, ..) => unit,
        }
    }

    fn wire(&mut self, line: BusLine) -> &mut dyn AnyWire {
        match (&mut self.unit, line) {
            (Unit::One(_, clock, _), BusLine::Clock) => clock,
            (Unit::One(_, _, data), BusLine::Data) => data,
            (Unit::Two(_, clock, _), BusLine::Clock) => clock,
            (Unit::Two(_, _, data), BusLine::Data) => data,
        }
    }
}

impl I2cRegisters for Port {
    fn read(&mut self, register: I2cRegister) -> u16 {
        let unit = self.registers();
        match register {
            I2cRegister::Cr1 => unit.cr1().read().bits(),
            I2cRegister::Cr2 => unit.cr2().read().bits(),
            I2cRegister::Dr => unit.dr().read().bits(),
            I2cRegister::Sr1 => unit.sr1().read().bits(),
            I2cRegister::Sr2 => unit.sr2().read().bits(),
            I2cRegister::Ccr => unit.ccr().read().bits(),
            I2cRegister::Trise => unit.trise().read().bits(),
        }
    }

    fn write(&mut self, register: I2cRegister, value: u16) {
        write_to(self.registers(), register, value);
    }

    fn take_pins(&mut self) {
        self.wire(BusLine::Clock).take();
        self.wire(BusLine::Data).take();
    }

    fn return_pins(&mut self) {
        self.wire(BusLine::Clock).hand_back();
        self.wire(BusLine::Data).hand_back();
    }

    fn pull(&mut self, line: BusLine) {
        self.wire(line).drive(PinState::Low);
    }

    fn release(&mut self, line: BusLine) {
        self.wire(line).drive(PinState::High);
    }

    fn is_high(&mut self, line: BusLine) -> bool {
        self.wire(line).is_high()
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
    // SAFETY: an I2C unit reaches memory by DMA only, which is not set up for it:
    // with any register contents it only drives two wires and raises interrupts.
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
