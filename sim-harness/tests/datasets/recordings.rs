//! Recordings through the public door: whatever a file holds, the good rows are used.
//!
//! Names that begin with f32 and f80 to f86 are entries of the fault catalogue: units, log
//! files.

use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use amiro_ipf::board::health::Health;
use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::{Point, Pose};
use amiro_ipf::link::{
    BoardStatus, DeviceEndpoint, Encoder, FrameError, MAX_FRAME, Message, MessageRef, TruthMessage,
};
use amiro_ipf::model::{Sample, WheelSpeeds};
use amiro_ipf::node::{Config, Event, Input, Node, SampleSelection, Source, StepRule};
use proptest::prelude::*;
use sim_harness::device::{Comparison, boot_on_host};
use sim_harness::log::{
    Format, LogError, Place, Problem, Reason, Recording, RecordingWriter, read, read_from,
};

use crate::common;

const HEADER: &str = "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\t\
                      X [ym]\tY [ym]\tTheta [yrad]\n";

/// Row `index` of a straight drive: 8 mm a row, which are 100 ms.
fn row(index: i64) -> String {
    let x = 100_000 + 8_000 * index;
    format!("0\t110\t108\t0\t0\t3\t{index}\t0\t{x}\t-1280\t6282240\n")
}

fn text_of(rows: i64) -> String {
    HEADER.to_owned() + &(0..rows).map(row).collect::<String>()
}

/// A file in which `middle` stands between two good rows.
fn between_good_rows(middle: &[u8]) -> Vec<u8> {
    [
        HEADER.as_bytes(),
        row(0).as_bytes(),
        middle,
        row(1).as_bytes(),
    ]
    .concat()
}

/// Bytes, read as a recording.
fn reading(bytes: impl AsRef<[u8]>) -> Result<Recording, LogError> {
    read_from(bytes.as_ref())
}

/// That only line 3 is refused, for the given reason, and the rows around it are used.
fn assert_third_line_is_refused(middle: &[u8], reason: Reason) -> String {
    let shown = String::from_utf8_lossy(middle).into_owned();
    let recording = reading(between_good_rows(middle)).unwrap();
    assert_eq!(recording.inputs.len(), 4, "{shown:?}");
    assert_eq!(recording.refusals.count(), 1, "{shown:?}");
    let refusal = &recording.refusals.first()[0];
    assert_eq!(
        (refusal.place, refusal.reason),
        (Place::Line(3), reason),
        "{shown:?}"
    );
    refusal.to_string()
}

fn tick(stamp_us: u64) -> Input {
    Input::Tick { stamp_us }
}

fn odometry(stamp_us: u64, x: f32) -> Input {
    let pose = Pose::new(x, 0.0, 0.0);
    Input::Odometry { stamp_us, pose }
}

fn proximity(stamp_us: u64) -> Input {
    let mut samples = [Sample::Counts(-3); 8];
    samples[1] = Sample::Saturated;
    samples[2] = Sample::Missing;
    Input::Proximity { stamp_us, samples }
}

fn stream_of(inputs: &[Input]) -> Vec<u8> {
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    for input in inputs {
        writer.write_input(input).unwrap();
    }
    writer.finish().unwrap()
}

#[test]
fn text_becomes_odometry_and_readings_with_one_stamp() {
    let recording = reading(text_of(3)).unwrap();
    assert_eq!(recording.format, Format::AmiroText);
    assert_eq!((recording.config, recording.truth), (None, None));
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    let mut expected = Vec::new();
    for (stamp_us, x) in [(0, 0.100), (100_000, 0.108), (200_000, 0.116)] {
        let pose = Pose::new(x, -0.001_28, 6.282_24);
        let counts = [0, 110, 108, 0, 0, 3, (stamp_us / 100_000) as i32, 0];
        let samples = counts.map(Sample::Counts);
        expected.push(Input::Odometry { stamp_us, pose });
        expected.push(Input::Proximity { stamp_us, samples });
    }
    assert_eq!(recording.inputs, expected);
    assert_eq!(recording.segments, 1);
}

#[test]
fn rows_repeated_to_the_letter_are_used_once() {
    let text = [HEADER, &row(0), &row(0), &row(0), &row(1), &row(0)].concat();
    let recording = reading(text).unwrap();
    assert_eq!(recording.inputs.len(), 6);
    assert_eq!(
        recording.refusals.to_string(),
        "line 3: repeats line 2\nline 4: repeats line 2"
    );
}

#[test]
fn full_register_is_saturated() {
    let text = HEADER.to_owned() + "65535\t65534\t0\t0\t0\t0\t0\t0\t0\t0\t0\n";
    let recording = reading(text).unwrap();
    let mut samples = [Sample::Counts(0); 8];
    samples[..2].copy_from_slice(&[Sample::Saturated, Sample::Counts(65_534)]);
    let stamp_us = 0;
    assert_eq!(recording.inputs[1], Input::Proximity { stamp_us, samples });
}

