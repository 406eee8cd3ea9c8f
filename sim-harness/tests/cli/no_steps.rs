//! `cargo ipf replay` of recordings that lead to no step: why, and with exit code 2.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::{Config, Input, StepRule};
use sim_harness::log::RecordingWriter;

fn pose(row: u64, x: f32) -> Input {
    Input::Odometry {
        stamp_us: 100_000 * row,
        pose: Pose::new(x, 0.0, 0.0),
    }
}

fn reading(row: u64, sample: Sample) -> Input {
    Input::Proximity {
        stamp_us: 100_000 * row,
        samples: [sample; SENSORS],
    }
}

/// Replays a recording: exit code, what was printed, and whether anything was written.
fn replay(config: Config, inputs: &[Input], options: &[&str]) -> (Option<i32>, String, bool) {
    let folder = tempfile::tempdir().unwrap();
    let (drive, out) = (folder.path().join("drive.ipf"), folder.path().join("out"));
    let mut writer = RecordingWriter::new(File::create(&drive).unwrap()).unwrap();
    writer.write_input(&Input::Configure(config)).unwrap();
    for input in inputs {
        writer.write_input(input).unwrap();
    }
    writer.finish().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .arg("replay")
        .arg(&drive)
        .arg("--out")
        .arg(&out)
        .args(["--particles", "20"])
        .args(options)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let shown = [output.stdout.as_slice(), &output.stderr].concat();
    let shown = String::from_utf8(shown).unwrap();
    (output.status.code(), shown, Path::new(&out).exists())
}

#[test]
fn a_recording_without_steps_is_refused_with_the_reason_and_nothing_is_written() {
    let poses: Vec<_> = (0_u8..20)
        .map(|row| pose(u64::from(row), 0.01 * f32::from(row)))
        .collect();
    let readings: Vec<_> = (0..20)
        .map(|row| reading(row, Sample::Counts(300)))
        .collect();
    let blind = (0..20).map(|row| reading(row, Sample::Missing));
    let both: Vec<_> = poses.iter().copied().zip(blind).collect();
    let blind: Vec<_> = both
        .into_iter()
        .flat_map(|(pose, reading)| [pose, reading])
        .collect();
    let cases: [(&[Input], &str); 4] = [
        (
            &readings,
            "drive.ipf: no step: there are 20 readings and no odometry",
        ),
        (
            &poses,
            "drive.ipf: no step: there are 20 poses or wheel speeds and no reading",
        ),
        (&blind, " inputs refused: NoSensor, "),
        (
            &[
                reading(0, Sample::Counts(300)),
                pose(30, 0.0),
                pose(31, 0.1),
            ],
            "; 1 inputs refused: NoPose, ",
        ),
    ];
    for (inputs, words) in cases {
        let (code, shown, has_written) = replay(Config::default(), inputs, &[]);
        assert_eq!(code, Some(2), "{words}: {shown}");
        assert!(shown.contains(words), "{words}: {shown}");
        assert!(!has_written, "{words}");
    }
}

#[test]
fn a_recording_without_the_ticks_of_its_step_rule_is_refused_and_fixed_ticks_help() {
    let config = Config {
        step_rule: StepRule::PerTick { own_clock: false },
        ..Config::default()
    };
    let inputs: Vec<_> = (0..20)
        .flat_map(|row| [pose(row, 0.0), reading(row, Sample::Counts(300))])
        .collect();
    let (code, shown, has_written) = replay(config, &inputs, &[]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(
        shown.contains("drive.ipf: no step: the filter steps per tick"),
        "{shown}"
    );
    assert!(!has_written);
    let (code, shown, has_written) = replay(config, &inputs, &["--fixed"]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(has_written);
}
