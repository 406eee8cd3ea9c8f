//! The page of faults, held against the code: every word is explained, every number has
//! its test.

mod common;

use std::collections::BTreeSet;

use amiro_ipf::can::CanState;
use amiro_ipf::driver::{OffsetOrigin, OffsetRefusal, SensorFault, SensorState};
use amiro_ipf::fault::Fault;
use amiro_ipf::health::BusState;
use amiro_ipf::seed::SeedSource;
use amiro_ipf::supervision::{Cause, ImageCheck, Mode};

const PAGE: &str = include_str!("../docs/faults.md");

/// The variant's name, without its fields.
fn name(word: &impl std::fmt::Debug) -> String {
    let name = format!("{word:?}");
    name.split(['(', ' ']).next().unwrap().to_owned()
}

#[test]
fn every_word_of_the_stream_is_explained() {
    let mut words: Vec<String> = Fault::ALL.iter().map(name).collect();
    words.extend(
        [
            SensorState::Missing,
            SensorState::NoData,
            SensorState::TooClose,
            SensorState::Nothing,
            SensorState::Good,
            SensorState::Stale,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            SensorFault::WrongIdentity,
            SensorFault::Garbage,
            SensorFault::Dazzled,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            OffsetRefusal::NotDelivering,
            OffsetRefusal::Unsteady(0),
            OffsetRefusal::OutOfRange(0),
            OffsetRefusal::AboveRing(0),
            OffsetRefusal::AboveStored(0),
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            OffsetOrigin::Defaults,
            OffsetOrigin::Stored,
            OffsetOrigin::Measured,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            BusState::Silent,
            BusState::Working,
            BusState::Failing,
            BusState::HeldLow,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            CanState::Absent,
            CanState::Joining,
            CanState::On,
            CanState::BusOff,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            Mode::Normal,
            Mode::SafeAfterDeaths,
            Mode::SafeForImage,
            Mode::ShuttingDown,
        ]
        .iter()
        .map(name),
    );
    words.extend(
        [
            Cause::Panic,
            Cause::Fault,
            Cause::StackOverflow,
            Cause::Watchdog,
            Cause::Clock,
        ]
        .iter()
        .map(name),
    );
    words.extend([ImageCheck::Unmarked, ImageCheck::Damaged].iter().map(name));
    words.extend(
        [SeedSource::RandomUnit, SeedSource::UniqueNumber]
            .iter()
            .map(name),
    );
    for counter in [
        "sent_frames",
        "dropped_frames",
        "broken_frames",
        "lost_bytes",
        "overruns",
        "recoveries",
        "ignored",
        "unsent",
        "BrokeOff",
        "Limit",
    ] {
        words.push(counter.to_owned());
    }
    let lacking: Vec<_> = words
        .iter()
        .filter(|word| !PAGE.contains(&format!("`{word}`")))
        .collect();
    assert!(lacking.is_empty(), "the page lacks {lacking:?}");
}

/// The fault numbers that begin the names of tests, in lower case.
fn numbers_of_tests() -> BTreeSet<String> {
    let mut numbers = BTreeSet::new();
    for place in ["src", "tests", "sim-harness/src"] {
        for (_, text) in common::rust_files(place) {
            let after_test = text.split("fn f").skip(1);
            numbers.extend(after_test.filter_map(|rest| {
                let (number, _) = rest.split_once('_')?;
                let is_number = number.len() == 2
                    && number.starts_with(|first: char| first.is_ascii_digit())
                    && number.chars().all(|digit| digit.is_ascii_hexdigit());
                is_number.then(|| format!("F{}", number.to_ascii_uppercase()))
            }));
        }
    }
    numbers
}

#[test]
fn every_number_of_the_page_has_a_test_or_says_why_not() {
    let tested = numbers_of_tests();
    let (_, index) = PAGE.split_once("## By number").unwrap();
    let rows = index.lines().filter(|line| line.starts_with("| F"));
    let mut listed = BTreeSet::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let (number, shown) = (cells[1], cells[4]);
        listed.insert(number.to_owned());
        // The one is a wiring that no bus can tell, the other a program that links.
        let is_elsewhere = shown == "bench" || number == "F5B";
        assert!(
            is_elsewhere || tested.contains(number),
            "{number} has no test"
        );
    }
    // Recordings and files have pages of their own.
    let unlisted: Vec<_> = tested
        .iter()
        .filter(|number| !number.starts_with("F8") && !listed.contains(*number))
        .collect();
    assert!(unlisted.is_empty(), "the page lacks {unlisted:?}");
    assert!(listed.len() > 55, "{} rows", listed.len());
}