#[test]
fn stream_is_read_as_it_was_written() {
    let config = Config {
        seed: 7,
        ..Config::amiro(Profile::Plus)
    };
    let speeds = WheelSpeeds {
        left_m_per_s: 0.08,
        right_m_per_s: -0.01,
    };
    let mut inputs = vec![
        odometry(10, -0.5),
        proximity(12),
        Input::Wheels {
            stamp_us: 14,
            speeds,
        },
        tick(u64::MAX / 2),
    ];
    inputs.extend((0..300).map(|late| tick(u64::MAX - 300 + late)));
    let poses: Vec<(u64, Pose)> = (0..40)
        .map(|i| (i, Pose::new(i as f32, -1.0, 3.0)))
        .collect();
    let scenario = "# Grüße\nseed = 7\n".repeat(40);
    let mut answers = Vec::new();
    let mut board = Encoder::new(0x11);
    let events = [3, 9].map(|input| Message::Answer {
        input,
        refused: None,
    });
    for event in &events {
        answers.extend_from_slice(board.encode(event));
    }

    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_truth(&TruthMessage::Seed(7)).unwrap();
    writer.write_scenario(&scenario).unwrap();
    writer.write_message(&Message::Hello).unwrap();
    writer.write_input(&Input::Configure(config)).unwrap();
    for (index, input) in inputs.iter().enumerate() {
        writer.write_input(input).unwrap();
        if let Some((stamp_us, pose)) = poses.get(index).copied() {
            writer
                .write_truth(&TruthMessage::Pose { stamp_us, pose })
                .unwrap();
        }
        if index == 20 {
            // A board's last byte that went missing costs nothing.
            writer.write_frames(&answers[..answers.len() - 1]).unwrap();
        }
    }
    let recording = reading(writer.finish().unwrap()).unwrap();

    assert_eq!(recording.format, Format::Stream);
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    assert_eq!(recording.config, Some(config));
    assert_eq!(recording.inputs, inputs);
    assert_eq!(recording.messages, events);
    let truth = recording.truth.unwrap();
    assert_eq!(truth.seed, Some(7));
    assert_eq!(truth.scenario, Some(scenario));
    assert_eq!(truth.poses, poses);
    assert_eq!(recording.segments, 3);
}

#[test]
fn golden_recording_has_the_bytes_of_the_link() {
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_input(&tick(5)).unwrap();
    let bytes = writer.finish().unwrap();
    // Zero; COBS of boot id A5, number 0000, Input (0), Tick (5), stamp (5), CRC-32.
    assert_eq!(bytes[..9], [0, 2, 0xA5, 1, 1, 7, 5, 5, bytes[8]]);
    assert_eq!(bytes.len(), 13);
    assert_eq!(bytes[12], 0);
}

#[test]
fn stream_without_its_first_zero_byte_is_still_a_stream() {
    let bytes = stream_of(&[tick(1), tick(2)]);
    let recording = reading(&bytes[4..]).unwrap();
    assert_eq!(recording.format, Format::Stream);
    assert_eq!(recording.inputs, [tick(2)]);
    let refusal = &recording.refusals.first()[0];
    assert_eq!(refusal.place, Place::Byte(0));
    assert!(matches!(refusal.reason, Reason::Broken(_)), "{refusal}");
}

#[test]
fn broken_frame_costs_itself_and_shows_as_a_loss() {
    let mut bytes = stream_of(&[tick(1), tick(2), tick(3)]);
    let frame = (bytes.len() - 1) / 3;
    bytes[1 + frame + 6] ^= 0x40;
    let recording = reading(&bytes).unwrap();
    assert_eq!(recording.inputs, [tick(1), tick(3)]);
    assert_eq!(
        recording.refusals.to_string(),
        "byte 13: checksum does not match\nbyte 25: 1 frames lost"
    );
    let long = [stream_of(&[tick(1)]), vec![7; MAX_FRAME], vec![0]].concat();
    let recording = reading(long).unwrap();
    let too_long = Reason::Broken(FrameError::TooLong);
    assert_eq!(recording.refusals.count_of(too_long), 1);
}

#[test]
fn losses_are_counted_for_each_sender_apart() {
    let mut host = Encoder::new(0xA5);
    let mut board = Encoder::new(0x42);
    let mut bytes = vec![0];
    for index in 0..20_u16 {
        let input = Message::Input(tick(u64::from(index)));
        let answer = Message::Answer {
            input: index,
            refused: None,
        };
        let (input, answer) = (host.encode(&input), board.encode(&answer));
        if index != 4 {
            bytes.extend_from_slice(input);
        }
        if !(8..11).contains(&index) {
            bytes.extend_from_slice(answer);
        }
    }
    let recording = reading(&bytes).unwrap();
    assert_eq!((recording.inputs.len(), recording.messages.len()), (19, 17));
    let lost: Vec<&str> = recording
        .refusals
        .first()
        .iter()
        .map(|r| r.text.as_str())
        .collect();
    assert_eq!(lost, ["1 frames lost", "3 frames lost"]);
}

#[test]
fn second_configuration_ends_what_is_used() {
    let config = Input::Configure(Config::default());
    let bytes = stream_of(&[config, tick(1), tick(2), config, tick(3)]);
    let recording = reading(bytes).unwrap();
    assert_eq!(recording.inputs, [tick(1), tick(2)]);
    assert_eq!(recording.refusals.count_of(Reason::SecondRun), 1);
    assert_eq!(recording.refusals.count(), 1);
}

/// A robot in memory that reads itself: every byte that its board says.
struct LiveBoard<'a> {
    terminal: DeviceEndpoint<'a, 800>,
    host: Encoder,
    said: Vec<u8>,
}

impl<'a> LiveBoard<'a> {
    /// As after a reset: it says who speaks and with what it begins.
    fn new(particles: &'a mut ParticleSet<800>, own: Config) -> Self {
        let mut board = Self {
            terminal: DeviceEndpoint::new(Node::new(particles), boot_on_host(800), 7),
            host: Encoder::new(0xa5),
            said: Vec::new(),
        };
        let Self { terminal, said, .. } = &mut board;
        terminal.introduce(&mut |frame, _| said.extend_from_slice(frame));
        board.read(&[Input::Configure(own)]);
        board
    }

    /// Its own inputs, among them what it says of itself.
    fn read(&mut self, inputs: &[Input]) {
        let Self { terminal, said, .. } = self;
        let mut send = |frame: &[u8], _| said.extend_from_slice(frame);
        for (number, input) in inputs.iter().enumerate() {
            terminal.inject(input, &mut send);
            match number % 16 {
                0 => terminal.report(BoardStatus::default(), &mut send),
                5 => terminal.publish(&Message::Health(Health::default()), &mut send),
                9 => terminal.publish(&Message::Offsets(OffsetReport::default()), &mut send),
                _ => {}
            }
        }
    }

