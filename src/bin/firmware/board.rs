//! The board: clocks, pins, the serial line. Nobody else names a register or a pin.

use amiro_ipf::BUILD_ID;
use amiro_ipf::event::{Boot, ClockSource};
use amiro_ipf::wire::{WINDOW, WIRE_VERSION};
use cortex_m::peripheral::SYST;
use stm32f4xx_hal::gpio::{OpenDrain, Output, PB12, PinState};
use stm32f4xx_hal::pac::i2c1::RegisterBlock;
use stm32f4xx_hal::pac::{I2C1, I2C2, Peripherals, RCC, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable, Rcc, Reset};
use stm32f4xx_hal::serial::Serial;

use crate::budget::CAPACITY;
use crate::clock::Mono;
use crate::i2c::{Master, Register, Timing};
use crate::i2c_port::Port;

/// Full speed, hertz.
const CORE_HZ: u32 = 168_000_000;

/// The crystal, hertz.
const CRYSTAL_HZ: u32 = 8_000_000;

/// Turns of a polling loop after which a clock is given up: at 16 MHz and some ten
/// cycles a turn 60 ms, many times what a crystal (2 ms) or a PLL (0.3 ms) needs.
const PATIENCE: u32 = 100_000;

/// The bus of sensors 0, 1, 2 and 7: SCL on PB8, SDA on PB9.
pub(crate) type BusOne = Master<Port<I2C1, 8, 9>>;

/// The bus of sensors 3 to 6 and of the memory: SCL on PB10, SDA on PB11.
pub(crate) type BusTwo = Master<Port<I2C2, 10, 11>>;

/// The board after start.
pub(crate) struct Board {
    /// The serial line, running.
    pub(crate) usart: USART2,
    /// The heartbeat's light.
    pub(crate) led: Led,
    /// The first bus, freed if it could be.
    #[expect(dead_code, reason = "nobody has transactions for it yet")]
    pub(crate) bus_one: BusOne,
    /// The second bus, freed if it could be.
    #[expect(dead_code, reason = "nobody has transactions for it yet")]
    pub(crate) bus_two: BusTwo,
    /// How the board introduces itself.
    pub(crate) boot: Boot,
    /// Differs from boot to boot.
    pub(crate) boot_id: u8,
}

impl Board {
    /// Starts clocks, pins and line. Every wait is bounded.
    pub(crate) fn start(device: Peripherals, systick: SYST) -> Self {
        let (mut rcc, clock) = start_clocks(device.RCC);
        let core_hz = match clock {
            // The clock unit says nothing about the core's speed: assume the nominal
            // one, which is what emulators run their timers at.
            ClockSource::Unknown => CORE_HZ,
            _ => rcc.clocks.hclk().raw(),
        };
        Mono::start(systick, core_hz);
        let gpio_a = device.GPIOA.split(&mut rcc);
        let gpio_b = device.GPIOB.split(&mut rcc);
        let gpio_c = device.GPIOC.split(&mut rcc);
        // Power of the whole stack: regulators, system power, no warm reset. A pin
        // left floating here switches the robot off.
        gpio_a.pa8.into_push_pull_output_in_state(PinState::High);
        gpio_b.pb2.into_push_pull_output_in_state(PinState::High);
        gpio_c.pc14.into_open_drain_output_in_state(PinState::High);
        let led = gpio_b.pb12.into_open_drain_output_in_state(PinState::High);
        let timing = Timing::fast(rcc.clocks.pclk1().raw());
        I2C1::enable(&mut rcc);
        I2C1::reset(&mut rcc);
        let port_one = Port::new(device.I2C1, gpio_b.pb8, gpio_b.pb9, core_hz);
        I2C2::enable(&mut rcc);
        I2C2::reset(&mut rcc);
        let port_two = Port::new(device.I2C2, gpio_b.pb10, gpio_b.pb11, core_hz);
        let baud = fastest_baud(rcc.clocks.pclk1().raw());
        let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
        let Ok(serial) = Serial::<_, u8>::new(device.USART2, pins, baud.bps(), &mut rcc) else {
            // Not for any clock that `start_clocks` leaves; without a line there is
            // nobody to tell.
            cortex_m::peripheral::SCB::sys_reset();
        };
        Self {
            usart: serial.release().0,
            led: Led(led),
            // Time begins with the board's.
            bus_one: Master::new(port_one, timing, 0),
            bus_two: Master::new(port_two, timing, 0),
            boot: Boot {
                wire_version: WIRE_VERSION,
                build_id: BUILD_ID,
                capacity: CAPACITY as u32,
                window: WINDOW,
                baud,
                clock,
                core_hz,
            },
            boot_id: count_boot(),
        }
    }
}

