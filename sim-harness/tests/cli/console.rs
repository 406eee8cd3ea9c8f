//! What the program writes to standard output and standard error: no control character
//! of foreign text, no panic when either cannot be written, and true exit codes.

#![cfg(unix)]

use std::ffi::OsString;
use std::fs::{self, File};
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use amiro_ipf::board::supervision::{FailureCause, PostMortem};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{Encoder, Message};
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::{Config, Input};
use sim_harness::log::RecordingWriter;
use tempfile::TempDir;

use crate::common;

/// Text that would clear a terminal, set its title, go back in the line and begin a line
/// of its own; with the eight-bit control sequence introducer too.
const HOSTILE: &str = "\x1b[2J\x1b]0;title\x07\u{9b}31mred\r\x7fEQUAL";

fn ipf() -> Command {
    Command::new(env!("CARGO_BIN_EXE_ipf"))
}

/// A folder for what a command reads and writes; removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.file(name);
        fs::write(&path, content).unwrap();
        path
    }
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenarios")
        .join(name)
}

/// A recording of the drive past a block.
fn drive(folder: &Folder) -> PathBuf {
    let out = folder.file("drive.ipf");
    let mut simulate = ipf();
    simulate.arg("simulate").arg(scenario("ssso.toml"));
    let output = simulate.arg("--out").arg(&out).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    out
}

/// A short recording with a text of faults, a scenario and the events of a board.
fn recording(faults: &str, scenario: Option<&str>, events: &[Message]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::new(&mut bytes).unwrap();
    if let Some(text) = scenario {
        writer.write_scenario(text).unwrap();
    }
    writer.write_faults(faults, 1).unwrap();
    writer
        .write_input(&Input::Configure(Config::default()))
        .unwrap();
    for stamp_us in (1..4).map(|number| 10_000 * number) {
        let pose = Pose::default();
        let samples = [Sample::Counts(3); SENSORS];
        for input in [
            Input::Odometry { stamp_us, pose },
            Input::Proximity { stamp_us, samples },
        ] {
            writer.write_input(&input).unwrap();
        }
    }
    let mut encoder = Encoder::new(7);
    for event in events {
        writer.write_frames(encoder.encode(event)).unwrap();
    }
    writer.finish().unwrap();
    bytes
}

/// That nothing but line ends and tabs controls a terminal, on either stream.
fn assert_harmless(what: &str, output: &Output) {
    assert_ne!(output.status.code(), Some(101), "{what}: {output:?}");
    for stream in [&output.stdout, &output.stderr] {
        let text = std::str::from_utf8(stream).unwrap();
        let is_control = |c: char| c.is_control() && c != '\n' && c != '\t';
        assert!(!text.contains(is_control), "{what}: {text:?}");
    }
    let printed = output.stdout.len() + output.stderr.len();
    assert!(printed > 0, "{what}: nothing was printed");
}

#[test]
fn no_text_of_a_recording_reaches_the_terminal_with_its_control_characters() {
    let folder = Folder::new("hostile-recording");
    let died = PostMortem::new(FailureCause::Panic, 1, 2).at(HOSTILE, 3);
    let header =
        "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\tX [ym]\tY [ym]\tTheta [yrad]\n";
    let named = format!("name = \"{HOSTILE}\"\nabout = \"\"\n");
    let files = [
        (
            "faults and place.ipf",
            recording(HOSTILE, None, &[Message::PostMortem(died)]),
        ),
        ("scenario.ipf", recording("", Some(HOSTILE), &[])),
        ("named.ipf", recording("", Some(&named), &[])),
        (
            "row.txt",
            format!("{header}1\t2\t3\t4\t5\t6\t7\t8\t9\t10\t{HOSTILE}\n").into_bytes(),
        ),
        (
            "header.txt",
            format!("{header}{HOSTILE}")
                .replace("[ym]", HOSTILE)
                .into_bytes(),
        ),
        ("nothing.txt", HOSTILE.repeat(20).into_bytes()),
    ];
    for (name, content) in files {
        let mut replay = ipf();
        replay.arg("replay").arg(folder.with(name, content));
        let output = replay
            .arg("--out")
            .arg(folder.file("out"))
            .output()
            .unwrap();
        assert_harmless(name, &output);
    }
}