    /// An input of the host, over the link.
    fn hear<'m>(&mut self, message: impl Into<MessageRef<'m>>) {
        let Self {
            terminal,
            host,
            said,
        } = self;
        for byte in host.encode(message) {
            terminal.receive(*byte, &mut |frame, _| said.extend_from_slice(frame));
        }
    }
}

/// What a robot reads along a wall from a time on: readings at 125 Hz, every eighth with
/// a pose, every fifteenth with a tick; amid them a pose out of this world, and at the
/// end odometry that begins anew.
fn own_readings(from_us: u64, rows: u64) -> Vec<Input> {
    let mut inputs = Vec::new();
    for row in 0..rows {
        let stamp_us = from_us + row * 8_000;
        let x = row as f32 * 0.64e-3;
        if row % 8 == 0 {
            inputs.push(odometry(stamp_us, x));
        }
        if row == rows / 2 {
            inputs.push(odometry(stamp_us + 1, x + 5.0));
        }
        let mut samples = [Sample::Counts((row % 5) as i32); 8];
        samples[1] = Sample::Counts(110 - (row % 3) as i32);
        samples[2] = Sample::Missing;
        inputs.push(Input::Proximity { stamp_us, samples });
        if row % 15 == 14 {
            inputs.push(tick(stamp_us + 100));
        }
    }
    let end_us = from_us + (rows + 200) * 8_000;
    inputs.push(odometry(end_us, 0.0));
    inputs.push(proximity(end_us));
    inputs
}

fn own_config(seed: u64) -> Config {
    Config {
        seed,
        particles_per_sensor: 100,
        choice: SampleSelection::Median,
        source: Source::Board,
        ..Config::amiro(Profile::Paper)
    }
}

/// That a recording of a board that reads itself holds that configuration and those
/// inputs, and that they replay to its very events.
fn assert_replays(recording: &Recording, config: &Config, inputs: &[Input]) {
    assert_eq!(recording.config, Some(*config));
    let parting = (0..inputs.len().max(recording.inputs.len()))
        .find(|&place| recording.inputs.get(place) != inputs.get(place))
        .map(|place| (place, recording.inputs.get(place), inputs.get(place)));
    assert_eq!(parting, None, "where they part, found and expected");
    let as_replayed = Config {
        source: Source::Link,
        ..*config
    };
    let mut comparison = Comparison::default();
    let mut breaks = 0;
    let outcome = sim_harness::run(&as_replayed, &recording.inputs, |event| {
        comparison.expect(event);
        breaks += u32::from(matches!(event, Event::OdometryReset { .. }));
    })
    .unwrap();
    for event in &recording.messages {
        comparison.meet(event);
    }
    let verdict = comparison.verdict_of_recording();
    assert!(verdict.equal, "{verdict}");
    assert_eq!(verdict.digests, outcome.steps as usize, "{verdict}");
    assert!(outcome.steps >= 5, "{outcome:?}");
    // The pose out of this world is refused both times, the new beginning taken.
    assert_eq!((outcome.refusals.len(), breaks), (1, 1), "{outcome:?}");
}

#[test]
fn a_live_recording_replays_whatever_the_board_was_amid() {
    for step_rule in [
        StepRule::PerDistance { step_m: 0.01 },
        StepRule::PerTick { own_clock: true },
    ] {
        let wanted = Config {
            step_rule,
            ..own_config(9)
        };
        let mut particles = ParticleSet::<800>::new();
        let mut board = LiveBoard::new(&mut particles, own_config(5));
        board.hear(&Message::Hello);
        board.read(&own_readings(0, 100));
        board.hear(&Input::Configure(wanted));
        // Earlier than what it read before: its clock is its own affair.
        let inputs = own_readings(5_000, 150);
        board.read(&inputs);
        let mut writer = RecordingWriter::new(Vec::new()).unwrap();
        writer.write_input(&Input::Configure(wanted)).unwrap();
        writer.write_frames(&board.said).unwrap();
        let recording = reading(writer.finish().unwrap()).unwrap();
        assert_replays(&recording, &wanted, &inputs);
        assert_eq!(recording.refusals.count_of(Reason::BeforeConfiguration), 1);
        assert_eq!(recording.refusals.count(), 1, "{}", recording.refusals);
        // The silence before the end is a second segment.
        assert_eq!(recording.segments, 2);
    }
}

#[test]
fn a_capture_of_a_board_s_line_replays_up_to_another_configuration() {
    let own = own_config(5);
    let mut particles = ParticleSet::<800>::new();
    let mut board = LiveBoard::new(&mut particles, own);
    let inputs = own_readings(0, 150);
    board.read(&inputs);
    let recording = reading(&board.said).unwrap();
    assert_replays(&recording, &own, &inputs);
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    // The very same configuration is another run too: the board forgets.
    board.hear(&Input::Configure(own));
    board.read(&own_readings(3_000_000, 150));
    let recording = reading(&board.said).unwrap();
    assert_replays(&recording, &own, &inputs);
    assert_eq!(recording.refusals.count_of(Reason::SecondRun), 1);
    assert_eq!(recording.refusals.count(), 1, "{}", recording.refusals);
}

