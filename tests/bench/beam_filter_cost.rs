//! What a cycle of the beam filter costs the core: 32 beams over 200, 500 and 1000 particles.
//!
//! A robot drives a lap of 1 m radius around a pillar in a room, with four sensors of eight
//! columns. Every cycle is counted in two parts: the motion (`advance`), and resampling and
//! weighing (`cycle` at rest). Together they are one `cycle`: the particles are the same.
//! The beams are made between the counted parts.
//!
//! The counter is the core's own timer, SysTick. In QEMU with `-icount shift=0` the core
//! executes one instruction per nanosecond and the timer counts at 168 MHz, so 168 counts
//! are 1000 instructions: a count of an emulator, not of silicon. On a board the counts are
//! cycles. Per form and number of particles, one line on USART2 with the instructions of an
//! average cycle, then a reset:
//!
//! ```text
//! form particles motion weighing per-beam-and-particle longest-cycle
//! ```
//!
//! `cargo test --test firmware beam_filter_cost` runs it. By hand, in one line:
//!
//! ```text
//! cargo run --release --target thumbv7em-none-eabihf --example beam_filter_cost --config 'target.thumbv7em-none-eabihf.runner="qemu-system-arm -M netduinoplus2 -icount shift=0,sleep=off -no-reboot -display none -monitor none -serial null -serial stdio -kernel"'
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
#[path = "../../src/bin/firmware/hal/clocks.rs"]
mod clocks;

#[cfg(target_os = "none")]
mod target {
    use core::f32::consts::{FRAC_PI_2, TAU};
    use core::fmt::Write;
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use amiro_ipf::beam_filter::{
        BeamFilterParameters, BeamModel, BeamParticleFilter, BeamRange, RangeBeam,
    };
    use amiro_ipf::geometry::{Motion, Point, Pose, Rotation};
    use amiro_ipf::math;
    use amiro_ipf::random::Generator;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m::peripheral::{SCB, SYST};
    use stm32f4xx_hal::pac::Peripherals;
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::serial::Serial;

    use crate::clocks;

    const CAPACITY: usize = 1000;
    const BEAMS: usize = 32;

    /// Cycles of a lap, 4.2 cm each: a motion in one piece. Those of the beginning are not
    /// counted: the first frames find all particles undetermined.
    const CYCLES: u16 = 150;
    const SETTLING: u16 = 20;

    /// Range of the sensors, metres.
    const MOST_M: f32 = 1.4;

    /// The corners of the room and of the pillar: least and largest x, then y; metres.
    const ROOM: [f32; 4] = [0.0, 4.0, 0.0, 3.0];
    const PILLAR: [f32; 4] = [1.8, 2.2, 1.3, 1.7];

    /// Counts of a timer of 24 bits that counts down.
    fn counted(call: impl FnOnce()) -> u32 {
        let before = SYST::get_current();
        call();
        let after = SYST::get_current();
        before.wrapping_sub(after) & 0x00ff_ffff
    }

    /// Instructions of an emulated core at one per nanosecond.
    fn instructions(counts: u64) -> u64 {
        counts * 1_000 / u64::from(clocks::CORE_HZ / 1_000_000)
    }

    /// Distance along a ray to the walls, metres.
    fn range_m(from: Point, bearing: f32) -> f32 {
        let (sine, cosine) = math::sin_cos(bearing);
        let mut nearest = f32::INFINITY;
        for [left, right, bottom, top] in [ROOM, PILLAR] {
            for x in [left, right] {
                let along = (x - from.x) / cosine;
                let y = from.y + along * sine;
                if along > 0.0 && (bottom..=top).contains(&y) {
                    nearest = nearest.min(along);
                }
            }
            for y in [bottom, top] {
                let along = (y - from.y) / sine;
                let x = from.x + along * cosine;
                if along > 0.0 && (left..=right).contains(&x) {
                    nearest = nearest.min(along);
                }
            }
        }
        nearest
    }

