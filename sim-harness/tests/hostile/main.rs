//! Hostile bytes through every door: the fuzz targets' checks, without a fuzzer.
//!
//! Each test runs a target's check over its seeds, over its corpus, and over mutations
//! of both from a fixed seed. `IPF_HOSTILE_RUNS` multiplies the mutations.
//! `tests/fuzz` runs the same checks under a fuzzer that sees which branches it takes.

#![expect(clippy::panic, reason = "a check that fails says why")]

mod mutation;

#[path = "../../../tests/fuzz/src/senses.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod acquisition;
#[path = "../../../tests/fuzz/src/framing.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod framing;
#[path = "../../../tests/fuzz/src/recordings.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod recordings;
#[path = "../../../tests/fuzz/src/scenarios.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod scenarios;
#[path = "../../../tests/fuzz/src/seeds.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod seeds;
#[path = "../../../tests/fuzz/src/terminal.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod terminal;
#[path = "../../../tests/fuzz/src/wire.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod wire;

#[path = "../../../tests/fuzz/src/words.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod words;

use std::path::Path;

use amiro_ipf::random::Generator;
use mutation::mutate;

/// The seed of the mutations.
const SEED: u64 = 20_160_811;

/// Says which bytes a check was given if it fails.
struct Witness<'b>(&'b str, &'b [u8]);

impl Drop for Witness<'_> {
    #[expect(clippy::disallowed_macros, reason = "a failing test's own output")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            let digits: String = self.1.iter().map(|byte| format!("{byte:02x}")).collect();
            eprintln!("target {}, bytes (hexadecimal): {digits}", self.0);
        }
    }
}

fn run(target: &str, check: fn(&[u8]), bytes: &[u8]) {
    let _witness = Witness(target, bytes);
    check(bytes);
}

/// The corpus and the seeds, then so many mutations of them.
fn run_all(target: &str, check: fn(&[u8]), mutations: u32) {
    let known = corpus(target);
    assert!(!known.is_empty(), "no corpus for {target}");
    for bytes in &known {
        run(target, check, bytes);
    }
    let factor = std::env::var("IPF_HOSTILE_RUNS").map_or(1, |factor| factor.parse().unwrap());
    let mut generator = Generator::seeded(SEED);
    for _ in 0..mutations * factor {
        run(target, check, &mutate(&known, &mut generator));
    }
}

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fuzz/corpus");
    let mut known = seeds::of(target);
    if let Ok(files) = std::fs::read_dir(folder.join(target)) {
        let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
        paths.sort();
        known.extend(paths.iter().map(|path| std::fs::read(path).unwrap()));
    }
    known
}

#[test]
fn every_target_has_its_seeds() {
    for (target, least) in seeds::TARGETS.into_iter().zip([30, 3, 4, 6, 3, 6]) {
        let count = seeds::of(target).len();
        assert!(count >= least, "{target}: {count}");
    }
}

#[test]
fn f66_any_bytes_through_the_decoder_are_refused_or_read_in_one_way() {
    run_all("wire", wire::check, 60_000);
}

#[test]
fn f66_a_board_survives_any_stream_and_steps_afterwards() {
    run_all("terminal", terminal::check, 3_000);
}

#[test]
fn any_bytes_as_a_recording_are_refused_or_orderly() {
    run_all("recordings", recordings::check, 3_000);
}

#[test]
fn any_text_as_a_scenario_is_refused_or_can_be_driven() {
    run_all("scenarios", scenarios::check, 1_500);
}

#[test]
fn the_acquisition_recovers_from_any_answers_and_frames() {
    run_all("senses", acquisition::check, 1_500);
}

#[test]
fn any_fault_words_are_refused_or_print_as_they_were_read() {
    run_all("words", words::check, 10_000);
}