#[test]
fn a_board_s_earlier_readings_cost_none_of_the_host_s() {
    let config = Config {
        source: Source::Link,
        ..own_config(9)
    };
    let mut particles = ParticleSet::<800>::new();
    let mut board = LiveBoard::new(&mut particles, own_config(5));
    board.read(&own_readings(60_000_000, 50));
    board.hear(&Input::Configure(config));
    let inputs = own_readings(0, 150);
    // What it reads itself meanwhile is left out; it makes no ticks under this rule.
    let mut own = own_readings(61_000_000, 50);
    own.retain(|input| !matches!(input, Input::Tick { .. }));
    board.read(&own);
    for input in &inputs {
        board.hear(input);
    }
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_input(&Input::Configure(config)).unwrap();
    let (ahead, rest) = inputs.split_at(7);
    for input in ahead {
        writer.write_input(input).unwrap();
    }
    writer.write_frames(&board.said).unwrap();
    for input in rest {
        writer.write_input(input).unwrap();
    }
    let recording = reading(writer.finish().unwrap()).unwrap();
    assert_replays(&recording, &config, &inputs);
}

#[test]
fn illegal_configuration_and_numbers_are_refused_by_name() {
    let config = Config {
        particles_per_sensor: 0,
        ..Config::default()
    };
    let nan = Input::Odometry {
        stamp_us: 1,
        pose: Pose {
            position: Point::new(f32::NAN, 0.0),
            ..Pose::default()
        },
    };
    let speeds = WheelSpeeds {
        left_m_per_s: f32::INFINITY,
        right_m_per_s: 0.0,
    };
    let wheels = Input::Wheels {
        stamp_us: 1,
        speeds,
    };
    let recording = reading(stream_of(&[Input::Configure(config), nan, wheels, tick(1)])).unwrap();
    assert_eq!(recording.config, None);
    assert_eq!(recording.inputs, [tick(1)]);
    assert_eq!(recording.refusals.count_of(Reason::NotFinite), 2);
    let first = recording.refusals.first()[0].to_string();
    assert!(first.contains("particles_per_sensor"), "{first}");
}

#[test]
fn scenario_beyond_its_cap_is_refused_and_the_rest_is_used() {
    for (text, reason) in [
        ("x".repeat(64 * 1024), None),
        ("x".repeat(64 * 1024 + 1), Some(Reason::BadScenario)),
    ] {
        let mut writer = RecordingWriter::new(Vec::new()).unwrap();
        writer.write_scenario(&text).unwrap();
        writer.write_input(&tick(1)).unwrap();
        let recording = reading(writer.finish().unwrap()).unwrap();
        assert_eq!(recording.inputs, [tick(1)]);
        assert_eq!(recording.refusals.first().first().map(|r| r.reason), reason);
        let scenario = recording.truth.and_then(|truth| truth.scenario);
        assert_eq!(scenario.is_some(), reason.is_none());
    }
}

#[test]
fn node_takes_every_input_of_a_text_drive() {
    let recording = reading(text_of(40)).unwrap();
    let mut particles = ParticleSet::<800>::new();
    let mut node = Node::new(&mut particles);
    let config = Config {
        particles_per_sensor: 100,
        ..Config::default()
    };
    let mut steps = 0;
    let mut count = |event: &Event| steps += u32::from(matches!(event, Event::StepDone(_)));
    node.handle(&Input::Configure(config), &mut count).unwrap();
    for input in &recording.inputs {
        node.handle(input, &mut count).unwrap();
    }
    // 39 x 8 mm and the step at the start; which side of 310 mm rounding puts the
    // last one on does not matter.
    assert!((31..=32).contains(&steps), "{steps}");
}

#[test]
fn f80_text_cut_at_any_byte_gives_the_rows_before_the_cut() {
    let text = text_of(50);
    assert!(text.len() > 2048, "{}", text.len());
    let whole = reading(&text).unwrap();
    for cut in 0..=text.len() {
        let rows = text[..cut].matches('\n').count().saturating_sub(1);
        match reading(&text[..cut]) {
            Ok(recording) => {
                assert_eq!(recording.inputs, whole.inputs[..2 * rows], "cut at {cut}");
                let is_clean = text[..cut].ends_with('\n');
                let refused = u64::from(!is_clean);
                assert_eq!(recording.refusals.count(), refused, "cut at {cut}");
                if let [refusal] = recording.refusals.first() {
                    let line = rows as u64 + 2;
                    assert_eq!(refusal.place, Place::Line(line), "cut at {cut}");
                }
            }
            Err(error) => assert_eq!(rows, 0, "cut at {cut}: {error}"),
        }
    }
}

#[test]
fn f80_stream_cut_at_any_byte_gives_the_frames_before_the_cut() {
    let mut inputs = vec![Input::Configure(Config::default())];
    for i in 0..12 {
        inputs.extend([odometry(i * 1000, i as f32), proximity(i * 1000)]);
    }
    let bytes = stream_of(&inputs);
    for cut in 0..=bytes.len() {
        // A frame that lacks nothing but its zero byte is whole: the checksum says so.
        let is_whole = bytes.get(cut).is_none_or(|next| *next == 0);
        let ends = bytes[..cut].iter().filter(|byte| **byte == 0).count();
        let frames =
            (ends + usize::from(is_whole && bytes[..cut].last() != Some(&0))).saturating_sub(1);
        match reading(&bytes[..cut]) {
            Ok(recording) => {
                assert_eq!(recording.inputs, inputs[1..frames], "cut at {cut}");
                let is_clean = is_whole || bytes[..cut].ends_with(&[0]);
                assert_eq!(recording.refusals.is_empty(), is_clean, "cut at {cut}");
            }
            Err(error) => assert!(frames <= 1, "cut at {cut}: {error}"),
        }
    }
}

