//! The page of faults, held against the code: every word is explained, every number has
//! its test.
//!
//! The stream's words are found by following its types, so that a new variant or counter
//! is noticed; a message of the host's is found by a match that a new one does not pass.
mod shape;

use std::collections::BTreeSet;
use std::io::Error;

use amiro_ipf::board::calibration::OffsetRefusal;
use amiro_ipf::board::health::Health;
use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::board::supervision::{PostMortem, Supervision};
use amiro_ipf::link::{Boot, FrameError, Message, Status, WIRE_VERSION};
use amiro_ipf::node::{Config, Event, InputError, Particles, StepBegun, StepDone, Walls};
use sim_harness::device::{Imbalance, LinkError};
use sim_harness::log::Reason;

use shape::{Named, Shape};

use crate::common;

const PAGE: &str = include_str!("../../../docs/faults.md");

/// The payloads of the messages of a board; `Answer` has no type of its own.
type Payloads = (
    (Boot, Config, StepBegun, Walls, Particles, StepDone),
    (Status, Health, OffsetReport, PostMortem, Supervision),
);

// A new message of a board fails to compile here until its payload is above.
const _: fn(&Message) = |message| match message {
    Message::Hello | Message::Calibrate | Message::Input(_) | Message::Truth(_) => {}
    Message::Event(
        Event::Configured(_)
        | Event::StepBegun(_)
        | Event::Walls(_)
        | Event::Particles(_)
        | Event::StepDone(_)
        | Event::OdometryReset { .. },
    )
    | Message::Answer { .. }
    | Message::Boot(_)
    | Message::Status(_)
    | Message::Health(_)
    | Message::Offsets(_)
    | Message::PostMortem(_)
    | Message::Supervision(_) => {}
};

/// Where the page explains the variants of each enum of the stream. The first say what a
/// run is or finds; those of their words that tell of faults are named in the test.
const ENUMS: [(&str, Option<&str>); 19] = [
    ("Sample", None),
    ("StepRule", None),
    ("SurvivalRule", None),
    ("NothingDraw", None),
    ("SampleSelection", None),
    ("Source", None),
    ("InputError", Some("## An input was refused")),
    ("SensorState", Some("## A sensor")),
    ("SensorFault", Some("## A sensor")),
    ("OffsetRefusal", Some("## A sensor")),
    ("OffsetOrigin", Some("## A sensor")),
    ("BusState", Some("## A bus of sensors")),
    ("CanState", Some("## The robot's own bus")),
    ("Mode", Some("## The image itself")),
    ("ImageCheck", Some("## The image itself")),
    ("FailureCause", Some("## The image itself")),
    ("ResetCause", Some("## The image itself")),
    ("ClockSource", Some("## The image itself")),
    ("SeedSource", Some("## The image itself")),
];

/// The same of structs and their fields.
const STRUCTS: [(&str, Option<&str>); 25] = [
    ("Boot", None),
    ("Config", None),
    ("DifferentialDrive", None),
    ("FilterParameters", None),
    ("Obstacle", None),
    ("Offsets", None),
    ("Particles", None),
    ("Photometry", None),
    ("Point", None),
    ("Pose", None),
    ("Ring", None),
    ("StepBegun", None),
    ("StepDone", None),
    ("Walls", None),
    // Their fields are those below.
    ("Health", None),
    ("Status", None),
    ("NodeStatus", Some("")),
    ("BoardStatus", Some("")),
    ("OffsetReport", Some("## A sensor")),
    ("SensorHealth", Some("## A sensor")),
    ("BusHealth", Some("## A bus of sensors")),
    ("CanHealth", Some("## The robot's own bus")),
    ("PostMortem", Some("## The image itself")),
    ("CoreRegisters", Some("## The image itself")),
    ("Supervision", Some("## The image itself")),
];

/// The page from a heading to the next of its kind; the whole page for an empty one.
fn section(heading: &str) -> &'static str {
    if heading.is_empty() {
        return PAGE;
    }
    let parts = PAGE.split_once(&format!("\n{heading}\n"));
    assert!(parts.is_some(), "the page has no {heading:?}");
    let (_, from) = parts.unwrap();
    from.split("\n## ").next().unwrap()
}

