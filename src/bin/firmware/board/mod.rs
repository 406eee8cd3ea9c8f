//! The board: clocks, pins, units. Nobody else names a register or a pin but the line.

mod can_unit;
mod clocks;
mod i2c_port;
mod random_unit;

use amiro_ipf::BUILD_ID;
use amiro_ipf::event::{Boot, ClockSource};
use amiro_ipf::seed::{SeedSource, from_unique_number, from_words};
use amiro_ipf::wire::{WINDOW, WIRE_VERSION};
use cortex_m::peripheral::SYST;
use stm32f4xx_hal::gpio::alt::can1;
use stm32f4xx_hal::gpio::{OpenDrain, Output, PB12, PinState};
use stm32f4xx_hal::pac::{I2C1, I2C2, Peripherals, RNG, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::serial::Serial;

use crate::budget::CAPACITY;
use crate::can::{BitTiming, Controller};
use crate::clock::Mono;
use crate::i2c::{Master, Timing};
use can_unit::CanUnit;
use i2c_port::Port;

/// The bus of sensors 0, 1, 2 and 7: SCL on PB8, SDA on PB9.
pub(crate) type BusOne = Master<Port<I2C1, 8, 9>>;

/// The bus of sensors 3 to 6 and of the memory: SCL on PB10, SDA on PB11.
pub(crate) type BusTwo = Master<Port<I2C2, 10, 11>>;

/// The robot's own bus.
pub(crate) type Can = Controller<CanUnit>;

/// The board after start.
pub(crate) struct Board {
    /// The serial line, running.
    pub(crate) usart: USART2,
    /// The heartbeat's light.
    pub(crate) led: Led,
    /// The first bus, freed if it could be.
    pub(crate) bus_one: BusOne,
    /// The second bus, freed if it could be.
    pub(crate) bus_two: BusTwo,
    /// The robot's bus, not asked yet.
    pub(crate) can: Can,
    /// How the board introduces itself.
    pub(crate) boot: Boot,
    /// Differs from boot to boot.
    pub(crate) boot_id: u8,
    /// A seed of the board's own, and what it was made of.
    pub(crate) seed: (u64, SeedSource),
}

impl Board {
    /// Starts clocks, pins, buses and line. Every wait is bounded.
    pub(crate) fn start(device: Peripherals, systick: SYST) -> Self {
        let (mut rcc, clock) = clocks::start(device.RCC);
        let core_hz = match clock {
            // The clock unit says nothing about the core's speed: assume the nominal
            // one, which is what emulators run their timers at.
            ClockSource::Unknown => clocks::CORE_HZ,
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
        let bus_hz = rcc.clocks.pclk1().raw();
        let timing = Timing::fast(bus_hz);
        I2C1::enable(&mut rcc);
        I2C1::reset(&mut rcc);
        let port_one = Port::new(device.I2C1, gpio_b.pb8, gpio_b.pb9, core_hz);
        I2C2::enable(&mut rcc);
        I2C2::reset(&mut rcc);
        let port_two = Port::new(device.I2C2, gpio_b.pb10, gpio_b.pb11, core_hz);
        // The pins stay in their function when the values that name them are gone.
        let _: can1::Rx = gpio_a.pa11.into_alternate().into();
        let _: can1::Tx = gpio_a.pa12.into_alternate().into();
        let can = CanUnit::start(device.CAN1, &mut rcc);
        let boots = count_boot();
        let seed = draw_seed(&device.RNG, &mut rcc, clock, boots);
        let baud = fastest_baud(bus_hz);
        let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
        let Ok(serial) = Serial::<_, u8>::new(device.USART2, pins, baud.bps(), &mut rcc) else {
            // Not for any clock that `clocks::start` leaves; without a line there is
            // nobody to tell.
            cortex_m::peripheral::SCB::sys_reset();
        };
        Self {
            usart: serial.release().0,
            led: Led(led),
            // Time begins with the board's.
            bus_one: Master::new(port_one, timing, 0),
            bus_two: Master::new(port_two, timing, 0),
            can: Controller::new(can, BitTiming::at(bus_hz)),
            boot: Boot {
                wire_version: WIRE_VERSION,
                build_id: BUILD_ID,
                capacity: CAPACITY as u32,
                window: WINDOW,
                baud,
                clock,
                core_hz,
            },
            // 160 and above are left to hosts, whose frames stand beside a board's in
            // a recording.
            boot_id: (boots % 160) as u8,
            seed,
        }
    }
}

/// 2 Mbaud where the bus clock divides to it, as 42 MHz and 16 MHz do.
fn fastest_baud(bus_hz: u32) -> u32 {
    const FAST: u32 = 2_000_000;
    const SLOW: u32 = 115_200;
    if bus_hz >= 8 * FAST { FAST } else { SLOW }
}

/// A seed from the random number unit if it works, else from the chip's number and
/// the count of its boots.
fn draw_seed(unit: &RNG, rcc: &mut Rcc, clock: ClockSource, boots: u32) -> (u64, SeedSource) {
    match random_unit::draw(unit, rcc).as_ref().and_then(from_words) {
        Some(seed) => (seed, SeedSource::RandomUnit),
        None => {
            // Where not even the clock unit answers there is no such number either, and
            // reading it ends in a fault.
            let number = match clock {
                ClockSource::Unknown => [0; 3],
                _ => random_unit::unique_number(),
            };
            (from_unique_number(number, boots), SeedSource::UniqueNumber)
        }
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

/// Counts boots in memory that a reset leaves alone; after power-on it starts anywhere.
fn count_boot() -> u32 {
    use core::sync::atomic::{AtomicU32, Ordering};

    #[expect(
        unsafe_code,
        reason = "only a section keeps memory from the start code"
    )]
    // SAFETY: the section exists in cortex-m-rt's linker script, and every bit
    // pattern that it may hold after power-on is a valid counter.
    #[unsafe(link_section = ".uninit.BOOTS")]
    static BOOTS: AtomicU32 = AtomicU32::new(0);

    BOOTS.fetch_add(1, Ordering::Relaxed)
}