#[test]
fn f81_fields_that_are_no_integers_cost_their_row() {
    for bad in [
        "NaN",
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-0",
        "",
        " ",
        "0x1F",
        "1,5",
        "1.5",
        "1 5",
        "+1",
        "007",
        "--1",
        "1e3",
        "\u{0663}",
        "PRV 0",
        "\u{1b}[2J",
    ] {
        for column in [0, 7, 8, 10] {
            let mut fields: Vec<&str> =
                vec!["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11"];
            fields[column] = bad;
            let line = fields.join("\t") + "\t\n";
            let shown = assert_third_line_is_refused(line.as_bytes(), Reason::NotAnInteger);
            assert!(!shown.chars().any(char::is_control), "{shown:?}");
        }
    }
}

#[test]
fn f81_numbers_beyond_their_range_cost_their_row() {
    for (column, bad) in [
        (0, "-1"),
        (3, "65536"),
        (8, "500000001"),
        (9, "-500000001"),
        (9, "99999999999999999999999999"),
        (10, "7000001"),
        (10, "-7000001"),
    ] {
        let mut fields = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11"];
        fields[column] = bad;
        let line = fields.join("\t") + "\n";
        let shown = assert_third_line_is_refused(line.as_bytes(), Reason::OutOfRange);
        assert!(shown.contains(bad), "{shown}");
    }
    let edge = "0\t65535\t0\t0\t0\t0\t0\t0\t500000000\t-500000000\t-7000000\n";
    let recording = reading(between_good_rows(edge.as_bytes())).unwrap();
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
}

#[test]
fn f81_rows_of_other_lengths_are_refused() {
    for (line, found) in [
        ("1\n", "1 of 11 fields"),
        ("1\t2\t3\t4\t5\t6\t7\t8\t9\t10\n", "10 of 11 fields"),
        ("1\t2\t3\t4\t5\t6\t7\t8\t9\t10\t11\t12\n", "12 of 11 fields"),
        ("1,2,3,4,5,6,7,8,9,10,11\n", "1 of 11 fields"),
    ] {
        let shown = assert_third_line_is_refused(line.as_bytes(), Reason::FieldCount);
        assert_eq!(shown, format!("line 3: {found}"));
    }
}

#[test]
fn f81_first_five_are_shown_and_the_rest_is_summed() {
    let text = text_of(1) + &"x\n".repeat(7) + "\n\n" + &row(1);
    let recording = reading(text).unwrap();
    let shown = recording.refusals.to_string();
    let lines: Vec<&str> = shown.lines().collect();
    assert_eq!(lines.len(), 6, "{shown}");
    assert_eq!(lines[0], "line 3: 1 of 11 fields");
    assert_eq!(lines[5], "and 4 more (field count x 2, empty line x 2)");
}

#[test]
fn f82_missing_header_is_refused_with_a_guess_of_the_units() {
    for (pose, unit) in [
        ("3010304\t-1287680\t282624", "micrometres"),
        ("3010\t-1287\t16", "millimetres"),
        ("3.010304\t-1.28768\t0.2826", "metres"),
    ] {
        let text = format!("1\t2\t3\t4\t5\t6\t7\t8\t{pose}\n");
        let error = reading(text).unwrap_err();
        assert!(
            matches!(error.problem(), Problem::NoHeader { .. }),
            "{error}"
        );
        let shown = error.to_string();
        assert!(shown.contains(&format!("look like {unit};")), "{shown}");
        assert!(
            shown.contains("line 1") && shown.contains("expected the header PRV 0"),
            "{shown}"
        );
    }
    let error = reading("stamp,x,y\n1,2,3\n\x1b[2J").unwrap_err();
    assert!(error.to_string().contains("'stamp,x,y'"), "{error}");
}

#[test]
fn f82_header_with_other_units_is_refused_by_what_it_names() {
    for (from, to) in [
        ("X [ym]", "X [m]"),
        ("Y [ym]", "Y [mm]"),
        ("Theta [yrad]", "Theta [deg]"),
        ("Theta [yrad]", "Theta"),
        ("X [ym]", "X [um"),
    ] {
        let error = reading(text_of(3).replace(from, to)).unwrap_err();
        assert!(
            matches!(error.problem(), Problem::OtherUnits { .. }),
            "{error}"
        );
        assert!(error.to_string().contains(to), "{error}");
    }
}

#[test]
fn f83_stamps_that_go_backward_are_dropped_within_their_kind() {
    let inputs = [
        odometry(1_000, 0.0),
        proximity(2_000),
        // Behind the readings, not behind the odometry: kept.
        odometry(1_500, 0.1),
        odometry(1_400, 0.2),
        // The same time, another place: kept.
        odometry(1_500, 0.3),
        proximity(1_999),
    ];
    let recording = reading(stream_of(&inputs)).unwrap();
    assert_eq!(
        recording.inputs,
        [inputs[0], inputs[1], inputs[2], inputs[4]]
    );
    assert_eq!(recording.refusals.count_of(Reason::Backward), 2);
    let first = &recording.refusals.first()[0];
    assert!(
        first.text.contains("1400 us lies before 1500 us"),
        "{first}"
    );
}

#[test]
fn f83_duplicates_keep_the_first() {
    let inputs = [
        odometry(1, 0.0),
        odometry(1, 0.0),
        proximity(1),
        proximity(1),
        tick(1),
        tick(1),
    ];
    let recording = reading(stream_of(&inputs)).unwrap();
    assert_eq!(recording.inputs, [inputs[0], inputs[2], inputs[4]]);
    assert_eq!(recording.refusals.count_of(Reason::Repeated), 3);

    // The same frame twice is no loss of 65535 frames.
    let bytes = stream_of(&[tick(1)]);
    let recording = reading([&bytes[..], &bytes[1..]].concat()).unwrap();
    assert_eq!(recording.inputs, [tick(1)]);
    assert_eq!(recording.refusals.count_of(Reason::Repeated), 1);
    assert_eq!(recording.refusals.count(), 1);
}

