//! The flash image in QEMU: the host's bytes, the board's clock, run after run.

use amiro_ipf::board::calibration::OffsetRefusal;
use amiro_ipf::board::can::CanState;
use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::board::health::{BusState, Health};
use amiro_ipf::board::offsets::{OffsetOrigin, Offsets};
use amiro_ipf::board::sensor_state::SensorState;
use amiro_ipf::filter::{Profile, SurvivalRule};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{Message, Status};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Event, Input, SeedSource, StepRule};
use sim_harness::device::{
    Board, Comparison, Interrupt, Pace, QemuOptions, drive, drive_streamed, measure_offsets, record,
};
use sim_harness::run;

use crate::common;

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
            if let Message::Status(status) = event {
                last = Some(*status);
            }
        },
        |_, _| (),
    )
    .unwrap();
    let tally = board.tally();
    tally.balance(tally.sent).unwrap();
    let verdict = comparison.verdict(board.boot(), &tally);
    assert!(verdict.equal, "{verdict}");
    assert_eq!(verdict.digests, outcome.steps as usize, "{verdict}");
    assert!(verdict.particles > 0, "{verdict}");
    let has_walls = config.parameters.survival == SurvivalRule::BernoulliOnWalls;
    let walls = if has_walls { verdict.steps } else { 0 };
    assert_eq!(verdict.walls_messages, walls, "{verdict}");
    last
}

