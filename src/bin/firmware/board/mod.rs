//! The board: clocks, pins, units. Nobody else names a register or a pin but the line.

mod can_unit;
mod clocks;
mod entry;
mod faults;
mod i2c_port;
mod image;
mod last_words;
mod loader;
mod random_unit;
mod robot_lines;
mod stack;

use amiro_ipf::BUILD_ID;
use amiro_ipf::link::{Boot, ClockSource, WINDOW, WIRE_VERSION};
use amiro_ipf::node::SeedSource;
use amiro_ipf::node::seed::{from_unique_number, from_words};
use amiro_ipf::supervision::{ImageCheck, Mode, PostMortem, ResetCause, Supervision};
use stm32f4xx_hal::gpio::alt::can1;
use stm32f4xx_hal::gpio::{OpenDrain, Output, PB12, PinState};
use stm32f4xx_hal::pac::{I2C1, I2C2, PWR, Peripherals, RNG, USART1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::serial::Serial;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use crate::clock::Mono;
use amiro_ipf::board::budget::CAPACITY;
use amiro_ipf::board::can::{BitTiming, Controller};
use amiro_ipf::board::i2c::{Master, Timing};
use can_unit::CanUnit;
use i2c_port::Port;

pub(crate) use last_words::{keep, live_on, record_of};
pub(crate) use loader::Loader;
pub(crate) use robot_lines::{ShutdownLine, StartLine};
pub(crate) use stack::{repaint as repaint_stack, unused as unused_stack};

/// How long the tasks may leave the watchdog alone, milliseconds: 340 to 941 with an
/// oscillator of 47 to 17 kHz.
const WATCHDOG_MS: u32 = 500;

/// What the boot loader is told to do after a reset: start again.
const RESTART: u32 = 4;

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
    /// What the robot's senses need.
    pub(crate) senses: SenseUnits,
    /// What the board says first.
    pub(crate) introduction: Introduction,
    /// Bites when the tasks no longer run. Not started yet.
    pub(crate) watchdog: Watchdog,
    /// Held low until everything is up.
    pub(crate) start_line: StartLine,
    /// The programming port, where a boot loader started the image.
    pub(crate) programming_port: Option<USART1>,
}

/// The units and lines behind the robot's senses.
pub(crate) struct SenseUnits {
    /// The first bus, freed if it could be.
    pub(crate) one: BusOne,
    /// The second bus, freed if it could be.
    pub(crate) two: BusTwo,
    /// The robot's bus, not asked yet.
    pub(crate) can: Can,
    /// What the board's seed was made of.
    pub(crate) seed: SeedSource,
    /// Who wants the robot off pulls it.
    pub(crate) shutdown_line: ShutdownLine,
}

/// What a board says of itself after its start.
pub(crate) struct Introduction {
    /// Who it is.
    pub(crate) boot: Boot,
    /// Differs from boot to boot.
    pub(crate) boot_id: u8,
    /// A seed of its own.
    pub(crate) seed: u64,
    /// How the last life ended, if it ended by itself.
    pub(crate) post_mortem: Option<PostMortem>,
    /// How this one has begun.
    pub(crate) supervision: Supervision,
    /// The boot loader, where there is one.
    pub(crate) loader: Option<Loader>,
}