#[test]
fn a_text_of_faults_cannot_print_a_line_of_its_own() {
    let folder = Folder::new("forged-line");
    let file = folder.with("a.ipf", recording("s3=off\nEQUAL: all of 9", None, &[]));
    let mut replay = ipf();
    replay
        .arg("replay")
        .arg(file)
        .arg("--out")
        .arg(folder.file("out"));
    let output = String::from_utf8(replay.output().unwrap().stdout).unwrap();
    assert!(output.contains("s3=off\\nEQUAL"), "{output}");
    assert!(!output.contains("\nEQUAL: all of 9"), "{output}");
}

#[test]
fn no_text_of_a_scenario_or_table_reaches_the_terminal_with_its_control_characters() {
    let folder = Folder::new("hostile-text");
    let known = fs::read_to_string(scenario("ssso.toml")).unwrap();
    let scenarios = [
        known.replacen("name = \"", &format!("name = \"{HOSTILE}"), 1),
        known.replacen("about = \"", &format!("about = \"{HOSTILE}"), 1),
        // Escaped as TOML has it, so that only the reader sees the characters.
        known.replacen("name = \"", "name = \"\\u001b[2J\\u0007", 1),
        format!("{HOSTILE} = 1"),
        format!("# {HOSTILE}\n{known}\n{HOSTILE}"),
    ];
    for (number, text) in scenarios.iter().enumerate() {
        assert_ne!(text, &known);
        let path = folder.with("scenario.toml", text);
        let mut simulate = ipf();
        simulate.arg("simulate").arg(&path);
        let output = simulate.arg("--out").arg(folder.file("x.ipf")).output();
        assert_harmless(&format!("simulate {number}"), &output.unwrap());
        let mut evaluate = ipf();
        evaluate.args([
            "evaluate",
            "--seeds",
            "100..101",
            "--methods",
            "plus",
            "--scenario",
        ]);
        let output = evaluate.arg(&path).output().unwrap();
        assert_harmless(&format!("evaluate {number}"), &output);
    }
    let tables = [
        format!("range_mm,angle_deg,counts,{HOSTILE}\n50,0,100,1\n"),
        format!("range_mm,angle_deg,counts\n50,{HOSTILE},100\n"),
        HOSTILE.to_owned(),
    ];
    for (number, text) in tables.iter().enumerate() {
        let path = folder.with("table.csv", text);
        let output = ipf().arg("calibrate").arg(&path).output().unwrap();
        assert_harmless(&format!("table {number}"), &output);
    }
}

#[test]
fn no_name_of_a_file_or_word_reaches_the_terminal_with_its_control_characters() {
    let folder = Folder::new("hostile-names");
    let drive = drive(&folder);
    let hostile = |end: &str| {
        let mut name = folder.0.path().as_os_str().to_owned().into_vec();
        // A slash would be another folder; the last byte is no UTF-8.
        name.extend(format!("/{HOSTILE}{end}").bytes());
        name.push(0xff);
        PathBuf::from(OsString::from_vec(name))
    };
    fs::copy(&drive, hostile(".ipf")).unwrap();
    fs::write(hostile(".toml"), "drive = 1").unwrap();
    let missing = hostile(".missing");
    let out = folder.file("out");
    let known = scenario("ssso.toml");
    let run = |what: &[&dyn AsRef<std::ffi::OsStr>]| {
        let mut command = ipf();
        what.iter().for_each(|word| _ = command.arg(word));
        let output = command.output().unwrap();
        let named: Vec<_> = what.iter().map(|word| word.as_ref()).collect();
        assert_harmless(&format!("{named:?}"), &output);
    };
    run(&[&"replay", &hostile(".ipf"), &"--out", &out]);
    run(&[&"replay", &missing, &"--out", &out]);
    run(&[&"replay", &drive, &"--out", &hostile(".out")]);
    run(&[&"replay", &drive, &"--out", &drive.join("x")]);
    run(&[&"replay", &drive, &"--on", &HOSTILE, &"--out", &out]);
    run(&[&"replay", &drive, &"--fault", &HOSTILE]);
    run(&[&"replay", &drive, &HOSTILE]);
    run(&[&"simulate", &hostile(".toml"), &"--out", &out]);
    run(&[&"simulate", &missing, &"--out", &out]);
    run(&[&"simulate", &known, &"--out", &hostile(".sim")]);
    run(&[&"simulate", &known, &"--out", &missing.join("x")]);
    run(&[&"record", &"--on", &HOSTILE, &"--out", &out]);
    run(&[&"record", &"--on", &HOSTILE, &"--out", &hostile(".ipf")]);
    run(&[&"offsets", &"--on", &HOSTILE]);
    run(&[&"image", &"--file", &hostile(".ipf")]);
    run(&[&"image", &"--file", &missing]);
    run(&[&"calibrate", &hostile(".ipf")]);
    run(&[&"calibrate", &missing, &"--fix", &HOSTILE]);
    run(&[&"evaluate", &"--scenario", &missing]);
    run(&[&"evaluate", &"--methods", &HOSTILE]);
    run(&[&HOSTILE]);
}