#[test]
fn f83_gaps_begin_a_segment_and_cost_nothing() {
    for (stamps, segments) in [
        (&[0, 1_000_000][..], 1),
        (&[0, 1_000_001], 2),
        (&[0, 5, 9_000_000, 9_000_001, u64::MAX], 3),
    ] {
        let inputs: Vec<Input> = stamps.iter().map(|stamp_us| tick(*stamp_us)).collect();
        let recording = reading(stream_of(&inputs)).unwrap();
        assert_eq!(recording.inputs, inputs);
        assert_eq!(recording.segments, segments, "{stamps:?}");
        assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    }
}

#[test]
fn f85_line_of_eight_mebibytes_is_skipped_to_its_end() {
    let line = std::io::repeat(b'7').take(8 << 20);
    let end = "\n".to_owned() + &row(1);
    let source = Cursor::new(text_of(1)).chain(line).chain(Cursor::new(end));
    let recording = read_from(source).unwrap();
    assert_eq!(recording.inputs.len(), 4);
    assert_eq!(
        recording.refusals.to_string(),
        "line 3: longer than 64 KiB: skipped to its end"
    );
}

#[test]
fn f85_source_without_shape_is_given_up_after_a_mebibyte() {
    for byte in [b'7', b'\n', 0, 0xFF] {
        for first in [0, b'x', 0xFF] {
            let endless = Cursor::new([first]).chain(std::io::repeat(byte));
            let error = read_from(endless).unwrap_err();
            assert!(
                matches!(
                    error.problem(),
                    Problem::Shapeless | Problem::NoHeader { .. }
                ),
                "{first} {byte}: {error}"
            );
        }
    }
}

#[test]
fn f85_zero_bytes_and_broken_utf8_cost_their_line() {
    let good = row(9);
    let with = |place: usize, byte: u8| {
        let mut line = good.clone().into_bytes();
        line[place] = byte;
        line
    };
    assert_third_line_is_refused(&with(0, 0), Reason::ZeroByte);
    assert_third_line_is_refused(&with(20, 0), Reason::ZeroByte);
    let shown = assert_third_line_is_refused(&with(3, 0xFF), Reason::NotUtf8);
    assert!(shown.contains("index 3"), "{shown}");
    assert_third_line_is_refused(&with(3, 0xC3), Reason::NotUtf8);
}

#[test]
fn f85_byte_order_mark_and_carriage_returns_change_nothing() {
    let plain = reading(text_of(5)).unwrap();
    for text in [
        "\u{feff}".to_owned() + &text_of(5),
        text_of(5).replace('\n', "\r\n"),
        text_of(5).replace('\n', "\t\n"),
        text_of(5).replace('\n', "\t\r\n"),
    ] {
        let recording = reading(&text).unwrap();
        assert_eq!(recording, plain, "{text:?}");
    }
}

#[test]
fn f85_utf16_is_refused_with_its_name() {
    let text = text_of(2);
    let little = || text.encode_utf16().flat_map(u16::to_le_bytes);
    let big = || text.encode_utf16().flat_map(u16::to_be_bytes);
    let mark = |mark: [u8; 2], text: Vec<u8>| [&mark[..], &text].concat();
    for bytes in [
        little().collect(),
        big().collect(),
        mark([0xFF, 0xFE], little().collect()),
        mark([0xFE, 0xFF], big().collect()),
    ] {
        let error = reading(bytes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "recording: is UTF-16 text; expected UTF-8"
        );
    }
}

#[test]
fn f85_sources_without_a_usable_row_are_no_recordings() {
    let error = reading(b"").unwrap_err();
    assert!(matches!(error.problem(), Problem::Empty), "{error}");
    for bytes in [
        HEADER.as_bytes().to_vec(),
        [HEADER.as_bytes(), b"x\n"].concat(),
        b"\n\n\n".to_vec(),
        vec![0],
        vec![0; 1000],
        stream_of(&[]),
        stream_of(&[Input::Configure(Config::default())]),
        b"\0garbage\0".to_vec(),
    ] {
        let error = reading(&bytes).unwrap_err();
        assert!(
            matches!(error.problem(), Problem::NothingUsable(_)),
            "{error}"
        );
    }
}

/// A drive's pose: metres and radians, the heading from 0 to 2 pi.
type DrivenPose = (f64, f64, f64);

/// 126 rows of a drive from (2.15, -0.9): straight ahead, and a bend to the left.
fn driven() -> Vec<DrivenPose> {
    let (mut x, mut y, mut heading) = (2.15_f64, -0.9_f64, 5.82_f64);
    (0..126)
        .map(|index| {
            let turn = if index > 60 { 0.012 } else { 0.0 };
            heading = (heading + turn) % std::f64::consts::TAU;
            x += 0.0065 * heading.cos();
            y += 0.0065 * heading.sin();
            (x, y, heading)
        })
        .collect()
}

/// A row of text with a reading that changes; the pose's numbers as they are written.
fn row_of(index: usize, [x, y, heading]: [String; 3]) -> String {
    let counts = 100 + 5 * (index % 40);
    format!("0\t{counts}\t108\t0\t0\t3\t{index}\t0\t{x}\t{y}\t{heading}\n")
}

/// Text of a drive whose numbers are `length` to a metre and `angle` to a radian.
fn text_in(drive: &[DrivenPose], length: f64, angle: f64, decimals: usize) -> String {
    let rows = drive.iter().enumerate().map(|(index, (x, y, heading))| {
        let numbers = [x * length, y * length, heading * angle];
        row_of(index, numbers.map(|number| format!("{number:.decimals$}")))
    });
    HEADER.to_owned() + &rows.collect::<String>().replace("\t-0\t", "\t0\t")
}