/// Panics with those that a section does not hold as `code`.
fn assert_explained_in(section: &str, words: impl IntoIterator<Item = String>) {
    let lacking: Vec<String> = words
        .into_iter()
        .filter(|word| !section.contains(&format!("`{word}`")))
        .collect();
    assert!(lacking.is_empty(), "the page lacks {lacking:#?}");
}

fn assert_explained(words: impl IntoIterator<Item = String>) {
    assert_explained_in(PAGE, words);
}

/// Panics with a type that has no place on the page, or with words that are not there.
fn assert_all_have_their_place(
    found: impl Iterator<Item = Named>,
    places: &[(&str, Option<&str>)],
) {
    let mut names = BTreeSet::new();
    for (name, words) in found {
        names.insert(name);
        let place = places.iter().find(|(placed, _)| *placed == name);
        assert!(place.is_some(), "where is {name} explained?");
        if let Some((_, Some(heading))) = place {
            assert_explained_in(section(heading), words.iter().map(ToString::to_string));
        }
    }
    for (placed, _) in places {
        assert!(names.contains(placed), "the stream has no {placed}");
    }
}

#[test]
fn every_word_of_the_stream_is_explained() {
    let shape = Shape::of::<(Payloads, Option<InputError>)>();
    assert_all_have_their_place(shape.enums(), &ENUMS);
    let others = ["BrokeOff", "Limit", "degenerate", "Median"];
    assert_explained(others.map(str::to_owned));
}

#[test]
fn every_counter_and_field_of_how_the_board_is_is_explained() {
    let shape = Shape::of::<Payloads>();
    assert_all_have_their_place(shape.structs(), &STRUCTS);
}

#[test]
fn every_sentence_about_a_refused_input_or_offset_is_on_the_page() {
    let of_inputs = InputError::ALL.map(|fault| fault.to_string());
    let lacking: Vec<_> = of_inputs.iter().filter(|it| !PAGE.contains(*it)).collect();
    assert!(lacking.is_empty(), "the page lacks {lacking:#?}");
    let refusals = [
        OffsetRefusal::NotDelivering,
        OffsetRefusal::Unsteady(57),
        OffsetRefusal::OutOfRange(1203),
        OffsetRefusal::AboveRing(145),
        OffsetRefusal::AboveStored(62),
    ];
    for refusal in &refusals {
        match refusal {
            OffsetRefusal::NotDelivering
            | OffsetRefusal::Unsteady(_)
            | OffsetRefusal::OutOfRange(_)
            | OffsetRefusal::AboveRing(_)
            | OffsetRefusal::AboveStored(_) => {}
        }
    }
    assert_explained(refusals.map(|refusal| refusal.to_string()));
}

#[test]
fn every_message_about_a_board_is_explained() {
    let all = [
        LinkError::Start("/dev/ttyUSB0: No such file or directory".to_owned()),
        LinkError::MostlyNoise,
        LinkError::Write(Error::other("Input/output error")),
        LinkError::Gone,
        LinkError::Interrupted,
        LinkError::NoBoot,
        LinkError::OtherSession,
        LinkError::Version { board: 1 },
        LinkError::NoAnswer { input: 12 },
        LinkError::Silent,
        LinkError::KeepsResetting { resets: 100 },
        LinkError::Refused(InputError::SafeMode),
        LinkError::Restarted { input: 12 },
    ];
    for error in &all {
        match error {
            LinkError::Start(_)
            | LinkError::MostlyNoise
            | LinkError::Write(_)
            | LinkError::Gone
            | LinkError::Interrupted
            | LinkError::NoBoot
            | LinkError::OtherSession
            | LinkError::Version { .. }
            | LinkError::NoAnswer { .. }
            | LinkError::Silent
            | LinkError::KeepsResetting { .. }
            | LinkError::Refused(_)
            | LinkError::Restarted { .. } => {}
        }
    }
    // The host's version changes with the sources, the page does not.
    let (host, on_page) = (format!("this host {WIRE_VERSION}"), "this host N");
    assert_explained(all.map(|error| error.to_string().replace(&host, on_page)));
    assert_explained([Imbalance::Contradicted(2).to_string()]);
}