impl Board {
    /// Starts clocks, pins, buses and line. Every wait is bounded.
    pub(crate) fn start(device: Peripherals, mut core: cortex_m::Peripherals) -> Self {
        stack::protect(&mut core.MPU, &mut core.SCB);
        let reset = ResetCause::of_flags(device.RCC.csr().read().bits());
        device.RCC.csr().modify(|_, w| w.rmvf().set_bit());
        let (mut rcc, clock) = clocks::start(device.RCC);
        let core_hz = match clock {
            // The clock unit says nothing about the core's speed: assume the nominal
            // one, which is what emulators run their timers at.
            ClockSource::Unknown => clocks::CORE_HZ,
            _ => rcc.clocks.hclk().raw(),
        };
        Mono::start(core.SYST, core_hz);
        // Power of the whole stack: regulators, system power, no warm reset. A pin
        // left floating here switches the robot off, so each is driven as soon as its
        // port is out of reset.
        let gpio_a = device.GPIOA.split(&mut rcc);
        gpio_a.pa8.into_push_pull_output_in_state(PinState::High);
        let gpio_b = device.GPIOB.split(&mut rcc);
        gpio_b.pb2.into_push_pull_output_in_state(PinState::High);
        let gpio_c = device.GPIOC.split(&mut rcc);
        gpio_c.pc14.into_open_drain_output_in_state(PinState::High);
        let start_line = StartLine(gpio_c.pc12.into_open_drain_output_in_state(PinState::Low));
        let shutdown_line = ShutdownLine::new(gpio_c.pc13.into_input());
        // From now on every reset starts the robot again, whatever the last shutdown
        // left there: after a reset a boot loader does what this register says.
        PWR::enable(&mut rcc);
        device.PWR.cr().modify(|_, w| w.dbp().set_bit());
        device
            .RTC
            .bkpr(0)
            .modify(|r, w| w.bkp().set(r.bits() & !0xff | RESTART));
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
        let boots = last_words::count_boot();
        let (seed, seed_source) = draw_seed(&device.RNG, &mut rcc, clock, boots);
        let baud = fastest_baud(bus_hz);
        let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
        let Ok(serial) = Serial::<_, u8>::new(device.USART2, pins, baud.bps(), &mut rcc) else {
            // Not for any clock that `clocks::start` leaves; without a line there is
            // nobody to tell.
            cortex_m::peripheral::SCB::sys_reset();
        };
        let loader = Loader::find();
        let programming_port = loader.and_then(|_| {
            let pins = (gpio_a.pa9.into_alternate(), gpio_a.pa10.into_alternate());
            let serial = Serial::<_, u8>::new(device.USART1, pins, 115_200.bps(), &mut rcc);
            let port = serial.ok()?.release().0;
            port.cr1().modify(|_, w| w.rxneie().set_bit());
            Some(port)
        });
        let (post_mortem, is_loop) =
            last_words::begin(reset == ResetCause::Watchdog, reset.may_be_death());
        let image = image::check();
        let supervision = Supervision {
            mode: match image {
                ImageCheck::Damaged => Mode::SafeForImage,
                _ if is_loop => Mode::SafeAfterDeaths,
                _ => Mode::Normal,
            },
            reset,
            image,
            is_under_loader: loader.is_some(),
            stack_unused: 0,
        };
        let boot = Boot {
            wire_version: WIRE_VERSION,
            build_id: BUILD_ID,
            capacity: CAPACITY as u32,
            window: WINDOW,
            baud,
            clock,
            core_hz,
        };
        Self {
            usart: serial.release().0,
            led: Led(led),
            senses: SenseUnits {
                // Time begins with the board's.
                one: Master::new(port_one, timing, 0),
                two: Master::new(port_two, timing, 0),
                can: Controller::new(can, BitTiming::at(bus_hz)),
                seed: seed_source,
                shutdown_line,
            },
            introduction: Introduction {
                boot,
                // 160 and above are left to hosts, whose frames stand beside a board's
                // in a recording.
                boot_id: (boots % 160) as u8,
                seed,
                post_mortem,
                supervision,
                loader,
            },
            watchdog: Watchdog(IndependentWatchdog::new(device.IWDG)),
            start_line,
            programming_port,
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

/// The independent watchdog.
pub(crate) struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// Starts it; from now on it cannot be stopped.
    pub(crate) fn start(&mut self) {
        self.0.start(WATCHDOG_MS.millis());
    }

    /// Puts the bite off.
    pub(crate) fn feed(&mut self) {
        self.0.feed();
    }
}