/// Six ways to be wrong: numbers to a metre and to a radian, and what they look like.
const WRONG_UNITS: [(f64, f64, &str); 6] = [
    (1e3, 1e6, "X and Y look like millimetres"),
    (1e2, 1e6, "X and Y look like centimetres"),
    (1.0, 1e6, "X and Y look like metres"),
    (
        1e6,
        180.0 / std::f64::consts::PI,
        "Theta looks like degrees",
    ),
    (1e6, 1.0, "Theta looks like radians"),
    (1e6, 1e3, "Theta looks like milliradians"),
];

fn assert_wrong_units_are_named(name: &str, drive: &[DrivenPose]) {
    let good = reading(text_in(drive, 1e6, 1e6, 0));
    assert!(good.is_ok(), "{name}: {}", good.unwrap_err());
    for (length, angle, hint) in WRONG_UNITS {
        for decimals in [0, 6] {
            let error = reading(text_in(drive, length, angle, decimals)).unwrap_err();
            let is_doubted = matches!(error.problem(), Problem::ImplausibleUnits { .. });
            assert!(is_doubted, "{name}, {hint}, {decimals}: {error}");
            assert!(
                error.to_string().contains(hint),
                "{name}, {hint}, {decimals}: {error}"
            );
        }
    }
}

#[test]
fn f32_numbers_in_six_wrong_units_are_refused_by_their_name() {
    assert_wrong_units_are_named("made", &driven());
    let backward: Vec<DrivenPose> = driven().into_iter().rev().collect();
    assert_wrong_units_are_named("backward", &backward);
}

#[test]
fn f32_real_drives_in_wrong_units_are_refused_by_their_name() {
    let Some(data) = common::recordings() else {
        return common::skip("no recordings");
    };
    for name in ["Left", "Gang", "Right_Right"] {
        let path = data.join(format!("amiro/RingProximityAndOdometry_{name}.txt"));
        let drive: Vec<DrivenPose> = read(&path)
            .unwrap()
            .inputs
            .iter()
            .filter_map(|input| match input {
                Input::Odometry { pose, .. } => Some((
                    f64::from(pose.position.x),
                    f64::from(pose.position.y),
                    f64::from(pose.heading.radians()).rem_euclid(std::f64::consts::TAU),
                )),
                _ => None,
            })
            .collect();
        assert_wrong_units_are_named(name, &drive);
    }
}

#[test]
fn f32_stepped_series_and_standing_robots_are_read() {
    // Jitter by a step of the odometry, and none at all, while something passes by.
    for jitter in [0.0, 256e-6] {
        for place in [0.0, 1.5] {
            let standing: Vec<DrivenPose> = (0..200)
                .map(|index| (place + jitter * f64::from(index % 2), 0.0, 1.0))
                .collect();
            let recording = reading(text_in(&standing, 1e6, 1e6, 0));
            assert!(recording.is_ok(), "{}", recording.unwrap_err());
        }
    }
    let Some(data) = common::recordings() else {
        return common::skip("no recordings");
    };
    let followed = ["alone", "wall20", "wall40", "wall60"].map(|name| format!("follow_{name}"));
    let beside = ["Gang_25", "Right_10", "Right_50"].map(|name| format!("Data_{name}"));
    for name in followed.iter().chain(&beside) {
        let recording = read(&data.join(format!("amiro/{name}.txt")));
        assert!(recording.is_ok(), "{}", recording.unwrap_err());
    }
}

#[test]
fn f32_drive_that_stays_within_a_step_while_its_readings_change_is_refused() {
    // Cut to whole metres, a drive of 0.6 m stands at (2, 0).
    let rows: Vec<DrivenPose> = (0..100)
        .map(|index| (2.0 + 0.0 * f64::from(index), 0.0, 0.0))
        .collect();
    let error = reading(text_in(&rows, 1.0, 1e6, 0)).unwrap_err();
    assert!(error.to_string().contains("look like metres"), "{error}");
    // The same place with readings that stay: a robot that stands.
    let still = HEADER.to_owned()
        + &(0..100)
            .map(|index| format!("0\t10{}\t0\t0\t0\t0\t0\t0\t2\t0\t0\n", index % 10))
            .collect::<String>();
    assert!(reading(still).is_ok());
}

#[test]
fn f32_stream_that_is_too_fast_is_refused_with_its_unit() {
    let stream_in = |length: f32| {
        let inputs: Vec<Input> = (0..200)
            .map(|index| odometry(63_000 * index, 0.08 * 0.063 * length * index as f32))
            .collect();
        reading(stream_of(&inputs))
    };
    assert!(stream_in(1.0).is_ok());
    // Ten times the paper's speed.
    assert!(stream_in(10.0).is_ok());
    for (length, unit) in [
        (1e2, "centimetres"),
        (1e3, "millimetres"),
        (1e6, "micrometres"),
    ] {
        let error = stream_in(length).unwrap_err();
        let hint = format!("positions and speeds look like {unit}");
        assert!(error.to_string().contains(&hint), "{error}");
    }
    let wheels = |speed: f32| {
        let speeds = WheelSpeeds {
            left_m_per_s: speed,
            right_m_per_s: speed,
        };
        let wheels = (0..20).map(|index| Input::Wheels {
            stamp_us: 63_000 * index,
            speeds,
        });
        reading(stream_of(&wheels.collect::<Vec<_>>()))
    };
    assert!(wheels(-0.08).is_ok());
    let error = wheels(-80.0).unwrap_err();
    assert!(
        error.to_string().contains("look like millimetres"),
        "{error}"
    );
}

#[test]
fn f32_poses_that_come_late_or_after_a_gap_are_not_fast() {
    // Every pose stamped with the sample 1 ms after its change; and a robot that was
    // carried away in each of fifteen gaps.
    let mut inputs = Vec::new();
    for index in 0..4_000_u64 {
        let carried = (index / 250) as f32 * 3.0;
        let place = (index / 63 * 63) as f32 * 1e-3 * 0.4 + carried;
        inputs.push(odometry(1_000 * index + index / 250 * 2_000_000, place));
    }
    let recording = reading(stream_of(&inputs));
    assert!(recording.is_ok(), "{}", recording.unwrap_err());
}

