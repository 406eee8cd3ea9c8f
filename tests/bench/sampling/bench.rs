//! The calls, counted.

use core::fmt::Write;
use core::hint::black_box;
use core::panic::PanicInfo;

use amiro_ipf::driver::Bus;
use amiro_ipf::node::{Input, SeedSource};
use cortex_m::peripheral::{SCB, SYST};
use rtic_monotonics::systick::prelude::*;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::Serial;

use crate::board::{
    CORE_HZ, CanCells, CanUnit, I2cCells, SenseUnits, masters, shutdown_line, start_clocks,
};
use crate::clock::{Microseconds, Mono};
use crate::parts::{Next, Parts, answer_mode, put_frame};
use crate::sampler::{Report, Reports, Sampler};
use amiro_ipf::board::can::{BitTiming, Controller};

/// Rounds of the sensors that are counted.
const ROUNDS: u32 = 1_000;

/// Patrols before that: the sensors are configured and earn trust.
const SETTLING: u32 = 1_000;

/// Patrols between two frames of the same kind from the wheels' board: 63 ms.
const FRAMES_EVERY: u32 = 126;

/// Patrols between two steps of what the sensors see: 0.8 s.
const STEP_EVERY: u32 = 1_600;

static ONE: I2cCells = I2cCells::new();
static TWO: I2cCells = I2cCells::new();
static CAN: CanCells = CanCells::new();

/// Calls of one kind.
#[derive(Clone, Copy, Default)]
struct Tally {
    calls: u32,
    counts: u64,
}

impl Tally {
    /// Counts a call, on a timer that counts down from one less than `period`.
    fn count(&mut self, period: u32, call: impl FnOnce()) {
        let before = SYST::get_current();
        call();
        let after = SYST::get_current();
        let counts = (before + period - after) % period;
        self.calls += 1;
        self.counts += u64::from(counts);
    }
}

#[derive(Clone, Copy, Default)]
struct Tallies {
    /// Calls of nothing: what counting costs.
    nothing: Tally,
    event: Tally,
    useless: Tally,
    patrol: Tally,
    frame: Tally,
    clock: Tally,
}

#[inline(never)]
fn on_event(sampler: &mut Sampler, bus: Bus) {
    sampler.on_event(bus);
}

#[inline(never)]
fn patrol(sampler: &mut Sampler) {
    sampler.patrol();
}

#[inline(never)]
fn on_frames(sampler: &mut Sampler) {
    sampler.on_frames();
}

#[inline(never)]
fn nothing(sampler: &mut Sampler) {
    black_box(sampler);
}

#[inline(never)]
fn look_at(clock: Microseconds) {
    black_box(clock.now());
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut REPORTS: Reports = Reports::new();
    let (Some(device), Some(core)) = (Peripherals::take(), cortex_m::Peripherals::take()) else {
        SCB::sys_reset();
    };
    let mut rcc = start_clocks(device.RCC);
    let gpio_a = device.GPIOA.split(&mut rcc);
    let gpio_c = device.GPIOC.split(&mut rcc);
    let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
    let Ok(mut line) = Serial::<_, u8>::new(device.USART2, pins, 115_200.bps(), &mut rcc) else {
        SCB::sys_reset();
    };
    let period = CORE_HZ / 2_000;
    Mono::start(core.SYST, CORE_HZ);

    let (one, two) = masters(&ONE, &TWO, 42_000_000);
    let units = SenseUnits {
        one,
        two,
        can: Controller::new(CanUnit(&CAN), Some(BitTiming::AT_42_MHZ)),
        seed: SeedSource::UniqueNumber,
        shutdown_line: shutdown_line(gpio_c.pc13.into_input()),
    };
    let (report, mut reported) = REPORTS.split();
    let clock = Microseconds::new(CORE_HZ);
    let mut sampler = Sampler::new(units, clock, report);
    let mut parts = [(Bus::I2c1, Parts::new(&ONE)), (Bus::I2c2, Parts::new(&TWO))];

    let mut tallies = Tallies::default();
    let (mut patrols, mut rounds, mut delivered) = (0_u32, 0_u32, 0_u32);
    let mut tick = Mono::now().as_ticks();
    while rounds < ROUNDS {
        // All that a tick brings is over long before the next one: no call is cut by it.
        while Mono::now().as_ticks() == tick {
            cortex_m::asm::wfi();
        }
        tick = Mono::now().as_ticks();
        patrols += 1;
        if patrols == SETTLING {
            (tallies, rounds, delivered) = (Tallies::default(), 0, 0);
        }
        tallies.nothing.count(period, || nothing(&mut sampler));
        tallies.clock.count(period, || look_at(clock));
        answer_mode(&CAN);
        let frame = match patrols % FRAMES_EVERY {
            // 0x50: x one step of 256 um further each time. 0x20: 80 mm a second.
            5 => Some((0x50, u64::from(patrols / FRAMES_EVERY))),
            67 => Some((0x20, 80_000)),
            _ => None,
        };
        if let Some((device, payload)) = frame {
            put_frame(&CAN, device, payload);
            tallies.frame.count(period, || on_frames(&mut sampler));
        }
        tallies.patrol.count(period, || patrol(&mut sampler));
        // A wall that comes and goes: teeth are garbage, and what never changes is stuck.
        let distance = if (patrols / STEP_EVERY).is_multiple_of(2) {
            0x0a
        } else {
            0x0b
        };
        let mut is_quiet = false;
        while !is_quiet {
            is_quiet = true;
            for (bus, parts) in &mut parts {
                let tally = match parts.go_on(distance) {
                    Next::Nothing => continue,
                    Next::Event => &mut tallies.event,
                    Next::Useless => &mut tallies.useless,
                };
                is_quiet = false;
                tally.count(period, || on_event(&mut sampler, *bus));
            }
        }
        while let Some(report) = reported.dequeue() {
            if let Report::Input(Input::Proximity { samples, .. }) = report {
                rounds += 1;
                delivered += samples
                    .iter()
                    .filter(|sample| matches!(sample, amiro_ipf::model::Sample::Counts(_)))
                    .count() as u32;
            }
        }
    }
    let rows = [
        ("nothing", tallies.nothing),
        ("clock", tallies.clock),
        ("event", tallies.event),
        ("useless", tallies.useless),
        ("patrol", tallies.patrol),
        ("frame", tallies.frame),
    ];
    for (name, tally) in rows {
        // Nobody else could be told that the line is gone.
        let _ = writeln!(line, "{name} {} {}", tally.calls, tally.counts);
    }
    let _ = writeln!(line, "rounds {rounds} {delivered}");
    let _ = line.flush();
    SCB::sys_reset()
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
