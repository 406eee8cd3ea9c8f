//! The flash image in QEMU: the host's bytes, the board's clock, run after run.

mod common;

use std::process::Command;
use std::sync::OnceLock;

use amiro_ipf::config::{Config, StepRule};
use amiro_ipf::driver::{OffsetRefusal, Offsets};
use amiro_ipf::event::{ClockSource, Event, Status};
use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::input::Input;
use amiro_ipf::sensor::Sample;
use sim_harness::link::{
    Board, Comparison, Image, Layout, QemuOptions, build_image, drive, measure_offsets,
};
use sim_harness::run;

/// The image, built once; `None`, said in one line, where it cannot be built or run.
fn image() -> Option<&'static Image> {
    static IMAGE: OnceLock<Option<Image>> = OnceLock::new();
    IMAGE
        .get_or_init(|| {
            if !Board::is_qemu_installed() {
                common::skip("no QEMU (qemu-system-arm)");
                return None;
            }
            if !is_target_installed() {
                common::skip("no standard library for thumbv7em-none-eabihf");
                return None;
            }
            let path = build_image(Layout::Bare).unwrap();
            Some(Image::read(&path).unwrap())
        })
        .as_ref()
}

fn is_target_installed() -> bool {
    Command::new("rustc")
        .args([
            "--print",
            "target-libdir",
            "--target",
            "thumbv7em-none-eabihf",
        ])
        .output()
        .is_ok_and(|output| {
            let folder = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            std::path::Path::new(&folder).is_dir()
        })
}

/// A wall on the left, driven along at 80 mm/s with the sensors at 125 Hz.
fn inputs(samples: u64) -> Vec<Input> {
    (0..samples)
        .flat_map(|row| {
            let stamp_us = row * 8_000;
            let pose = Pose::new(row as f32 * 0.64e-3, 0.0, 0.0);
            let mut samples = [Sample::Counts((row % 5) as i32 - 2); 8];
            samples[1] = Sample::Counts(110 - (row % 3) as i32);
            samples[2] = Sample::Counts(100 + (row % 7) as i32);
            samples[5] = Sample::Missing;
            samples[6] = Sample::Saturated;
            [
                Input::Odometry { stamp_us, pose },
                Input::Proximity { stamp_us, samples },
            ]
        })
        .collect()
}

/// Runs inputs on a board and holds them against the host's run; the last status.
fn assert_equal_run(board: &mut Board, config: Config, inputs: &[Input]) -> Option<Status> {
    let mut comparison = Comparison::default();
    let outcome = run(&config, inputs, |event| comparison.expect(event)).unwrap();
    assert!(
        outcome.steps > 0 && outcome.faults().count() == 0,
        "{outcome:?}"
    );
    let boot = board.greet().unwrap();
    assert_eq!(boot.clock, ClockSource::Unknown, "QEMU models no clocks");
    let mut all = vec![Input::Configure(config)];
    all.extend_from_slice(inputs);
    let mut last = None;
    drive(
        board,
        &all,
        |event| {
            comparison.meet(event);
            if let Event::Status(status) = event {
                last = Some(*status);
            }
        },
        |_, _| (),
    )
    .unwrap();
    let verdict = comparison.verdict(board.boot(), board.lost_frames());
    assert!(verdict.equal, "{verdict}");
    assert_eq!(verdict.digests, outcome.steps as usize, "{verdict}");
    assert!(verdict.particles > 0, "{verdict}");
    last
}

#[test]
fn flash_image_gives_the_host_s_bytes_for_both_profiles_and_from_dirty_memory() {
    let Some(image) = image() else { return };
    for (profile, ram_fill) in [
        (Profile::Paper, None),
        (Profile::Paper, Some(0xa5)),
        (Profile::Plus, Some(0xa5)),
    ] {
        let options = QemuOptions {
            ram_fill,
            ..QemuOptions::default()
        };
        let mut board = Board::in_qemu(image, &options).unwrap();
        assert_equal_run(&mut board, Config::amiro(profile), &inputs(150));
    }
}

#[test]
fn a_step_of_eight_thousand_particles_stays_below_eight_million_instructions() {
    let Some(image) = image() else { return };
    for profile in [Profile::Paper, Profile::Plus] {
        let options = QemuOptions {
            count_instructions: true,
            ..QemuOptions::default()
        };
        let mut board = Board::in_qemu(image, &options).unwrap();
        let status = assert_equal_run(&mut board, Config::amiro(profile), &inputs(150)).unwrap();
        // At one instruction a nanosecond, 168 cycles are 1000 instructions.
        let instructions = u64::from(status.board.step_cycles_max) * 1000 / 168;
        assert!(instructions > 1_000_000, "{profile:?}: nothing was counted");
        assert!(instructions <= 8_000_000, "{profile:?}: {instructions}");
    }
}

#[test]
fn own_clock_steps_eighty_times_in_ten_seconds_and_skips_none() {
    let Some(image) = image() else { return };
    let options = QemuOptions {
        count_instructions: true,
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    board.greet().unwrap();
    let config = Config {
        step_rule: StepRule::PerTick { own_clock: true },
        ..Config::amiro(Profile::Plus)
    };
    let mut start = vec![Input::Configure(config)];
    start.extend(inputs(1));
    drive(&mut board, &start, |_| (), |_, _| ()).unwrap();
    // Ten seconds of the board's own time between two of its statuses.
    let mut first: Option<Status> = None;
    loop {
        let Event::Status(status) = board.next_event().unwrap() else {
            continue;
        };
        assert_eq!(status.board.overruns, 0, "{status:?}");
        match first {
            None => first = Some(status),
            Some(first) if status.board.uptime_ms >= first.board.uptime_ms + 10_000 => {
                assert_eq!(status.node.steps - first.node.steps, 80, "{status:?}");
                break;
            }
            Some(_) => {}
        }
    }
}

#[test]
fn a_board_without_sensors_keeps_its_offsets_and_refuses_each_measurement() {
    let Some(image) = image() else { return };
    let mut board = Board::in_qemu(image, &QemuOptions::default()).unwrap();
    board.greet().unwrap();
    let report = measure_offsets(&mut board).unwrap().unwrap();
    assert_eq!(report.offsets, Offsets::DEFAULTS);
    assert_eq!(report.refused, [Some(OffsetRefusal::NotDelivering); 8]);
    assert!(!report.is_kept);
    board.greet().unwrap();
    assert_eq!(board.offsets(), Some(&report));
}

#[test]
fn twenty_runs_in_a_row_never_hang() {
    let Some(image) = image() else { return };
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Paper)
    };
    for _ in 0..20 {
        let mut board = Board::in_qemu(image, &QemuOptions::default()).unwrap();
        assert_equal_run(&mut board, config, &inputs(50));
    }
}

#[test]
fn garbage_on_the_line_costs_only_the_frames_it_hits() {
    let Some(image) = image() else { return };
    let mut board = Board::in_qemu(image, &QemuOptions::default()).unwrap();
    board.greet().unwrap();
    let garbage: Vec<u8> = (0..5000_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    board.send_raw(&garbage).unwrap();
    board.send_raw(&[0]).unwrap();
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Plus)
    };
    assert_equal_run(&mut board, config, &inputs(100));
}
