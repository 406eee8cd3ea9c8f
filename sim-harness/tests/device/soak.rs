//! Long runs: what must hold after hours as it does after seconds.
//!
//! `IPF_SOAK_MINUTES` is how long the host's node drives (2 if not given);
//! `IPF_SOAK_QEMU_MINUTES` how long the flash image steps by its own clock in the
//! emulator, in the board's own time (none if not given).

#![expect(clippy::panic, reason = "a test that cannot go on says why")]

use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{Message, Status};
use amiro_ipf::math;
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Event, Input, Node, StepRule};
use amiro_ipf::random::{Generator, uniform_below};
use sim_harness::device::{Board, QemuOptions, drive};

use crate::common;

/// Particles in all: 100 a sensor.
const N: usize = 800;
/// Time between two readings, and how far the robot gets: 80 mm/s.
const PERIOD_US: u64 = 8_000;
const ADVANCE_M: f32 = 0.64e-3;
/// The circle that it drives.
const RADIUS_M: f32 = 0.5;
/// A reading's place in it: so many make it whole, within 0.01 mm a reading.
const READINGS_A_LAP: u64 = 4_909;

fn minutes(variable: &str, default: f64) -> f64 {
    std::env::var(variable).map_or(default, |minutes| minutes.parse().unwrap())
}

/// Odometry and readings of a round drive past things that come and go.
fn row(index: u64, generator: &mut Generator) -> [Input; 2] {
    let stamp_us = index * PERIOD_US;
    let heading = (index % READINGS_A_LAP) as f32 * (ADVANCE_M / RADIUS_M);
    let (sine, cosine) = math::sin_cos(heading);
    let pose = Pose::new(RADIUS_M * sine, RADIUS_M * (1.0 - cosine), heading);
    let samples = core::array::from_fn(|sensor| {
        let noise = uniform_below(generator, 15) as i32 - 7;
        match uniform_below(generator, 1_000) {
            0 => Sample::Missing,
            1 => Sample::Saturated,
            _ if (index / 500 + sensor as u64).is_multiple_of(3) => Sample::Counts(110 + noise),
            _ => Sample::Counts(noise),
        }
    });
    [
        Input::Odometry { stamp_us, pose },
        Input::Proximity { stamp_us, samples },
    ]
}

/// Digest after every step of a drive, folded into one number, and the steps.
fn soak(profile: Profile, readings: u64, seed: u64) -> (u64, u32) {
    let mut particles = ParticleSet::<N>::new();
    let mut node = Node::new(&mut particles);
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(profile)
    };
    let mut folded = 0_u64;
    let mut emit = |event: &Event| {
        if let Event::StepDone(done) = event {
            folded = folded.rotate_left(7) ^ u64::from(done.digest);
        }
    };
    node.handle(&Input::Configure(config), &mut emit).unwrap();
    let mut generator = Generator::seeded(seed);
    for index in 0..readings {
        for input in row(index, &mut generator) {
            node.handle(&input, &mut emit)
                .unwrap_or_else(|fault| panic!("{profile:?}, reading {index}: {fault}"));
        }
        if index.is_multiple_of(1_000) {
            for (place, steps) in node.filter().live() {
                // Half a unit of a particle's place, and as much for rounding.
                let is_near = place.norm() <= config.parameters.local_radius_m + 2e-5;
                assert!(is_near || steps == 0, "reading {index}: {place:?}");
            }
            assert!(
                node.filter().live().count() > 0,
                "reading {index}: none live"
            );
        }
    }
    let steps = node.status().steps;
    (folded, steps)
}

#[test]
fn a_long_drive_refuses_nothing_steps_every_centimetre_and_ends_alike_twice() {
    let readings = (minutes("IPF_SOAK_MINUTES", 2.0) * 60e6 / PERIOD_US as f64) as u64;
    for (profile, seed) in [(Profile::Paper, 31), (Profile::Plus, 32)] {
        let (folded, steps) = soak(profile, readings, seed);
        let due = readings as f64 * f64::from(ADVANCE_M) / 0.01;
        // The end of a lap is a reading that is up to 0.6 mm off.
        assert!(
            (f64::from(steps) - due).abs() <= 2.0 + due * 1e-3,
            "seed {seed}: {steps} steps, {due:.0} are due"
        );
        assert_eq!(soak(profile, readings, seed), (folded, steps), "{seed}");
    }
}

#[test]
fn f41_own_steps_are_never_late_and_statuses_come_on_time_for_as_long_as_it_runs() {
    let minutes = minutes("IPF_SOAK_QEMU_MINUTES", 0.0);
    if minutes == 0.0 {
        common::report_skipped("IPF_SOAK_QEMU_MINUTES is not set");
        return;
    }
    let Some(image) = common::image() else { return };
    let options = QemuOptions {
        count_instructions: true,
        skip_idle: true,
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    board.greet().unwrap();
    let config = Config {
        particles_per_sensor: 100,
        step_rule: StepRule::PerTick { own_clock: true },
        ..Config::amiro(Profile::Plus)
    };
    let mut start = vec![Input::Configure(config)];
    start.extend(row(0, &mut Generator::seeded(1)));
    drive(&mut board, &start, |_| (), |_, _| ()).unwrap();
    let span_ms = (minutes * 60e3) as u64;
    let (mut first, mut last): (Option<Status>, Option<Status>) = (None, None);
    loop {
        let Message::Status(status) = board.next_message().unwrap() else {
            continue;
        };
        let now_ms = status.board.uptime_ms;
        assert_eq!(status.board.overruns, 0, "{status:?}");
        if let Some(last) = last {
            let gap_ms = now_ms - last.board.uptime_ms;
            assert!((124..=126).contains(&gap_ms), "{gap_ms} ms: {status:?}");
        }
        last = Some(status);
        let first = *first.get_or_insert(status);
        if now_ms >= first.board.uptime_ms + span_ms {
            let steps = u64::from(status.node.steps - first.node.steps);
            let due = (now_ms - first.board.uptime_ms) / 125;
            assert!(steps.abs_diff(due) <= 1, "{steps} steps, {due} are due");
            return;
        }
    }
}
