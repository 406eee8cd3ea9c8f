//! What docs/threats.md promises: that the tests it names exist, and some of them.

use std::path::PathBuf;

use amiro_ipf::board::acquisition::{Acquisition, CanAction};
use amiro_ipf::board::can::{
    BodySpeed, CanIdentifier, CanMessage, actual_speed, proximity_ring, target_speed,
};
use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{
    self, Boot, Decoder, DeviceEndpoint, Encoder, Received, WINDOW, WIRE_VERSION,
};
use amiro_ipf::model::{SENSORS, Sample, WheelSpeeds};
use amiro_ipf::node::{Config, Input, InputError, Node, Source, StepRule};

use crate::common;

const PAGE: &str = include_str!("../../docs/threats.md");

/// A place that the page names, and the tests that it names there.
#[derive(Debug)]
struct Promise {
    place: String,
    /// Beginnings of names, and numbers of the fault catalogue.
    tests: Vec<String>,
}

/// Whether a word in backquotes is a path of the project's code.
fn is_place(word: &str) -> bool {
    ["src/", "tests/", "sim-harness/", ".ci/"]
        .iter()
        .any(|folder| word.starts_with(folder))
}

/// Whether a word is a number of the fault catalogue, as in f62.
fn is_number(word: &str) -> bool {
    let digits = word.strip_prefix('f').unwrap_or_default();
    digits.len() == 2
        && digits.starts_with(|first: char| first.is_ascii_digit())
        && digits.chars().all(|digit| digit.is_ascii_hexdigit())
}

/// The places of a text, each with the tests that are named behind it: `name_...` in
/// backquotes or the number outside of them.
fn promises(text: &str) -> Vec<Promise> {
    let mut promises: Vec<Promise> = Vec::new();
    for (index, piece) in text.split('`').enumerate() {
        let is_quoted = index % 2 == 1;
        if is_quoted && is_place(piece) {
            promises.push(Promise {
                place: piece.to_owned(),
                tests: Vec::new(),
            });
            continue;
        }
        let Some(last) = promises.last_mut() else {
            continue;
        };
        if is_quoted {
            if let Some(name) = piece.strip_suffix("...") {
                last.tests.push(name.to_owned());
            }
        } else {
            let words = piece.split(|letter: char| !letter.is_ascii_alphanumeric());
            let numbers = words.filter(|word| is_number(word));
            last.tests.extend(numbers.map(str::to_owned));
        }
    }
    promises
}

/// Names of the tests at a place: what follows `fn` behind an attribute `test`, or
/// within a `proptest`.
fn tests_at(place: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (_, text) in common::rust_files(place) {
        for piece in text.split("#[test]").skip(1) {
            let Some((_, rest)) = piece.split_once("fn ") else {
                continue;
            };
            names.extend(rest.split('(').next().map(str::to_owned));
        }
    }
    names
}

/// The rows of the page's tables: the cell of the answer and that of its tests.
fn rows() -> Vec<(&'static str, &'static str)> {
    let rows = PAGE.lines().filter_map(|line| {
        let cells: Vec<&str> = line
            .strip_prefix("| ")?
            .strip_suffix(" |")?
            .split(" | ")
            .collect();
        match cells[..] {
            [first, answer, shown] if first != "it can" => Some((answer, shown)),
            _ => None,
        }
    });
    rows.collect()
}

#[test]
fn every_test_that_the_page_names_exists() {
    let all = promises(PAGE);
    assert!(all.len() > 20, "{all:?}");
    for Promise { place, tests } in all {
        let path = common::root().join(&place);
        assert!(path.exists(), "{place} is not there");
        if place.starts_with(".ci/") {
            continue;
        }
        let there = tests_at(&place);
        for test in tests {
            let is_there = if is_number(&test) {
                let number = format!("{test}_");
                there.iter().any(|name| name.contains(&number))
            } else {
                there.iter().any(|name| name.starts_with(&test))
            };
            assert!(is_there, "{place} has no test {test}");
        }
    }
}

#[test]
fn every_answer_of_the_page_names_a_test_or_is_none() {
    let rows = rows();
    assert!(rows.len() > 20, "{} rows", rows.len());
    for (answer, shown) in rows {
        if shown == "-" {
            assert!(answer.contains("**not defended**"), "no test of: {answer}");
            continue;
        }
        let tests: usize = promises(shown)
            .iter()
            .map(|promise| tests_at(&promise.place).len())
            .sum();
        assert!(tests > 0, "{shown}: no test there, of: {answer}");
    }
}