/// Starts a replay whose standard output is a pipe that nobody reads.
fn replay_into_closed_pipe(drive: &Path, out: &Path) -> Output {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut replay = ipf();
    replay.arg("replay").arg(drive).arg("--out").arg(out);
    replay.stdout(writer).stderr(Stdio::piped());
    replay.spawn().unwrap().wait_with_output().unwrap()
}

#[test]
fn a_replay_into_a_closed_pipe_writes_its_files_and_keeps_its_exit_code() {
    let folder = Folder::new("closed-pipe");
    let out = folder.file("out");
    let output = replay_into_closed_pipe(&drive(&folder), &out);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    for name in [
        "map.png",
        "map.pgm",
        "map.yaml",
        "summary.json",
        "stream.ipf",
    ] {
        assert!(out.join(name).is_file(), "{name}");
    }
}

#[test]
fn a_full_standard_output_is_reported_once_and_the_files_are_whole() {
    let Ok(full) = File::options().write(true).open("/dev/full") else {
        return;
    };
    let folder = Folder::new("full");
    let (drive, out) = (drive(&folder), folder.file("out"));
    let mut replay = ipf();
    replay.arg("replay").arg(&drive).arg("--out").arg(&out);
    let output = replay.stdout(full.try_clone().unwrap()).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(5), "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(
        told.starts_with("ipf: standard output cannot be written: "),
        "{told}"
    );
    assert!(out.join("map.png").is_file() && out.join("summary.json").is_file());
    // The code of a command that failed is its own.
    let mut missing = ipf();
    missing.args(["replay", "nowhere"]).stdout(full);
    assert_eq!(missing.status().unwrap().code(), Some(2));
}

#[test]
fn no_command_panics_where_nothing_can_be_printed() {
    let folder = Folder::new("unprintable");
    let drive = drive(&folder);
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/common/none.csv");
    let commands: [(&[&str], &Path); 8] = [
        (&["--help"], Path::new("record")),
        (&["help"], Path::new("replay")),
        (&["--version"], Path::new("")),
        (&["simulate", "--out", "/dev/null"], &scenario("ssso.toml")),
        (&["calibrate"], &table),
        (&["image", "--file"], &drive),
        (&["demo", "--out"], &folder.file("demo")),
        (&["record"], Path::new("--help")),
    ];
    for (words, path) in commands {
        for closes_errors in [false, true] {
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            let mut command = ipf();
            command.args(words).arg(path);
            command.stdout(writer.try_clone().unwrap());
            if closes_errors {
                command.stderr(writer);
            } else {
                command.stderr(Stdio::null());
            }
            let code = command.status().unwrap().code();
            assert!(matches!(code, Some(0..=2)), "{words:?} {path:?}: {code:?}");
        }
    }
}

#[test]
fn the_exit_codes_of_the_help_are_those_of_the_page_on_faults() {
    let help = String::from_utf8(ipf().arg("--help").output().unwrap().stdout).unwrap();
    let words = |text: &str| -> String {
        let plain: Vec<_> = text.split_whitespace().collect();
        plain.join(" ").replace('`', "")
    };
    let (_, listed) = help.split_once("Exit codes:\n").unwrap();
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/faults.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, table) = page
        .split_once("| exit code | meaning |\n| --- | --- |\n")
        .unwrap();
    let rows: Vec<String> = table
        .lines()
        .map_while(|line| line.strip_prefix("| ")?.strip_suffix(" |"))
        .map(|row| words(&row.replacen('|', "", 1)))
        .collect();
    assert!(rows.len() > 3);
    assert_eq!(words(listed), rows.join(" "));
}