    /// The beam of a column: eight per sensor over 45 degrees, sensors at right angles.
    fn beam(index: usize, body: &Pose) -> Option<RangeBeam> {
        let side = (index / 8) as f32 * FRAC_PI_2;
        let column = ((index % 8) as f32 - 3.5) * (TAU / 64.0);
        let place = Point::new(0.02, 0.0).rotated(Rotation::by(side));
        let mount = Pose::new(place.x, place.y, side + column);
        let from = body.world_from_body(mount.position);
        let exact_m = range_m(from, body.heading.radians() + mount.heading.radians());
        let range = if exact_m < MOST_M {
            BeamRange::Echo(exact_m)
        } else {
            BeamRange::NoEcho(MOST_M)
        };
        RangeBeam::new(&mount, range).ok()
    }

    fn body_at(cycle: u16) -> Pose {
        let angle = f32::from(cycle) / f32::from(CYCLES) * TAU;
        let (sine, cosine) = math::sin_cos(angle);
        Pose::new(2.0 + cosine, 1.5 + sine, angle + FRAC_PI_2)
    }

    /// Counts of a lap.
    #[derive(Default)]
    struct Lap {
        cycles: u32,
        nothing: u64,
        motion: u64,
        weighing: u64,
        longest: u32,
    }

    fn lap(
        filter: &mut BeamParticleFilter<CAPACITY>,
        parameters: BeamFilterParameters,
        particles: usize,
    ) -> Option<Lap> {
        let model = BeamModel::new(parameters).ok()?;
        let mut rng = Generator::seeded(1);
        let mut body = body_at(0);
        filter.reset(&model, particles, body.heading, &mut rng);
        let mut lap = Lap::default();
        for cycle in 0..CYCLES {
            let motion = black_box(body.motion_to(&body_at(cycle)));
            body = body_at(cycle);
            let mut beams = [beam(0, &body)?; BEAMS];
            for (index, place) in beams.iter_mut().enumerate() {
                *place = beam(index, &body)?;
            }
            let nothing = counted(|| {
                black_box(&motion);
            });
            let moved = counted(|| {
                black_box(filter.advance(&model, &motion, &mut rng));
            });
            let weighed = counted(|| {
                black_box(filter.cycle(&model, &Motion::NONE, black_box(&beams), &mut rng));
            });
            if cycle < SETTLING {
                continue;
            }
            lap.cycles += 1;
            lap.nothing += u64::from(nothing);
            lap.motion += u64::from(moved);
            lap.weighing += u64::from(weighed);
            lap.longest = lap.longest.max(moved + weighed);
        }
        Some(lap)
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut FILTER: BeamParticleFilter<CAPACITY> = BeamParticleFilter::new();
        let (Some(device), Some(mut core)) = (Peripherals::take(), cortex_m::Peripherals::take())
        else {
            SCB::sys_reset();
        };
        let (mut rcc, _) = clocks::start(device.RCC);
        let gpio_a = device.GPIOA.split(&mut rcc);
        let pins = (gpio_a.pa2.into_alternate(), gpio_a.pa3.into_alternate());
        let Ok(mut line) = Serial::<_, u8>::new(device.USART2, pins, 115_200.bps(), &mut rcc)
        else {
            SCB::sys_reset();
        };
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(0x00ff_ffff);
        core.SYST.clear_current();
        core.SYST.enable_counter();

        for (name, form) in [
            ("paper", BeamFilterParameters::PAPER.for_frames()),
            ("moving", BeamFilterParameters::MOVING.for_frames()),
        ] {
            for particles in [200, 500, CAPACITY] {
                let Some(lap) = lap(FILTER, form, particles) else {
                    SCB::sys_reset();
                };
                let each = |counts: u64| {
                    instructions(counts.saturating_sub(lap.nothing)) / u64::from(lap.cycles)
                };
                let (motion, weighing) = (each(lap.motion), each(lap.weighing));
                let pairs = (BEAMS * particles) as u64;
                let hundredths = 100 * (motion + weighing) / pairs;
                let longest = instructions(u64::from(lap.longest));
                // Without the line there is no other place to report to.
                let _ = writeln!(
                    line,
                    "{name} {particles} {motion} {weighing} {}.{:02} {longest}",
                    hundredths / 100,
                    hundredths % 100
                );
            }
        }
        let _ = line.flush();
        SCB::sys_reset()
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        SCB::sys_reset()
    }
}
