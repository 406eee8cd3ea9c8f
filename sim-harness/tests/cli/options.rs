//! The program's options: what is refused, in which words, before any work, and with exit
//! code 2.

#![cfg(unix)]

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

use crate::common;

/// A folder to run the program in; removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    /// The program in this folder; a path of the arguments is relative to it.
    fn ipf(&self, arguments: &[&str]) -> Command {
        let mut ipf = Command::new(env!("CARGO_BIN_EXE_ipf"));
        ipf.args(arguments)
            .current_dir(&self.0)
            .stdin(Stdio::null());
        ipf
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.ipf(arguments).output().unwrap()
    }

    fn names(&self) -> Vec<String> {
        let names = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = names
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Each command line ends with exit code 2 and a message that holds the words, and
    /// leaves the folder as it was.
    fn refuses(&self, cases: &[(&str, &str)]) {
        let before = self.names();
        let mut wrong = Vec::new();
        for (line, words) in cases {
            let line = line.replace("SSSO", &scenario());
            let output = self.run(&line.split(' ').collect::<Vec<_>>());
            let message = String::from_utf8_lossy(&output.stderr);
            if output.status.code() != Some(2) || !message.contains(words) {
                let code = output.status.code();
                wrong.push(format!("{line}\n  wanted: {words}\n  {code:?}: {message}"));
            }
            if self.names() != before {
                let names = self.names();
                wrong.push(format!("{line}\n  left behind: {names:?}"));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

fn scenario() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/ssso.toml");
    path.canonicalize().unwrap().to_str().unwrap().to_owned()
}

#[test]
fn an_option_that_would_do_nothing_is_refused() {
    let folder = Folder::new("idle-options");
    fs::write(folder.0.path().join("image.elf"), b"").unwrap();
    folder.refuses(&[
        ("evaluate --alpha 1 --calibrate", "cannot be used with"),
        (
            "replay x --baud 9600",
            "--baud is for a serial port, not for --on host",
        ),
        (
            "replay x --on qemu --baud 9600",
            "--baud is for a serial port, not for --on qemu",
        ),
        (
            "record --on qemu --baud 9600 --out x",
            "--baud is for a serial port",
        ),
        (
            "offsets --on qemu --baud 9600",
            "--baud is for a serial port",
        ),
        (
            "replay x --image image.elf",
            "--image is for --on qemu, not for --on host",
        ),
        (
            "replay x --on /dev/null --image image.elf",
            "--image is for --on qemu, not for --on /dev/null",
        ),
        (
            "offsets --on /dev/null --image image.elf",
            "--image is for --on qemu",
        ),
        ("replay x --ram-fill 7", "--ram-fill is for --on qemu"),
        (
            "replay x --count-instructions",
            "--count-instructions is for --on qemu",
        ),
        ("replay x --seed-of-faults 2", "--fault <FAULTS>"),
        (
            "simulate SSSO --out x --seed-of-faults 2",
            "--fault <FAULTS>",
        ),
        (
            "replay x --on /dev/null --fault link=drop:0.1",
            "--fault link=... disturbs a run on the host, not on a board",
        ),
    ]);
}

#[test]
fn a_value_outside_its_range_is_refused_before_any_work() {
    let folder = Folder::new("ranges");
    let whole = "a whole number from 0 to 18446744073709551615 is expected";
    let seeds = "two whole numbers A..B from 0 to 18446744073709551615 are expected";
    let particles = "particles_per_sensor must be at least 1";
    let alpha = "--alpha: alpha_counts_m2 must be";
    let x_max = "--x-max: x_max_m must be";
    folder.refuses(&[
        ("demo --seed -1", whole),
        ("demo --seed 18446744073709551616", whole),
        ("demo --seed 1.5", whole),
        ("figures --seeds -1..5", seeds),
        ("figures --seeds 5", seeds),
        ("figures --seeds 5..5", "A must be below B"),
        (
            "figures --seeds 0..100001",
            "100001 seeds: at most 100000 drives in all",
        ),
        ("figures --only figure-77", "possible values"),
        ("replay x --seed -1", whole),
        ("replay x --particles -1", "-1 is not in 0..=65535"),
        ("replay x --particles 0", particles),
        ("replay x --particles 0", "--particles: "),
        ("replay x --x-max nan", x_max),
        ("replay x --x-max -0.1", x_max),
        ("replay x --alpha -1", alpha),
        ("replay x --alpha inf", alpha),
        ("replay x --mask 8", "8 is not in 0..8"),
        ("replay x --mask -1", "-1 is not in 0..8"),
        (
            "replay x --mask 0,1,2,3,4,5,6,7",
            "--mask: sensors must be at least one",
        ),
        ("replay x --baud 0", "0 is not in 1..=4294967295"),
        ("replay x --on qemu --ram-fill 256", "256 is not in 0..=255"),
        ("replay x --fault s3=off --seed-of-faults -1", whole),
        ("replay x --profile fast", "possible values: paper, plus"),
        (
            "record --on x --out y --baud 0",
            "0 is not in 1..=4294967295",
        ),
        (
            "record --on x --out y --seconds 0",
            "0 is not in 1..=4294967295",
        ),
        (
            "record --on x --out y --seconds -1",
            "-1 is not in 1..=4294967295",
        ),
        ("record --on x --out y --alpha 0", alpha),
        ("record --on x --out y --seed -1", whole),
        ("offsets --on x --baud 0", "0 is not in 1..=4294967295"),
        ("simulate SSSO --out y --seed -1", whole),
        (
            "simulate SSSO --out y --noise 101",
            "--noise: 101 is outside 0 to 100",
        ),
        (
            "simulate SSSO --out y --noise -1",
            "--noise: -1 is outside 0 to 100",
        ),
        (
            "simulate SSSO --out y --noise nan",
            "--noise: NaN is outside 0 to 100",
        ),
        (
            "simulate SSSO --out y --drift 1..inf",
            "--drift: inf is outside",
        ),
        (
            "simulate SSSO --out y --dropout 2",
            "--dropout: 2 is outside 0 to 1",
        ),
        (
            "simulate SSSO --out y --reflectivity 0",
            "--reflectivity: 0 is outside",
        ),
        (
            "simulate SSSO --out y --gain-spread 0.6",
            "--gain-spread: 0.6 is outside 0 to 0.5",
        ),
        (
            "simulate SSSO --out y --odometry wheel-errors:1:2:99:0",
            "--odometry: 99 is outside -45 to 45",
        ),
        (
            "simulate SSSO --out y --xi 2",
            "--xi: 2 is outside 0.5 to 1.45",
        ),
        ("simulate SSSO --out y --delta -1", "--delta: -1 is outside"),
        (
            "simulate SSSO --out y --odometry wheel-errors:99:1",
            "--odometry: 99 is outside",
        ),
        ("evaluate --seeds -1..5", seeds),
        ("evaluate --seeds 7..5", "A must be below B"),
        (
            "evaluate --seeds 0..100001",
            "100001 seeds: at most 100000 drives in all",
        ),
        (
            "evaluate --seeds 0..20001",
            "20001 seeds: at most 100000 drives in all",
        ),
        (
            "evaluate --particles 0",
            "--particles: particles_per_sensor must be at least 1",
        ),
        (
            "evaluate --particles 2001",
            "--particles: 16008 particles, at most 16000 fit",
        ),
        ("evaluate --alpha 0", alpha),
        ("evaluate --alpha -1", alpha),
        (
            "evaluate --odometry wheel-errors:99:1",
            "--odometry: 99 is outside",
        ),
        ("evaluate --threads 100000", "100000 is not in 0..=256"),
        ("evaluate --threads -1", "-1 is not in 0..=256"),
        ("evaluate --methods none", "'none'"),
        ("calibrate x --fix xi=9", "--fix: xi must be a number from"),
        ("calibrate x --fix xi", "--fix: 'xi' is not NAME=VALUE"),
        ("image --layout none", "possible values: bare, amiro"),
    ]);
}

#[test]
fn files_of_gains_are_refused_with_file_key_and_reason_and_not_overwritten() {
    let folder = Folder::new("gains");
    let good = "alpha_counts_m2 = 1.0\nalpha_sigma_counts_m2 = 0.1\n\
                gains = [1, 1, 1, 1, 1, 1, 1, 1.1]\n\
                gain_sigmas = [0, 0, 0, 0, 0, 0, 0, 0]\nsources = []\n";
    let write = |name: &str, text: &str| {
        fs::write(folder.0.path().join(name), text).unwrap();
    };
    write("good.toml", good);
    write("dim.toml", &good.replace("1.1]", "0.1]"));
    write("seven.toml", &good.replace(", 1.1]", "]"));
    write("other.toml", &good.replace("sources", "source"));
    write("drive.txt", "");
    folder.refuses(&[
        (
            "evaluate --gains none.toml",
            "--gains: none.toml: No such file",
        ),
        (
            "evaluate --gains dim.toml",
            "--gains: dim.toml: gains[7] is 0.1; legal is 0.25 to 4",
        ),
        ("evaluate --gains seven.toml", "--gains: seven.toml: "),
        ("record --on x --out y --gains other.toml", "unknown field"),
        (
            "map x --rig good.toml --gains dim.toml",
            "--gains: dim.toml: gains[7] is 0.1; legal is 0.25 to 4",
        ),
        (
            "calibrate --from-drive drive.txt --out good.toml",
            "--out: good.toml exists; --force replaces it",
        ),
        (
            "calibrate --from-drive drive.txt --out drive.txt --force",
            "drive.txt",
        ),
        ("calibrate x --from-drive drive.txt", "cannot be used with"),
        ("calibrate --from-drive x --law wall", "cannot be used with"),
        ("calibrate x --force", "cannot be used with"),
        ("calibrate x --mask 3", "cannot be used with"),
        ("calibrate", "<TABLE"),
    ]);
    assert_eq!(
        fs::read_to_string(folder.0.path().join("good.toml")).unwrap(),
        good
    );
}

#[test]
fn a_path_that_cannot_be_written_is_refused_before_any_work_and_named() {
    let folder = Folder::new("paths");
    fs::write(folder.0.path().join("file"), b"old").unwrap();
    fs::create_dir(folder.0.path().join("folder")).unwrap();
    let dash = "standard output is not written to; ./- is a file of that name";
    folder.refuses(&[
        ("demo --out -", dash),
        ("figures --out -", dash),
        ("replay x --out -", dash),
        ("record --on x --out -", dash),
        ("evaluate --json -", dash),
        ("calibrate x --out -", dash),
        ("image --out -", dash),
        (
            "demo --out file",
            "--out: cannot write file: not a directory",
        ),
        ("demo --out file/below", "--out: cannot write file/below: "),
        (
            "figures --out file",
            "--out: cannot write file: not a directory",
        ),
        (
            "replay x --out file",
            "--out: cannot write file: not a directory",
        ),
        ("replay x --out file/a/b", "--out: cannot write file/a/b: "),
        (
            "calibrate x --out file",
            "--out: cannot write file: not a directory",
        ),
        (
            "simulate SSSO --out folder",
            "--out: cannot write folder: is a directory",
        ),
        (
            "simulate SSSO --out missing/x",
            "--out: cannot write missing/x: No such file",
        ),
        ("simulate SSSO --out file/x", "--out: cannot write file/x: "),
        (
            "evaluate --json folder",
            "--json: cannot write folder: is a directory",
        ),
        (
            "evaluate --json missing/x",
            "--json: cannot write missing/x: No such file",
        ),
        (
            "image --out folder",
            "--out: cannot write folder: is a directory",
        ),
        (
            "image --out missing/x",
            "--out: cannot write missing/x: No such file",
        ),
        (
            "image --out x.srec",
            "--out names the binary; the S-records go beside it",
        ),
        ("image --file missing", "missing: "),
        (
            "replay x --on qemu --image missing",
            "--image missing: No such file",
        ),
        (
            "replay x --on qemu --image folder",
            "--image folder: is a directory",
        ),
        (
            "offsets --on qemu --image missing",
            "--image missing: No such file",
        ),
        (
            "record --on x --out missing/y",
            "--out: cannot write missing/y: No such file",
        ),
    ]);
    assert_eq!(fs::read(folder.0.path().join("file")).unwrap(), b"old");
}

#[test]
fn a_recording_on_standard_output_is_the_recording_of_a_file() {
    let folder = Folder::new("stdout");
    let scenario = scenario();
    let in_file = folder.run(&["simulate", &scenario, "--out", "drive.ipf"]);
    assert_eq!(in_file.status.code(), Some(0), "{in_file:?}");
    let piped = folder.run(&["simulate", &scenario, "--out", "-"]);
    assert_eq!(piped.status.code(), Some(0), "{piped:?}");
    assert_eq!(folder.names(), ["drive.ipf"], "no file is named -");
    let drive = fs::read(folder.0.path().join("drive.ipf")).unwrap();
    assert!(piped.stdout == drive, "the bytes differ");
    let report = String::from_utf8_lossy(&piped.stderr);
    assert!(report.starts_with("-: "), "{report}");
    let report = String::from_utf8_lossy(&in_file.stdout);
    assert!(report.starts_with("drive.ipf: "), "{report}");
    let mut replay = folder.ipf(&["replay", "-", "--out", "out", "--particles", "10"]);
    replay.stdin(Stdio::piped()).stdout(Stdio::null());
    let mut replay = replay.spawn().unwrap();
    replay
        .stdin
        .take()
        .unwrap()
        .write_all(&piped.stdout)
        .unwrap();
    assert_eq!(replay.wait().unwrap().code(), Some(0));
    assert!(folder.0.path().join("out/map.png").exists());
}

#[test]
fn a_recording_on_a_full_standard_output_is_an_error() {
    let folder = Folder::new("full");
    let full = fs::File::options().write(true).open("/dev/full");
    let Ok(full) = full else {
        return;
    };
    let mut simulate = folder.ipf(&["simulate", &scenario(), "--out", "-"]);
    let output = simulate.stdout(full).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("standard output cannot be written"),
        "{message}"
    );
}

#[test]
fn a_recording_on_a_closed_standard_output_ends_with_5() {
    let folder = Folder::new("closed");
    let script = "exec \"$0\" simulate \"$1\" --out - >&-";
    let mut shell = Command::new("sh");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_ipf"), &scenario()]);
    let output = shell.current_dir(&folder.0).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{message}");
    let words = "standard output cannot be written: it is closed";
    assert!(message.contains(words), "{message}");
    let mut into_null = folder.ipf(&["simulate", &scenario(), "--out", "-"]);
    let output = into_null.stdout(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_named_pipe_is_refused_as_output_and_interruptible_as_input() {
    let folder = Folder::new("fifo");
    let made = Command::new("mkfifo")
        .arg(folder.0.path().join("fifo"))
        .status();
    assert!(made.unwrap().success());
    folder.refuses(&[
        ("record --on x --out fifo", "--out fifo: is a named pipe"),
        (
            "record --on x --force --out fifo",
            "--out fifo: is a named pipe",
        ),
        (
            "simulate SSSO --out fifo",
            "--out: cannot write fifo: is a named pipe",
        ),
    ]);
    // Programs that a script starts in the background ignore an interrupt, and so do theirs.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let is_interruptible = ignored.is_none_or(|mask| mask & (1 << (2 - 1)) == 0);
    let signals = [("-INT", is_interruptible), ("-TERM", true)];
    for (signal, _) in signals.into_iter().filter(|(_, is_taken)| *is_taken) {
        let mut replay = folder.ipf(&["replay", "fifo", "--out", "out"]);
        let mut replay = replay.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(300));
        let id = replay.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status().unwrap();
        assert!(sent.success());
        assert_eq!(replay.wait().unwrap().code(), None, "{signal} ends it");
    }
}

#[test]
fn a_named_pipe_in_the_output_folder_is_refused_before_it_is_opened() {
    let folder = Folder::new("fifos");
    let (robond, rig) = (
        concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/robond"),
        concat!(env!("CARGO_MANIFEST_DIR"), "/../rigs/kcma.toml"),
    );
    std::fs::create_dir(folder.0.path().join("o")).unwrap();
    for name in ["map.png", "map.pgm", "map.yaml", "summary.json"] {
        let pipe = folder.0.path().join("o").join(name);
        let made = Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let output = folder
            .ipf(&["map", robond, "--rig", rig, "--out", "o"])
            .output();
        let output = output.unwrap();
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{name}: {shown}");
        assert!(shown.contains("is a named pipe"), "{name}: {shown}");
        std::fs::remove_file(pipe).unwrap();
    }
}

#[test]
fn a_recording_of_a_robot_goes_to_no_device_but_null() {
    let folder = Folder::new("devices");
    folder.refuses(&[
        (
            "record --on x --out /dev/full",
            "--out /dev/full: is a device",
        ),
        (
            "record --on x --force --out /dev/full",
            "--out /dev/full: is a device",
        ),
        (
            "record --on /dev/null --force --out /dev/null",
            "--out /dev/null: is the port of the board",
        ),
        // These are let through: only the board is missing.
        ("record --on x --out /dev/null", "cannot be reached: x"),
        ("record --on x --out /dev/stdout", "cannot be reached: x"),
    ]);
}

#[test]
fn particles_that_no_image_has_room_for_are_refused_before_one_is_built_or_started() {
    let folder = Folder::new("capacity");
    // Of a robot with eight sensors.
    let scenario = scenario().replace("ssso", "msod");
    let made = folder.run(&["simulate", &scenario, "--out", "drive.ipf"]);
    assert_eq!(made.status.code(), Some(0), "{made:?}");
    let mut replay = folder.ipf(&["replay", "drive.ipf", "--on", "qemu"]);
    replay.args(["--particles", "1500"]);
    // Neither cargo nor QEMU is found.
    replay.env("PATH", "").env("CARGO", "no-cargo");
    let output = replay.output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("12000 particles, at most 8000 fit"),
        "{message}"
    );
}

#[test]
fn names_of_up_to_255_bytes_are_written() {
    let folder = Folder::new("long-names");
    for length in [240, 250, 255] {
        let name = "n".repeat(length);
        let output = folder.run(&["simulate", &scenario(), "--out", &name]);
        assert_eq!(output.status.code(), Some(0), "{length}: {output:?}");
        assert_eq!(folder.names(), [name.as_str()]);
        fs::remove_file(folder.0.path().join(name)).unwrap();
    }
    let name = "n".repeat(256);
    let output = folder.run(&["simulate", &scenario(), "--out", &name]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.starts_with("ipf: --out: cannot write nnn"),
        "{message}"
    );
}

/// Containers mount single files; no file can be renamed onto one.
#[test]
fn an_output_that_is_a_mount_point_is_written() {
    let folder = Folder::new("mounted");
    for name in ["mounted", "source"] {
        fs::write(folder.0.path().join(name), b"old").unwrap();
    }
    let command = format!(
        "mount --bind source mounted && echo mounted && exec '{}' simulate '{}' --out mounted",
        env!("CARGO_BIN_EXE_ipf"),
        scenario()
    );
    let unshared = Command::new("unshare")
        .args(["--mount", "--map-root-user", "sh", "-c", &command])
        .current_dir(&folder.0)
        .output();
    match unshared {
        Ok(output) if output.stdout.starts_with(b"mounted\n") => {
            assert_eq!(output.status.code(), Some(0), "{output:?}");
            let written = fs::read(folder.0.path().join("source")).unwrap();
            assert!(written.len() > 1000, "{} bytes", written.len());
            assert_eq!(folder.names(), ["mounted", "source"]);
        }
        _ => sim_harness::console::warn("skipped: this system lets nothing be mounted"),
    }
}
