//! The memory of a replay does not grow with the length of its recording.
//!
//! Each replay is a process of its own, whose peak resident set Linux reports. The bound is
//! on the difference between a short and a long recording, so that it does not depend on
//! the machine or the build. `IPF_LONG=1` replays recordings of 1 GB, and holds the peak
//! itself under 150 MB.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use amiro_ipf::filter::Outcome;
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{Encoder, Message, TruthMessage};
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::{Config, Event, Input, ParticleEvent, Particles, StepBegun, StepDone};
use sim_harness::log::RecordingWriter;

const SCENARIO: &str = "name = \"memory\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\n\
    speed_m_per_s = 0.08\nstart = [0, 0, 0]\n[[box]]\nmin = [0.2, 0.2]\nmax = [0.3, 0.3]\n";

/// Radius of the circle that is driven, metres.
const RADIUS_M: f64 = 0.3;

/// Rows between two poses: the robot stands meanwhile, which needs no step of the filter.
const ROWS_A_POSE: u64 = 10;

/// Where a robot on the circle is after so many rows of the odometry's resolution.
fn pose_at(row: u64) -> (f64, f64, f64) {
    let turn = (row / ROWS_A_POSE) as f64 * 256e-6 / RADIUS_M;
    let heading = turn.rem_euclid(std::f64::consts::TAU);
    (
        RADIUS_M * heading.sin(),
        RADIUS_M * (1.0 - heading.cos()),
        heading,
    )
}

fn counts_at(row: u64) -> [i32; SENSORS] {
    std::array::from_fn(|sensor| 300 + ((7 * row + 31 * sensor as u64) % 97) as i32)
}

/// AMiRo's text of at least so many bytes.
fn write_text(path: &Path, bytes: u64) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let columns: Vec<_> = (0..8).map(|sensor| format!("PRV {sensor}")).collect();
    writeln!(file, "{}\tX [ym]\tY [ym]\tTheta [yrad]", columns.join("\t"))?;
    let mut written = 0;
    let mut row = 0;
    while written < bytes {
        let counts = counts_at(row).map(|counts| counts.to_string()).join("\t");
        let (x, y, heading) = pose_at(row);
        let urad = (heading * 1e6).round();
        let line = format!(
            "{counts}\t{:.0}\t{:.0}\t{urad}\n",
            x * 1e6 + 0.5,
            y * 1e6 + 0.5
        );
        file.write_all(line.as_bytes())?;
        written += line.len() as u64;
        row += 1;
    }
    file.flush()
}

/// Frames of at least so many bytes: true poses, inputs and answers in equal parts.
fn write_frames(path: &Path, bytes: u64) -> io::Result<()> {
    let mut writer = RecordingWriter::new(BufWriter::new(File::create(path)?))?;
    writer.write_truth(&TruthMessage::Seed(1))?;
    writer.write_scenario(SCENARIO)?;
    // The settings of the recording, so that its events are compared.
    writer.write_input(&Input::Configure(Config {
        particles_per_sensor: 20,
        ..Config::default()
    }))?;
    let mut board = Encoder::new(7);
    let mut answer = |writer: &mut RecordingWriter<_>, event: Event| {
        writer.write_frames(board.encode(&Message::Event(event)))
    };
    let samples = [Sample::Missing; SENSORS];
    answer(
        &mut writer,
        Event::StepBegun(StepBegun {
            index: 0,
            stamp_us: 0,
            pose: Pose::default(),
            samples,
        }),
    )?;
    let mut particles = Particles::default();
    let outcome = ParticleEvent::new((6400, 0), Outcome::RejectedFree);
    particles.outcomes.resize(8, outcome).unwrap();
    // A row takes some 120 bytes.
    for row in 0..bytes / 120 {
        let stamp_us = row * 8_000;
        let (x, y, heading) = pose_at(row);
        let pose = Pose::new(x as f32, y as f32, heading as f32);
        writer.write_truth(&TruthMessage::Pose { stamp_us, pose })?;
        writer.write_input(&Input::Odometry { stamp_us, pose })?;
        let samples = counts_at(row).map(Sample::Counts);
        writer.write_input(&Input::Proximity { stamp_us, samples })?;
        answer(&mut writer, Event::Particles(particles.clone()))?;
    }
    let done = StepDone {
        index: 0,
        digest: 0,
        past_gate: 0,
        below_gate: 0,
        free: 0,
        unobserved: 0,
        departed: 0,
        degenerate: false,
    };
    answer(&mut writer, Event::StepDone(done))?;
    writer.finish()?.flush()
}