#[test]
fn every_reason_why_a_piece_of_a_recording_is_left_out_is_explained() {
    let all = [
        Reason::EmptyLine,
        Reason::LongLine,
        Reason::ZeroByte,
        Reason::NotUtf8,
        Reason::Cut,
        Reason::FieldCount,
        Reason::NotAnInteger,
        Reason::OutOfRange,
        Reason::Repeated,
        Reason::Broken(FrameError::TooLong),
        Reason::Broken(FrameError::TooShort),
        Reason::Broken(FrameError::NotCobs),
        Reason::Broken(FrameError::BadChecksum),
        Reason::Broken(FrameError::NotAMessage),
        Reason::Lost,
        Reason::StartedOver,
        Reason::Backward,
        Reason::NotFinite,
        Reason::BadConfiguration,
        Reason::BeforeConfiguration,
        Reason::SecondRun,
        Reason::BadScenario,
        Reason::BadFaults,
        Reason::Full,
    ];
    for reason in all {
        match reason {
            Reason::Broken(
                FrameError::TooLong
                | FrameError::TooShort
                | FrameError::NotCobs
                | FrameError::BadChecksum
                | FrameError::NotAMessage,
            )
            | Reason::EmptyLine
            | Reason::LongLine
            | Reason::ZeroByte
            | Reason::NotUtf8
            | Reason::Cut
            | Reason::FieldCount
            | Reason::NotAnInteger
            | Reason::OutOfRange
            | Reason::Repeated
            | Reason::Lost
            | Reason::StartedOver
            | Reason::Backward
            | Reason::NotFinite
            | Reason::BadConfiguration
            | Reason::BeforeConfiguration
            | Reason::SecondRun
            | Reason::BadScenario
            | Reason::BadFaults
            | Reason::Full => {}
        }
    }
    assert_explained(all.iter().map(ToString::to_string));
}

/// The fault numbers that the names of tests begin with, in capitals.
fn numbers_of_tests() -> BTreeSet<String> {
    let mut numbers = BTreeSet::new();
    for place in ["src", "tests", "sim-harness/src", "sim-harness/tests"] {
        for (_, text) in common::rust_files(place) {
            for name in text.split("fn ").skip(1) {
                // One test may show several: f02_f03_f06_...
                for word in name.split('_') {
                    let Some(number) = word.strip_prefix('f') else {
                        break;
                    };
                    let is_number = number.len() == 2
                        && number.starts_with(|first: char| first.is_ascii_digit())
                        && number.chars().all(|digit| digit.is_ascii_hexdigit());
                    if !is_number {
                        break;
                    }
                    numbers.insert(format!("F{}", number.to_ascii_uppercase()));
                }
            }
        }
    }
    numbers
}

#[test]
fn every_number_of_the_page_has_a_test_or_a_reason_for_none() {
    let tested = numbers_of_tests();
    let (_, index) = PAGE.split_once("## By number").unwrap();
    let rows = index.lines().filter(|line| line.starts_with("| F"));
    let mut listed = BTreeSet::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let (number, shown) = (cells[1], cells[4]);
        assert!(listed.insert(number.to_owned()), "{number} is there twice");
        // The one is a wiring that no bus can tell, the other a program that links.
        let is_elsewhere = shown == "bench" || number == "F5B";
        assert!(
            is_elsewhere || tested.contains(number),
            "{number} has no test"
        );
    }
    let unlisted: Vec<_> = tested.difference(&listed).collect();
    assert!(unlisted.is_empty(), "the page lacks {unlisted:?}");
    assert!(listed.len() > 55, "{} rows", listed.len());
}

#[test]
fn every_word_that_the_index_names_is_explained_above_it() {
    let (above, index) = PAGE.split_once("## By number").unwrap();
    let named: BTreeSet<&str> = index.split('`').skip(1).step_by(2).collect();
    let lacking: Vec<_> = named
        .iter()
        .filter(|word| !word.starts_with("cargo "))
        .filter(|word| !above.contains(&format!("`{word}`")))
        .collect();
    assert!(lacking.is_empty(), "not explained: {lacking:?}");
}
