//! What reading the robot costs the core: counted where it can be, else reckoned.
//!
//! The example `sampling` counts the instructions of the image's own sampler in an
//! emulator. What an emulator does not have is added here, with its arithmetic; the sum
//! and its parts stand in docs/hardware.md, "The sampling's share". None of it was
//! measured on silicon.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use crate::common;

/// Core clock cycles a second.
const CORE_HZ: f64 = 168e6;

/// Counts of the emulator's timer an instruction: 168 MHz at one a nanosecond.
const COUNTS_PER_INSTRUCTION: f64 = 0.168;

/// Assumed: cycles an instruction of compiled code on a Cortex-M4, five wait states
/// behind the chip's flash cache included.
const CYCLES_PER_INSTRUCTION: f64 = 1.4;

/// Rounds a second, both buses in each; sensors a round.
const ROUNDS: f64 = 125.0;
const READOUTS: f64 = ROUNDS * 8.0;

/// Cycles of an interrupt besides what is counted: 12 to enter, 12 to leave (no wait
/// states, no floating point saved), the framework's 15 instructions of raising and
/// lowering the priority, and 4 more for each of its four barriers.
const INTERRUPT: f64 = 12.0 + 12.0 + 15.0 * CYCLES_PER_INSTRUCTION + 4.0 * 4.0;

/// Accesses to a unit's registers in a readout of a sensor: 14 to select, 16 for each of
/// two read-backs, 23, 28 and 24 for the reads of 1, 4 and 2 bytes; and the cycles of
/// each on the peripheral bus beyond a load from RAM.
const ACCESSES: f64 = 14.0 + 2.0 * 16.0 + 23.0 + 28.0 + 24.0;
const ACCESS: f64 = 10.0;

/// A readout has six stops, each looked for during 4 us, and three repeated starts, each of
/// which keeps its event up for 2.5 us and half a useless call.
const STOPS: f64 = 6.0;
const STOP_S: f64 = 4e-6;
const RESTARTS: f64 = 3.0;
const RESTART_S: f64 = 2.5e-6;

/// Polls a second; instructions of the timer's interrupt, twice, and of the framework's
/// executor for each (counted in an execution trace of the image); interrupts of each.
const POLLS: f64 = 2_000.0;
const EXECUTOR: f64 = 382.0;
const POLL_INTERRUPTS: f64 = 3.0;

/// Calls and instructions a call, by name, as the example counted them.
fn counted() -> HashMap<String, (f64, f64)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(root)
        .args(["build", "--release", "--quiet", "--locked"])
        .args(["--target", "thumbv7em-none-eabihf", "--example", "sampling"])
        .args(["--target-dir", "target"])
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status()
        .unwrap();
    assert!(status.success(), "the example was not built");
    let output = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0,sleep=off"])
        .args(["-no-reboot", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "stdio", "-kernel"])
        .arg(root.join("target/thumbv7em-none-eabihf/release/examples/sampling"))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: HashMap<String, (f64, f64)> = text
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            let [name, calls, counts] = words[..] else {
                unreachable!("{text}")
            };
            (
                name.to_owned(),
                (calls.parse().unwrap(), counts.parse().unwrap()),
            )
        })
        .collect();
    // Every round delivered, from every sensor.
    assert_eq!(rows["rounds"], (1_000.0, 8_000.0), "{text}");
    let (calls, counts) = rows["nothing"];
    let overhead = counts / calls;
    rows.into_iter()
        .map(|(name, (calls, counts))| {
            let each = (counts / calls - overhead) / COUNTS_PER_INSTRUCTION;
            (name, (calls, each))
        })
        .collect()
}

/// The rows of the page's table: what, and its share in percent.
fn page() -> HashMap<String, f64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/hardware.md");
    let text = std::fs::read_to_string(path).unwrap();
    let (_, section) = text.split_once("## The sampling's share").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().filter_map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let share = cells.last()?.strip_suffix(" %")?.parse().ok()?;
        Some((cells.first()?.trim_matches('*').to_owned(), share))
    });
    rows.collect()
}

#[test]
fn the_sampling_takes_a_tenth_of_the_core_at_most_as_on_the_page() {
    if !common::can_emulate() {
        return;
    }
    let counted = counted();
    let (events, event) = counted["event"];
    let (polls, poll) = counted["poll"];
    let (frames, frame) = counted["frame"];
    let (_, useless) = counted["useless"];
    // 1000 rounds last 8 s.
    let events = events / 8.0;
    assert!((events - READOUTS * 29.0).abs() < 1.0, "{events} events");
    assert!((polls / 8.0 - POLLS).abs() < 2.0, "{polls} polls");

    let cycles = |instructions: f64| instructions * CYCLES_PER_INSTRUCTION;
    let shares = [
        ("events of the buses", events * cycles(event)),
        ("their interrupts", events * INTERRUPT),
        ("access to the units", READOUTS * ACCESSES * ACCESS),
        ("looking for stops", READOUTS * STOPS * STOP_S * CORE_HZ),
        (
            "repeated starts",
            READOUTS * RESTARTS * (RESTART_S * CORE_HZ + cycles(useless) / 2.0),
        ),
        ("poll", POLLS * cycles(poll)),
        (
            "timer and executor",
            POLLS * (cycles(EXECUTOR) + POLL_INTERRUPTS * 24.0),
        ),
        (
            "frames of the robot's bus",
            frames / 8.0 * (cycles(frame) + INTERRUPT),
        ),
    ]
    .map(|(name, cycles)| (name, 100.0 * cycles / CORE_HZ));
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let story = format!(
        "event {event:.0}, useless {useless:.0}, poll {poll:.0}, frame {frame:.0}, clock \
         {:.0} instructions; {shares:.2?}; {total:.2} %",
        counted["clock"].1
    );

    assert!(total <= 10.0, "{story}");
    let page = page();
    for (name, share) in shares.into_iter().chain([("all", total)]) {
        let written = page.get(name).copied().unwrap_or(f64::NAN);
        // Two hundredths of a compiler's mood, and the rounding.
        let is_so = (written - share).abs() <= 0.05 + 0.02 * share;
        assert!(is_so, "the page says {written} % for {name}: {story}");
    }
}