/// Peak resident set of a process until its end, bytes.
fn peak_of(child: &mut Child) -> u64 {
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let high = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = high.and_then(|high| high.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) * 1024);
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

/// A format: how a recording of so many bytes is written, the options with which it is
/// replayed and the exit code that is expected.
struct Format {
    write: fn(&Path, u64) -> io::Result<()>,
    options: &'static [&'static str],
    code: i32,
}

/// Peak resident set of a replay, bytes, with the recording as a file or through a pipe.
fn replay(format: &Format, folder: &Path, recording: &Path, is_piped: bool) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ipf"));
    command
        .arg("replay")
        .args(format.options)
        .arg("--out")
        .arg(folder.join("out"))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // A file as standard input is read as a pipe is: once.
    let mut child = if is_piped {
        let recording = File::open(recording).unwrap();
        command.arg("-").stdin(recording).spawn()
    } else {
        command.arg(recording).spawn()
    }
    .unwrap();
    let peak = peak_of(&mut child);
    let code = child.wait().unwrap().code();
    assert_eq!(code, Some(format.code), "{}", recording.display());
    let stream = fs::metadata(folder.join("out/stream.ipf")).unwrap().len();
    assert!(stream > fs::metadata(recording).unwrap().len() / 4);
    peak
}

/// Replays short and long recordings of a format.
fn assert_bounded(format: &Format) {
    let is_long = std::env::var_os("IPF_LONG").is_some();
    let (short, long) = if is_long {
        (2_000_000, 1_000_000_000)
    } else {
        (2_000_000, 16_000_000)
    };
    let folder = tempfile::tempdir().unwrap();
    let peak = |bytes, is_piped| {
        let recording = folder.path().join("recording");
        (format.write)(&recording, bytes).unwrap();
        assert!(fs::metadata(&recording).unwrap().len() >= bytes * 9 / 10);
        replay(format, folder.path(), &recording, is_piped)
    };
    let of_short = peak(short, false);
    for is_piped in [false, true] {
        let of_long = peak(long, is_piped);
        let mb = |bytes: u64| bytes / 1_000_000;
        let found = format!("{} and {} MB, piped: {is_piped}", mb(of_short), mb(of_long));
        if is_long {
            assert!(of_long < 150_000_000, "{found}");
        } else {
            // Temporary files begin beyond a mebibyte each. A vector of the long one's inputs
            // alone would take twice its bytes, one of its answers as many as it has.
            assert!(of_long < of_short + 8_000_000, "{found}");
        }
    }
}

#[test]
fn amiros_text_of_any_length_is_replayed_in_the_same_memory() {
    assert_bounded(&Format {
        write: write_text,
        options: &["--particles", "20"],
        code: 0,
    });
}

#[test]
fn frames_of_any_length_are_replayed_in_the_same_memory() {
    // The answers are none that the filter gives: the comparison fails.
    assert_bounded(&Format {
        write: write_frames,
        options: &[],
        code: 1,
    });
}

#[test]
fn amiros_text_of_any_length_is_mapped_in_the_same_memory() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("recording");
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/amiro.toml");
    let peak = |bytes| {
        write_text(&recording, bytes).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_ipf"));
        command.arg("map").arg(&recording).args(["--rig", rig]);
        command.arg("--out").arg(folder.path().join("map"));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let child = child.as_mut().unwrap();
        let peak = peak_of(child);
        assert_eq!(child.wait().unwrap().code(), Some(0));
        peak
    };
    let (of_short, of_long) = (peak(2_000_000), peak(16_000_000));
    // As for a replay; the path and the map of the circle are small.
    let found = format!("{of_short} and {of_long} bytes");
    assert!(of_long < of_short + 8_000_000, "{found}");
}