/// A directory of a test's own, gone when the test is.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Litter in the target directory hurts nobody.
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn f86_missing_files_and_directories_are_named() {
    let scratch = Scratch::new("unreadable");
    for name in ["missing", "miss\u{1b}[2Jing\n"] {
        let error = read(&scratch.0.join(name)).unwrap_err();
        assert!(matches!(error.problem(), Problem::Unreadable(_)), "{error}");
        let shown = error.to_string();
        assert!(
            shown.contains("miss") && shown.contains("cannot be read: "),
            "{shown}"
        );
        assert!(!shown.chars().any(char::is_control), "{shown:?}");
    }
    let error = read(&scratch.0).unwrap_err();
    assert!(matches!(error.problem(), Problem::Unreadable(_)), "{error}");
    assert!(error.to_string().contains("unreadable-"), "{error}");
}

#[test]
fn f86_error_in_the_middle_names_its_byte() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("the disk is gone"))
        }
    }
    let text = text_of(200);
    let error = read_from(Cursor::new(&text).chain(Failing)).unwrap_err();
    let expected = format!(
        "recording, byte {}: cannot be read: the disk is gone",
        text.len()
    );
    assert_eq!(error.to_string(), expected);
}

#[cfg(unix)]
#[test]
fn f86_file_without_permission_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let scratch = Scratch::new("forbidden");
    let path = scratch.0.join("drive.txt");
    fs::write(&path, text_of(3)).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(&path).is_ok() {
        return common::report_skipped("this user may read everything");
    }
    let error = read(&path).unwrap_err();
    assert!(matches!(error.problem(), Problem::Unreadable(_)), "{error}");
    assert!(error.to_string().contains("drive.txt"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn f86_endless_device_ends_with_a_message() {
    let error = read(Path::new("/dev/zero")).unwrap_err();
    assert!(matches!(error.problem(), Problem::Shapeless), "{error}");
    assert!(error.to_string().starts_with("/dev/zero: "), "{error}");
    let error = read(Path::new("/dev/null")).unwrap_err();
    assert!(matches!(error.problem(), Problem::Empty), "{error}");
}

#[cfg(unix)]
#[test]
fn f86_named_pipe_is_read_to_its_end() {
    let scratch = Scratch::new("pipe");
    let path = scratch.0.join("pipe");
    let made = std::process::Command::new("mkfifo")
        .arg(&path)
        .status()
        .unwrap();
    assert!(made.success());
    let text = text_of(3000);
    let whole = reading(&text).unwrap();
    // More than a pipe holds, so that the writer waits for the reader.
    assert!(text.len() > 1 << 16);
    let writer = std::thread::spawn({
        let path = path.clone();
        move || fs::write(path, text).unwrap()
    });
    let recording = read(&path).unwrap();
    writer.join().unwrap();
    assert_eq!(recording, whole);
}

#[test]
fn real_drives_are_read_and_their_cut_last_lines_refused() {
    let Some(data) = common::recordings() else {
        return common::skip("no recordings");
    };
    let data = data.join("amiro");
    // Rows without the cut last line, and how many of them repeat the row before.
    let drives = [("Left", 126, 0), ("Gang", 141, 3), ("Right_Right", 150, 3)];
    let path = |name: &str| data.join(format!("RingProximityAndOdometry_{name}.txt"));
    for (name, rows, repeated) in drives {
        let recording = read(&path(name)).unwrap();
        assert_eq!(recording.inputs.len(), 2 * (rows - repeated), "{name}");
        let refusals = &recording.refusals;
        assert_eq!(refusals.count(), repeated as u64 + 1, "{name}: {refusals}");
        assert_eq!(
            refusals.count_of(Reason::Repeated),
            repeated as u64,
            "{name}"
        );
        let cut = refusals.first().last().unwrap();
        // The header is line 1.
        assert_eq!(
            cut.place,
            Place::Line(rows as u64 + 2),
            "{name}: {refusals}"
        );
        assert_eq!(cut.reason, Reason::FieldCount, "{name}: {refusals}");
        assert_eq!(recording.segments, 1, "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..4096)) {
        let _ = reading(&bytes);
        let _ = reading([HEADER.as_bytes(), &bytes].concat());
        let _ = reading([&stream_of(&[tick(1)])[..], &bytes].concat());
    }

    #[test]
    fn arbitrary_rows_are_used_or_refused_and_nothing_else(
        lines in proptest::collection::vec("[-0-9xe.\t\r ]{0,40}", 0..40),
    ) {
        let text = text_of(1) + &lines.join("\n") + "\n";
        let recording = reading(text).unwrap();
        let used = recording.inputs.len() as u64 / 2 - 1;
        prop_assert_eq!(used + recording.refusals.count(), lines.len().max(1) as u64);
    }

    #[test]
    fn damaged_stream_keeps_its_order_and_its_other_frames(
        damage in proptest::collection::vec((any::<usize>(), any::<u8>()), 1..8),
    ) {
        let inputs: Vec<Input> = (0..40).map(tick).collect();
        let mut bytes = stream_of(&inputs);
        for (place, byte) in &damage {
            let place = place % bytes.len();
            bytes[place] = *byte;
        }
        let recording = reading(&bytes).unwrap();
        // A damaged byte hits one frame; a damaged zero byte two.
        prop_assert!(recording.inputs.len() + 2 * damage.len() >= inputs.len());
        let mut rest = inputs.iter();
        prop_assert!(recording.inputs.iter().all(|kept| rest.any(|input| input == kept)));
    }
}