/// 2 Mbaud where the bus clock divides to it, as 42 MHz and 16 MHz do.
fn fastest_baud(bus_hz: u32) -> u32 {
    const FAST: u32 = 2_000_000;
    const SLOW: u32 = 115_200;
    if bus_hz >= 8 * FAST { FAST } else { SLOW }
}

#[expect(unsafe_code, reason = "the registers take raw numbers")]
/// Writes a register of an I2C unit.
pub(crate) fn write_i2c(unit: &RegisterBlock, register: Register, value: u16) {
    // SAFETY: an I2C unit reaches memory by DMA alone, which is not set up for it:
    // whatever its registers hold, it can but drive two wires and raise interrupts.
    // Reserved bits are never set by the master.
    unsafe {
        match register {
            Register::Cr1 => unit.cr1().write(|w| w.bits(value)),
            Register::Cr2 => unit.cr2().write(|w| w.bits(value)),
            Register::Dr => unit.dr().write(|w| w.bits(value)),
            Register::Sr1 => unit.sr1().write(|w| w.bits(value)),
            // Read only.
            Register::Sr2 => value,
            Register::Ccr => unit.ccr().write(|w| w.bits(value)),
            Register::Trise => unit.trise().write(|w| w.bits(value)),
        };
    }
}

/// The board's LED, lit while its pin is low.
pub(crate) struct Led(PB12<Output<OpenDrain>>);

impl Led {
    /// On to off, off to on.
    pub(crate) fn toggle(&mut self) {
        self.0.toggle();
    }
}

/// Brings the core to 168 MHz, or as near as the board can.
///
/// A boot loader leaves the PLL running, so everything first goes back to the
/// internal oscillator. The HAL's own start waits without bound; here crystal and
/// PLL are started first, with bounds and with the very settings that the HAL
/// computes, so that its loops end at once.
fn start_clocks(rcc: RCC) -> (Rcc, ClockSource) {
    rcc.cr().modify(|_, w| w.hsion().set_bit());
    if !patiently(|| rcc.cr().read().hsirdy().bit_is_set()) {
        return (rcc.freeze(Config::hsi()), ClockSource::Unknown);
    }
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    patiently(|| rcc.cfgr().read().sws().is_hsi());
    rcc.cr().modify(|_, w| w.pllon().clear_bit());
    patiently(|| rcc.cr().read().pllrdy().bit_is_clear());
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    if patiently(|| rcc.cr().read().hserdy().bit_is_set()) && lock_pll(&rcc, true) {
        let config = Config::hse(CRYSTAL_HZ.Hz()).sysclk(CORE_HZ.Hz());
        return (rcc.freeze(config), ClockSource::CrystalPll);
    }
    rcc.cr()
        .modify(|_, w| w.hseon().clear_bit().pllon().clear_bit());
    patiently(|| rcc.cr().read().pllrdy().bit_is_clear());
    if lock_pll(&rcc, false) {
        let config = Config::hsi().sysclk(CORE_HZ.Hz());
        return (rcc.freeze(config), ClockSource::InternalPll);
    }
    rcc.cr().modify(|_, w| w.pllon().clear_bit());
    (rcc.freeze(Config::hsi()), ClockSource::Internal)
}

#[expect(unsafe_code, reason = "the register's fields take raw numbers")]
/// Starts the PLL for 168 MHz: 2 MHz in (M), 336 MHz inside (N), half out (P), 48 MHz
/// beside (Q). Whether it locked.
fn lock_pll(rcc: &RCC, crystal: bool) -> bool {
    let m = if crystal { 4 } else { 8 };
    rcc.pllcfgr().write(|w| {
        // SAFETY: M 2..=63, N 50..=432 and Q 2..=15 are the ranges of the reference
        // manual (RM0090, 7.3.2), and these values lie inside.
        unsafe {
            w.pllm().bits(m);
            w.plln().bits(168);
            w.pllq().bits(7);
        }
        w.pllp().div2().pllsrc().bit(crystal)
    });
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    patiently(|| rcc.cr().read().pllrdy().bit_is_set())
}

/// Polls until `ready`, at most [`PATIENCE`] times; whether it became ready.
fn patiently(ready: impl Fn() -> bool) -> bool {
    (0..PATIENCE).any(|_| ready())
}

/// Counts boots in memory that a reset leaves alone; after power-on it starts anywhere.
///
/// From 0 to 159: 160 and above are left to hosts, whose frames stand beside a board's
/// in a recording.
fn count_boot() -> u8 {
    use core::sync::atomic::{AtomicU32, Ordering};

    #[expect(
        unsafe_code,
        reason = "only a section keeps memory from the start code"
    )]
    // SAFETY: the section exists in cortex-m-rt's linker script, and every bit
    // pattern that it may hold after power-on is a valid counter.
    #[unsafe(link_section = ".uninit.BOOTS")]
    static BOOTS: AtomicU32 = AtomicU32::new(0);

    (BOOTS.fetch_add(1, Ordering::Relaxed) % 160) as u8
}
