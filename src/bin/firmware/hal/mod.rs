//! Clocks, pins and units of the chip. Besides this folder only `link.rs` names registers.

mod can_unit;
mod clocks;
mod entry;
mod faults;
mod i2c_port;
mod image;
mod loader;
mod random_unit;
mod retained_ram;
mod robot_lines;
mod stack;

use amiro_ipf::BUILD_ID;
use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::board::supervision::{ImageCheck, Mode, PostMortem, ResetCause, Supervision};
use amiro_ipf::link::{Boot, WINDOW, WIRE_VERSION};
use amiro_ipf::node::SeedSource;
use amiro_ipf::node::seed::{from_unique_number, from_words};
use stm32f4xx_hal::gpio::alt::can1;
use stm32f4xx_hal::gpio::{Alternate, OpenDrain, Output, PA9, PA10, PB12, PinState};
use stm32f4xx_hal::pac::{I2C1, I2C2, PWR, Peripherals, RNG, RTC, USART1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::serial::Serial;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use crate::clock::Mono;
use amiro_ipf::board::budget::CAPACITY;
use amiro_ipf::board::can::{BitTiming, CanController};
use amiro_ipf::board::i2c::{I2cMaster, I2cTiming};
use can_unit::CanUnit;
use i2c_port::Port;

pub(crate) use loader::Loader;
pub(crate) use retained_ram::{keep, record_of, record_uptime};
pub(crate) use robot_lines::{ShutdownLine, StartLine};
pub(crate) use stack::{repaint as repaint_stack, unused as unused_stack};

/// Watchdog period, milliseconds: 340 to 941 with an oscillator of 47 to 17 kHz.
const WATCHDOG_MS: u32 = 500;

/// Backup register value that makes the boot loader start the image after a reset.
const RESTART: u32 = 4;

/// The master of a sensor bus.
pub(crate) type BusMaster = I2cMaster<Port>;

/// The robot's CAN bus.
pub(crate) type Can = CanController<CanUnit>;

/// The board after its start.
pub(crate) struct StartedBoard {
    /// The serial line, running.
    pub(crate) usart: USART2,
    /// The heartbeat's LED.
    pub(crate) led: Led,
    /// What the acquisition needs.
    pub(crate) acquisition: AcquisitionUnits,
    /// What the board reports first.
    pub(crate) boot_info: BootInfo,
    /// Resets the chip when the tasks no longer run. Not started yet.
    pub(crate) watchdog: Watchdog,
    /// Held low until everything is up.
    pub(crate) start_line: StartLine,
    /// The programming port, where a boot loader started the image.
    pub(crate) programming_port: Option<USART1>,
}

/// The units and lines of the acquisition.
pub(crate) struct AcquisitionUnits {
    /// The bus of sensors 0, 1, 2 and 7, freed if possible: SCL on PB8, SDA on PB9.
    pub(crate) one: BusMaster,
    /// The bus of sensors 3 to 6 and of the EEPROM, freed if possible: SCL on PB10, SDA
    /// on PB11.
    pub(crate) two: BusMaster,
    /// The CAN controller, before its first poll.
    pub(crate) can: Can,
    /// The source of the board's seed.
    pub(crate) seed: SeedSource,
    /// Pulled low to request a shutdown.
    pub(crate) shutdown_line: ShutdownLine,
}

/// What a board reports after its start.
pub(crate) struct BootInfo {
    /// The boot message.
    pub(crate) boot: Boot,
    /// Differs from boot to boot.
    pub(crate) boot_id: u8,
    /// The board's own seed.
    pub(crate) seed: u64,
    /// How the last boot failed, if it did.
    pub(crate) post_mortem: Option<PostMortem>,
    /// The first supervision message.
    pub(crate) supervision: Supervision,
    /// The boot loader, where there is one.
    pub(crate) loader: Option<Loader>,
}

impl StartedBoard {
    /// Starts clocks, pins, buses and the serial line. Every wait is bounded.
    pub(crate) fn start(device: Peripherals, mut core: cortex_m::Peripherals) -> Self {
        stack::protect(&mut core.MPU, &mut core.SCB);
        let reset = ResetCause::of_flags(device.RCC.csr().read().bits());
        device.RCC.csr().modify(|_, w| w.rmvf().set_bit());
        let (mut rcc, clock) = clocks::start(device.RCC);
        let core_hz = core_hz(&rcc, clock);
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
        restart_after_resets(&device.PWR, &device.RTC, &mut rcc);
        let led = Led(gpio_b.pb12.into_open_drain_output_in_state(PinState::High));
        let bus_hz = rcc.clocks.pclk1().raw();
        let timing = I2cTiming::fast(bus_hz);
        enable_buses(&mut rcc);
        let port_one = Port::one(device.I2C1, gpio_b.pb8, gpio_b.pb9, core_hz);
        let port_two = Port::two(device.I2C2, gpio_b.pb10, gpio_b.pb11, core_hz);
        // The pins stay in their function when the values that name them are gone.
        let _: can1::Rx = gpio_a.pa11.into_alternate().into();
        let _: can1::Tx = gpio_a.pa12.into_alternate().into();
        let can = CanUnit::start(device.CAN1, &mut rcc);
        let boots = retained_ram::count_boot();
        let (seed, seed_source) = draw_seed(&device.RNG, &mut rcc, clock, boots);
        let baud = fastest_baud(bus_hz);
        let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
        let Ok(serial) = Serial::<_, u8>::new(device.USART2, pins, baud.bps(), &mut rcc) else {
            // Not for any clock that `clocks::start` leaves; without a line nothing can
            // be reported.
            cortex_m::peripheral::SCB::sys_reset();
        };
        let loader = Loader::find();
        let pins = (gpio_a.pa9.into_alternate(), gpio_a.pa10.into_alternate());
        let programming_port =
            loader.and_then(|_| start_programming_port(device.USART1, pins, &mut rcc));
        Self {
            usart: serial.release().0,
            led,
            boot_info: BootInfo::new((clock, core_hz, baud), boots, seed, reset, loader),
            acquisition: AcquisitionUnits {
                // Time begins with the board's.
                one: I2cMaster::new(port_one, timing, 0),
                two: I2cMaster::new(port_two, timing, 0),
                can: CanController::new(can, BitTiming::at(bus_hz)),
                seed: seed_source,
                shutdown_line,
            },
            watchdog: Watchdog(IndependentWatchdog::new(device.IWDG)),
            start_line,
            programming_port,
        }
    }
}

/// Clocks both I2C units and resets them.
fn enable_buses(rcc: &mut Rcc) {
    I2C1::enable(rcc);
    I2C1::reset(rcc);
    I2C2::enable(rcc);
    I2C2::reset(rcc);
}

impl BootInfo {
    fn new(
        (clock, core_hz, baud): (ClockSource, u32, u32),
        boots: u32,
        seed: u64,
        reset: ResetCause,
        loader: Option<Loader>,
    ) -> Self {
        let was_watchdog = reset == ResetCause::Watchdog;
        let (post_mortem, is_loop) = retained_ram::begin(was_watchdog, reset.may_be_failure());
        let image = image::check();
        Self {
            boot: Boot {
                wire_version: WIRE_VERSION,
                build_id: BUILD_ID,
                capacity: CAPACITY as u32,
                window: WINDOW,
                baud,
                clock,
                core_hz,
            },
            // 160 and above are left to hosts, whose frames stand beside a board's in a
            // recording.
            boot_id: (boots % 160) as u8,
            seed,
            post_mortem,
            supervision: Supervision {
                mode: match image {
                    ImageCheck::Damaged => Mode::SafeForImage,
                    _ if is_loop => Mode::SafeAfterDeaths,
                    _ => Mode::Normal,
                },
                reset,
                image,
                is_under_loader: loader.is_some(),
                stack_unused: 0,
            },
            loader,
        }
    }
}

/// The core's frequency, hertz, on this clock.
fn core_hz(rcc: &Rcc, source: ClockSource) -> u32 {
    match source {
        // The clock unit does not answer: assume the nominal frequency, at which
        // emulators run their timers.
        ClockSource::Unknown => clocks::CORE_HZ,
        _ => rcc.clocks.hclk().raw(),
    }
}

/// Makes every later reset start the robot again: after a reset the boot loader acts on
/// this register, which a shutdown may have changed.
fn restart_after_resets(power: &PWR, clock: &RTC, rcc: &mut Rcc) {
    PWR::enable(rcc);
    power.cr().modify(|_, w| w.dbp().set_bit());
    clock
        .bkpr(0)
        .modify(|r, w| w.bkp().set(r.bits() & !0xff | RESTART));
}

/// Starts the programming port with its receive interrupt.
fn start_programming_port(
    usart: USART1,
    pins: (PA9<Alternate<7>>, PA10<Alternate<7>>),
    rcc: &mut Rcc,
) -> Option<USART1> {
    let serial = Serial::<_, u8>::new(usart, pins, 115_200.bps(), rcc).ok()?;
    let port = serial.release().0;
    port.cr1().modify(|_, w| w.rxneie().set_bit());
    Some(port)
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
            // Where the clock unit does not answer there is no such number either, and
            // reading it faults.
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
    /// Switches it on or off.
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

    /// Restarts its period.
    pub(crate) fn feed(&mut self) {
        self.0.feed();
    }
}