#[test]
fn flash_image_gives_the_host_s_bytes_for_both_profiles_and_from_dirty_memory() {
    let Some(image) = common::image() else { return };
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
fn flash_image_tracks_the_host_s_walls() {
    let Some(image) = common::image() else { return };
    let mut board = Board::in_qemu(image, &QemuOptions::default()).unwrap();
    let config = Config {
        particles_per_sensor: 200,
        ..Config::amiro(Profile::Wall)
    };
    let mut seen = 0;
    let inputs = inputs(250);
    run(&config, &inputs, |event| {
        if let Event::Walls(walls) = event {
            seen += walls.seen.len();
        }
    })
    .unwrap();
    assert!(seen > 10, "{seen} segments in all steps together");
    assert_equal_run(&mut board, config, &inputs);
}

#[test]
fn f41_a_step_of_eight_thousand_particles_stays_below_eight_million_instructions() {
    for profile in [Profile::Paper, Profile::Plus] {
        let Some(instructions) = longest_step(profile, 150) else {
            return;
        };
        assert!(instructions > 1_000_000, "{profile:?}: nothing was counted");
        assert!(instructions <= 8_000_000, "{profile:?}: {instructions}");
    }
}

#[test]
fn a_step_with_walls_needs_at_most_two_fifths_more_instructions() {
    // 160 mm along a wall, which is found on the way.
    let longest = [Profile::Plus, Profile::Wall].map(|profile| longest_step(profile, 250));
    let [Some(plus), Some(wall)] = longest else {
        return;
    };
    assert!(wall <= plus * 7 / 5, "{wall} and {plus}");
}

/// Instructions of the longest step of 8000 particles, which gives the host's bytes.
fn longest_step(profile: Profile, samples: u64) -> Option<u64> {
    let image = common::image()?;
    let options = QemuOptions {
        count_instructions: true,
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    let inputs = inputs(samples);
    let status = assert_equal_run(&mut board, Config::amiro(profile), &inputs).unwrap();
    // At one instruction a nanosecond, 168 cycles are 1000 instructions.
    Some(u64::from(status.board.step_cycles_max) * 1000 / 168)
}

#[test]
fn with_a_status_per_step_every_step_is_measured() {
    let Some(image) = common::image() else { return };
    let options = QemuOptions {
        count_instructions: true,
        skip_idle: true,
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    board.greet().unwrap();
    let mut all = vec![Input::Configure(Config {
        particles_per_sensor: 50,
        ..Config::amiro(Profile::Plus)
    })];
    all.extend(inputs(150));
    let mut done = 0;
    let mut measured = Vec::new();
    let on_message = |message: &Message| match message {
        Message::Event(Event::StepDone(_)) => done += 1,
        Message::Status(status) if status.node.steps > 0 => measured.push(status.node.steps),
        _ => {}
    };
    let pace = Pace::StatusPerStep;
    drive_streamed(&mut board, pace, all, on_message, |_, _| (), None).unwrap();
    measured.dedup();
    assert!(done > 5, "{done} steps");
    assert_eq!(measured, (1..=done).collect::<Vec<u32>>());
}

#[test]
fn own_clock_steps_eighty_times_in_ten_seconds_and_skips_none() {
    let Some(image) = common::image() else { return };
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
        let Message::Status(status) = board.next_message().unwrap() else {
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
    let Some(image) = common::image() else { return };
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
    let Some(image) = common::image() else { return };
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
    let Some(image) = common::image() else { return };
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

/// A board as it comes up by itself, up to two seconds of its own time: its statuses
/// and, between them, its healths.
fn two_seconds_alone(board: &mut Board) -> (Vec<Status>, Vec<(u64, Health)>) {
    let (mut statuses, mut healths) = (Vec::<Status>::new(), Vec::new());
    loop {
        match board.next_message().unwrap() {
            Message::Status(status) => {
                let end_ms = statuses
                    .first()
                    .map_or(u64::MAX, |first| first.board.uptime_ms + 2_000);
                statuses.push(status);
                if status.board.uptime_ms >= end_ms {
                    return (statuses, healths);
                }
            }
            Message::Health(health) => {
                let since_ms = statuses.last().map_or(0, |last| last.board.uptime_ms);
                healths.push((since_ms, health));
            }
            message => assert!(
                !matches!(message, Message::Event(Event::StepBegun(_))),
                "{message:?}"
            ),
        }
    }
}

#[test]
fn f22_without_buses_sensors_and_random_unit_each_is_named_within_a_second() {
    let Some(image) = common::image() else { return };
    let options = QemuOptions {
        count_instructions: true,
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    let (statuses, healths) = two_seconds_alone(&mut board);
    // The first status says that the line is up, within 300 ms.
    assert!(statuses[0].board.uptime_ms <= 300, "{:?}", statuses[0]);
    // Eight statuses a second, none late by more than a millisecond: nothing that waits
    // for a bus keeps them.
    for pair in statuses.windows(2) {
        let gap_ms = pair[1].board.uptime_ms - pair[0].board.uptime_ms;
        assert!((124..=126).contains(&gap_ms), "{pair:?}");
    }
    let (_, named) = healths
        .iter()
        .take_while(|(since_ms, _)| *since_ms < 1_000)
        .last()
        .unwrap();
    for sensor in named.sensors {
        assert_eq!(sensor.state, SensorState::Missing, "{named:?}");
    }
    for bus in named.buses {
        assert_eq!(bus.state, BusState::HeldLow, "{named:?}");
        assert!(bus.recoveries > 0, "{named:?}");
    }
    assert_eq!(named.can.state, CanState::Absent);
    assert_eq!(named.seed, SeedSource::UniqueNumber);
    assert_eq!(named.offsets, OffsetOrigin::Defaults);
    let (_, last) = healths.last().unwrap();
    assert_eq!(last.can.state, CanState::Absent, "{last:?}");
    // And the board still takes a host's readings.
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Paper)
    };
    board.greet().unwrap();
    assert_equal_run(&mut board, config, &inputs(50));
}

/// Not a test: the process that the next test interrupts, when it says so.
#[test]
#[ignore = "the other half of an_interrupted_recording"]
fn recording_process() {
    let (Some(out), Some(image)) = (std::env::var_os("IPF_OUT"), common::image()) else {
        return;
    };
    let interrupt = Interrupt::on_signals().unwrap();
    let board = Board::in_qemu(image, &QemuOptions::default()).unwrap();
    let mut board = board.ended_by(interrupt);
    board.greet().unwrap();
    let open = |_| std::fs::File::create(&out);
    record(&mut board, &Config::default(), open, |_| true).unwrap();
}

#[cfg(unix)]
#[test]
fn an_interrupted_recording_leaves_neither_the_emulator_nor_its_files() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    if common::image().is_none() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("ipf-emulator-{}.d", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for signal in ["-INT", "-TERM"] {
        let out = folder.join("drive.ipf");
        // Interrupts are ignored at first, as in the background of a script.
        let script = "trap '' INT; exec \"$0\" --exact qemu::recording_process --ignored";
        let mut child = Command::new("sh")
            .args(["-c", script])
            .arg(std::env::current_exe().unwrap())
            .env("IPF_OUT", &out)
            .env("TMPDIR", &folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while std::fs::metadata(&out).map_or(0, |file| file.len()) < 500 {
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "nothing recorded"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        let id = child.id().to_string();
        assert!(
            Command::new("kill")
                .args([signal, &id])
                .status()
                .unwrap()
                .success()
        );
        let status = child.wait().unwrap();
        assert!(status.success(), "{signal}: {status}");
        let recording = sim_harness::log::read(&out).unwrap();
        assert!(recording.refusals.is_empty(), "{}", recording.refusals);
        std::fs::remove_file(out).unwrap();
        let left: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
        assert!(left.is_empty(), "{signal}: {left:?}");
        // The emulator's arguments name its file in the folder.
        let Ok(processes) = Command::new("ps").args(["-eo", "args"]).output() else {
            continue;
        };
        let processes = String::from_utf8_lossy(&processes.stdout).into_owned();
        let place = folder.to_str().unwrap();
        let emulator = processes.lines().find(|line| line.contains(place));
        assert_eq!(emulator, None, "{signal}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