#[test]
fn every_fuzz_target_and_step_that_the_page_names_exists() {
    let targets: Vec<&str> = PAGE
        .split("fuzz target `")
        .skip(1)
        .filter_map(|rest| rest.split('`').next())
        .collect();
    assert!(targets.len() > 5, "{targets:?}");
    for target in targets {
        let file = PathBuf::from(format!("tests/fuzz/fuzz_targets/{target}.rs"));
        assert!(common::root().join(&file).is_file(), "{}", file.display());
    }
    let script = std::fs::read_to_string(common::root().join(".ci/run")).unwrap();
    for rest in PAGE.split(", step \"").skip(1) {
        let step = rest.split('"').next().unwrap();
        assert!(script.contains(&format!("step \"{step}\"")), "{step}");
    }
}

/// Why a board with its own sensors refuses each of some inputs of a host.
fn refusals(inputs: &[Input]) -> Vec<Option<InputError>> {
    let boot = Boot {
        wire_version: WIRE_VERSION,
        build_id: 0,
        capacity: 80,
        window: WINDOW,
        baud: 0,
        clock: ClockSource::Host,
        core_hz: 0,
    };
    let mut particles = ParticleSet::<80>::new();
    let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), boot, 3);
    let (mut host, mut decoder) = (Encoder::new(0xa5), Decoder::new());
    let mut refusals = Vec::new();
    for input in inputs {
        for byte in host.encode(input) {
            endpoint.receive(*byte, &mut |frame, _| {
                for received in frame.iter().filter_map(|byte| decoder.push(*byte)) {
                    if let Received::Frame { frame, .. } = received
                        && let link::Message::Answer { refused, .. } = frame.message
                    {
                        refusals.push(refused);
                    }
                }
            });
        }
    }
    refusals
}

#[test]
fn a_board_that_reads_its_own_sensors_refuses_those_of_a_host() {
    let own = Config {
        particles_per_sensor: 10,
        source: Source::Board,
        step_rule: StepRule::PerTick { own_clock: false },
        ..Config::amiro(Profile::Plus)
    };
    let stamp_us = 1;
    let measured = [
        Input::Odometry {
            stamp_us,
            pose: Pose::default(),
        },
        Input::Wheels {
            stamp_us,
            speeds: WheelSpeeds {
                left_m_per_s: 0.1,
                right_m_per_s: 0.1,
            },
        },
        Input::Proximity {
            stamp_us,
            samples: [Sample::Counts(90); SENSORS],
        },
    ];
    let all = |config| {
        let mut inputs = vec![Input::Configure(config)];
        inputs.extend(measured);
        inputs
    };
    let refused = Some(InputError::NotTheSource);
    assert_eq!(refusals(&all(own)), [None, refused, refused, refused]);
    let by_link = Config {
        source: Source::Link,
        ..own
    };
    assert_eq!(refusals(&all(by_link)), [None; 4], "configured otherwise");
}

#[test]
fn speeds_on_the_robot_s_bus_are_no_input_and_no_frame_of_the_board_commands_a_wheel() {
    let speed = BodySpeed {
        forward_m_per_s: 0.3,
        turn_rad_per_s: 1.0,
    };
    let mut senses = Acquisition::new();
    for frame in [actual_speed(&speed), target_speed(&speed)] {
        assert!(CanMessage::decode(&frame).is_ok(), "it is read: {frame:?}");
        assert_eq!(senses.take_frame(1, &frame), CanAction::Nothing);
    }
    // What the board sends is the ring's, which no board of the robot reads as a command.
    for sensor in 0..SENSORS {
        let frame = proximity_ring(sensor, 2_400, 2_300).unwrap();
        let CanIdentifier::Standard(identifier) = frame.identifier() else {
            unreachable!("{frame:?}")
        };
        assert_eq!(usize::from(identifier.bits()), 0x182 + 8 * sensor);
        assert!(CanMessage::decode(&frame).is_err(), "{frame:?}");
    }
    for place in ["src/bin/firmware", "src/board/acquisition"] {
        for (path, text) in common::rust_files(place) {
            for word in ["target_speed", "actual_speed"] {
                assert!(!text.contains(word), "{} has {word}", path.display());
            }
        }
    }
}
