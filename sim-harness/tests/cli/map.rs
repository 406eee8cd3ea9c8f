//! `cargo ipf map`: what it refuses, what it reports, and when it writes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

use crate::common;

/// A folder for a drive and its map; removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    /// A copy of the sonar drive in this folder, its files changed.
    fn drive(&self, change: impl Fn(&str, String) -> String) -> String {
        let drive = self.0.path().join("drive");
        fs::create_dir_all(&drive).unwrap();
        for name in ["poses.txt", "measurement.txt"] {
            let text = fs::read_to_string(root().join(ROBOND).join(name)).unwrap();
            fs::write(drive.join(name), change(name, text)).unwrap();
        }
        drive.to_str().unwrap().to_owned()
    }

    fn out(&self) -> PathBuf {
        self.0.path().join("out")
    }

    /// Maps a drive into `out`: exit code, and what was printed.
    fn map(&self, drive: &str, rig: &str, options: &[&str]) -> (Option<i32>, String) {
        let output = ipf(
            &[&["map", drive, "--rig", &path(rig), "--out"], options].concat(),
            &self.out(),
        );
        let both = [output.stdout.as_slice(), &output.stderr].concat();
        (output.status.code(), String::from_utf8(both).unwrap())
    }

    /// Maps a drive where a map is already: it must stay.
    fn refuses(&self, drive: &str, rig: &str, options: &[&str], words: &str) {
        let _ = fs::remove_dir_all(self.out());
        fs::create_dir_all(self.out()).unwrap();
        let old = self.out().join("map.pgm");
        fs::write(&old, "old").unwrap();
        let (code, shown) = self.map(drive, rig, options);
        assert_eq!(code, Some(2), "{options:?}: {shown}");
        assert!(shown.contains(words), "{words}: {shown}");
        assert_eq!(fs::read(&old).unwrap(), b"old", "{options:?}");
        let files = fs::read_dir(self.out()).unwrap().count();
        assert_eq!(files, 1, "{options:?}: nothing else is written");
        fs::remove_dir_all(self.out()).unwrap();
        let (code, _) = self.map(drive, rig, options);
        assert_eq!(code, Some(2), "{options:?}");
        assert!(!self.out().exists(), "{options:?}: no folder is made");
    }
}

const ROBOND: &str = "sim-harness/tests/data/robond";
const KCMA: &str = "rigs/kcma.toml";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn path(name: &str) -> String {
    root().join(name).to_str().unwrap().to_owned()
}

/// The program; the path of `--out`, the option named by the fifth argument, goes behind it.
fn ipf(arguments: &[&str], out: &Path) -> Output {
    let (first, rest) = arguments.split_at(5);
    let mut ipf = Command::new(env!("CARGO_BIN_EXE_ipf"));
    ipf.args(first).arg(out).args(rest);
    ipf.stdin(Stdio::null()).output().unwrap()
}

#[test]
fn a_rig_of_another_robot_is_refused_and_a_mount_without_data_is_named() {
    let folder = Folder::new("rig");
    let words = "has no data for sonar 8, sonar 9";
    folder.refuses(&path(ROBOND), "rigs/pioneer2dx.toml", &[], words);
    let (code, shown) = folder.map(&path(ROBOND), KCMA, &[]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(
        shown.contains("the recording has no data for laser\n"),
        "{shown}"
    );
    let (_, shown) = folder.map(&path(ROBOND), KCMA, &["--sensors", "sonar"]);
    assert!(!shown.contains("no data"), "{shown}");
}

#[test]
fn a_map_of_nothing_is_not_written_and_the_reason_is_printed() {
    let folder = Folder::new("empty");
    let no_laser = "the recording has no data for laser";
    folder.refuses(&path(ROBOND), KCMA, &["--sensors", "laser"], no_laser);
    let all_free = "--methods all-free: name a method to compare with it";
    folder.refuses(&path(ROBOND), KCMA, &["--method", "all-free"], all_free);
    let no_infrared = "wall-map: needs infrared sensors: signals of an AMiRo's ring";
    folder.refuses(&path(ROBOND), KCMA, &["--method", "wall-map"], no_infrared);
    let with = |value: &'static str| {
        move |name: &str, text: String| {
            let row = |line: &str| {
                let stamp = line.split(' ').next().unwrap_or_default();
                format!("{stamp}{}\n", format!(" {value}").repeat(8))
            };
            match name {
                "poses.txt" => text,
                _ => text.lines().map(row).collect(),
            }
        }
    };
    let near = folder.drive(with("20"));
    let invalid = "no map: all 1496 returns are invalid or too close";
    folder.refuses(&near, KCMA, &[], invalid);
    let far = folder.drive(with("5110"));
    let no_echo = "no map: all 1496 returns are without an echo";
    folder.refuses(&far, KCMA, &[], no_echo);
    let (code, shown) = folder.map(&far, KCMA, &["--no-echo-is-free"]);
    assert_eq!(code, Some(0), "{shown}");
    let broken = folder.drive(|name, text| match name {
        "poses.txt" => text.replace(' ', ","),
        _ => text,
    });
    let no_pose = "poses.txt: no row of the format kcma; ";
    folder.refuses(&broken, KCMA, &[], no_pose);
}

#[test]
fn what_is_missing_is_named_with_what_was_looked_for() {
    let folder = Folder::new("missing");
    let nowhere = folder.0.path().join("nowhere");
    let nowhere = nowhere.to_str().unwrap();
    folder.refuses(nowhere, KCMA, &[], "nowhere: No such file");
    folder.refuses(
        &path(ROBOND),
        "rigs/none.toml",
        &[],
        "none.toml: No such file",
    );
    let drive = folder.drive(|_, text| text);
    fs::remove_file(Path::new(&drive).join("measurement.txt")).unwrap();
    for words in [
        "drive: of no known format; looked for",
        "od.txt or poses.txt, and sonar.txt or measurement.txt (kcma); or a folder with scans.csv, and vicon_poses.csv or poses.csv (nano_swarm); or a text file with rows of the server Player 1 (player); or a file with two lines of as many numbers, or with a JSON list of rows of distances (sharp_ir); or a file with frames of the link or AMiRo's text (amiro)",
    ] {
        folder.refuses(&drive, KCMA, &[], words);
    }
}

#[test]
fn a_drive_of_which_nearly_all_rows_are_refused_is_mapped_with_a_warning() {
    let folder = Folder::new("refused");
    let rows = |name: &str, text: String| match name {
        "poses.txt" => text,
        _ => text.split_inclusive('\n').take(1).collect(),
    };
    let drive = folder.drive(rows);
    let (code, shown) = folder.map(&drive, KCMA, &[]);
    assert_eq!(code, Some(0), "{shown}");
    for words in [
        "poses.txt line 2: ",
        "412 rows refused",
        "1 of 413 rows used",
        "MOST OF THE RECORDING IS MISSING",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    // As with `replay`, the map is written, and the exit code is that of a bad recording.
    let (code, shown) = folder.map(&drive, KCMA, &["--strict"]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(folder.out().join("map.pgm").is_file());
    let (code, _) = folder.map(&path(ROBOND), KCMA, &["--strict"]);
    assert_eq!(code, Some(0));
}

#[test]
fn zero_bytes_behind_the_last_row_are_reported() {
    let folder = Folder::new("zeros");
    let drive = folder.drive(|_, text| text + &"\0".repeat(512));
    let (code, shown) = folder.map(&drive, KCMA, &[]);
    assert_eq!(code, Some(0), "{shown}");
    let words = "poses.txt line 414: holds 512 zero bytes\n";
    assert!(shown.contains(words), "{shown}");
}

#[test]
fn an_out_that_is_a_file_and_a_rig_without_end_are_refused_before_the_work() {
    let folder = Folder::new("before");
    fs::write(folder.out(), "old").unwrap();
    let (code, shown) = folder.map(&path(ROBOND), KCMA, &[]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(shown.contains("--out: cannot write "), "{shown}");
    assert_eq!(fs::read(folder.out()).unwrap(), b"old");
    let long = folder.0.path().join("long.toml");
    fs::write(&long, "# ".repeat(1 << 20)).unwrap();
    fs::remove_file(folder.out()).unwrap();
    let (code, shown) = folder.map(&path(ROBOND), long.to_str().unwrap(), &[]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(
        shown.contains("long.toml: more than 1048576 bytes"),
        "{shown}"
    );
}

/// AMiRo's text: rows of 5 mm along x, with an equal reading on all sensors.
fn amiro_text(rows: u32) -> String {
    let columns: Vec<_> = (0..8).map(|sensor| format!("PRV {sensor}")).collect();
    let mut text = format!("{}\tX [ym]\tY [ym]\tTheta [yrad]\n", columns.join("\t"));
    for row in 0..rows {
        let line = format!("{}\t{}\t0\t0\n", ["300"; 8].join("\t"), 5000 * row);
        text.push_str(&line);
    }
    text
}

#[test]
fn an_amiros_recording_is_mapped_with_every_step_and_cells_of_10_mm() {
    let folder = Folder::new("amiro");
    let drive = folder.0.path().join("drive.txt");
    fs::write(&drive, amiro_text(101)).unwrap();
    let drive = drive.to_str().unwrap();
    let rig = "rigs/amiro.toml";
    for method in ["ism", "ism-decay"] {
        let (code, shown) = folder.map(drive, rig, &["--method", method]);
        assert_eq!(code, Some(0), "{shown}");
        for words in [
            "51 of 51 poses over 0.5 m; 408 returns with an echo",
            "cells of 10 mm",
        ] {
            assert!(shown.contains(words), "{words}: {shown}");
        }
        let summary = fs::read_to_string(folder.out().join("summary.json")).unwrap();
        assert!(summary.contains("\"format\": \"amiro\""), "{summary}");
    }
    for (options, words) in [
        (&["--keyframe-mm", "95"][..], "6 of 51 poses"),
        (&["--keyframe-deg", "10"], "5 of 51 poses"),
        (&["--cell-mm", "50"], "cells of 50 mm"),
    ] {
        let (code, shown) = folder.map(drive, rig, options);
        assert_eq!(code, Some(0), "{options:?}: {shown}");
        assert!(shown.contains(words), "{options:?}: {shown}");
    }
    folder.refuses(drive, KCMA, &[], "rig kcma: the recording needs 8 infrared");
    folder.refuses(drive, rig, &["--matched"], "have no matched poses");
    let both = ["--all-poses", "--keyframe-mm", "100"];
    folder.refuses(drive, rig, &both, "cannot be used with");
}

#[test]
fn an_amiro_that_stands_still_gives_no_map() {
    let folder = Folder::new("standing");
    let drive = folder.0.path().join("drive.txt");
    // The noise of a sensor: a row that repeats the one before is left out.
    let rows = (0..20).map(|row| {
        format!(
            "{}\t300\t300\t300\t300\t300\t300\t300\t0\t0\t0\n",
            300 + row % 2
        )
    });
    fs::write(&drive, amiro_text(0) + &rows.collect::<String>()).unwrap();
    let words = "drive.txt: the odometry does not move: its 20 poses";
    folder.refuses(drive.to_str().unwrap(), "rigs/amiro.toml", &[], words);
}

#[test]
fn no_map_replaces_the_recording_of_a_robot() {
    let folder = Folder::new("robot");
    fs::create_dir_all(folder.out()).unwrap();
    let drive = folder.out().join("map.pgm");
    fs::write(&drive, amiro_text(50)).unwrap();
    let (code, shown) = folder.map(drive.to_str().unwrap(), "rigs/amiro.toml", &[]);
    assert_eq!(code, Some(2), "{shown}");
    assert_eq!(fs::read_to_string(&drive).unwrap(), amiro_text(50));
}

#[test]
fn a_method_that_works_at_the_end_shows_its_progress_on_a_terminal_only() {
    let Some(recordings) = common::recordings() else {
        return common::skip("no recordings");
    };
    let folder = Folder::new("progress");
    let drive = recordings.join("amiro/RingProximityAndOdometry_Left.txt");
    let (drive, rig) = (drive.to_str().unwrap(), path("rigs/amiro.toml"));
    let output = ipf(
        &["map", drive, "--rig", &rig, "--out", "--method", "wall-map"],
        &folder.out(),
    );
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    // What was refused of the recording, and nothing else.
    let shown = String::from_utf8(output.stderr).unwrap();
    assert_eq!(shown.lines().count(), 3, "{shown}");
    assert!(
        !shown.contains('\r') && !shown.contains('\u{1b}'),
        "{shown}"
    );
    assert!(!shown.contains("searched"), "{shown}");
}

#[test]
fn kleppe_maps_sonar_axes_at_every_pose() {
    let folder = Folder::new("kleppe");
    let drive = folder.drive(|_, text| text.split_inclusive('\n').take(60).collect());
    let (code, shown) = folder.map(&drive, KCMA, &["--method", "kleppe"]);
    assert_eq!(code, Some(0), "{shown}");
    let words = "rig amiro: the recording needs 8 cones";
    folder.refuses(
        &drive,
        "rigs/amiro.toml",
        &["--method", "kleppe-paper"],
        words,
    );
}

#[test]
fn odometry_needs_matched_poses_and_names_its_simulated_compass() {
    let folder = Folder::new("odometry");
    let drive = folder.drive(|_, text| text);
    let rig = path(KCMA);
    let json = folder.0.path().join("odometry.json");
    let run = |drive: &str| {
        let output = ipf(&["odometry", drive, "--rig", &rig, "--json"], &json);
        let both = [output.stdout.as_slice(), &output.stderr].concat();
        (output.status.code(), String::from_utf8(both).unwrap())
    };
    let (code, shown) = run(&drive);
    assert_eq!(code, Some(2), "{shown}");
    assert!(
        shown.contains("the recording has no matched poses"),
        "{shown}"
    );
    assert!(!json.exists());
    let poses = fs::read_to_string(Path::new(&drive).join("poses.txt")).unwrap();
    let rows = poses.lines().map(|row| {
        let row: Vec<f64> = row
            .split_whitespace()
            .map(|it| it.parse().unwrap())
            .collect();
        (row[0], row[1], row[2], row[3])
    });
    let rows: Vec<_> = rows.collect();
    let matched = rows.iter().map(|(t, x, y, tenths)| {
        let heading = (0.1 * tenths).to_radians();
        let since = 1e-3 * (t - rows[0].0);
        format!("{since},{},{},{heading}\n", 1e-3 * x, 1e-3 * y)
    });
    let matched = "t,x,y,h\n".to_owned() + &matched.collect::<String>();
    fs::write(Path::new(&drive).join("matched_poses.csv"), matched).unwrap();
    let (code, shown) = run(&drive);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains("The compass is SIMULATED"), "{shown}");
    let figures = fs::read_to_string(&json).unwrap();
    assert!(figures.contains("\"simulated\": true"), "{figures}");
}

#[test]
fn outputs_are_no_files_of_the_drive_and_no_maps() {
    let folder = Folder::new("json");
    let drive = folder.drive(|_, text| text);
    let poses = Path::new(&drive).join("poses.txt");
    let before = fs::read(&poses).unwrap();
    let json = poses.to_str().unwrap();
    let words = "this command reads it";
    folder.refuses(&drive, KCMA, &["--json", json], words);
    assert_eq!(fs::read(&poses).unwrap(), before);
    let picture = folder.out().join("summary.json");
    let picture = picture.to_str().unwrap();
    folder.refuses(&drive, KCMA, &["--json", picture], "is a file of a map");
    folder.refuses(
        &drive,
        KCMA,
        &["--sensors", ""],
        "--sensors: a name is empty",
    );
}

#[test]
fn a_drive_that_cannot_be_read_does_not_end_the_others() {
    let folder = Folder::new("several");
    let drive = folder.drive(|_, text| text);
    let (broken, json) = (
        folder.0.path().join("broken"),
        folder.0.path().join("j.json"),
    );
    fs::create_dir(&broken).unwrap();
    fs::write(broken.join("poses.txt"), "1 2 x 4\n").unwrap();
    fs::write(broken.join("measurement.txt"), "1 2 3 4 5 6 7 8 9\n").unwrap();
    let rest = [
        "--methods",
        "ism,mal",
        "--json",
        json.to_str().unwrap(),
        &drive,
    ];
    let (code, shown) = folder.map(broken.to_str().unwrap(), KCMA, &rest);
    assert_eq!(code, Some(2), "{shown}");
    assert!(shown.contains("no row of the format kcma"), "{shown}");
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let is_made = |row: &&serde_json::Value| row.get("not_applicable").is_none();
    assert_eq!((rows.len(), rows.iter().filter(is_made).count()), (4, 2));
    let map = format!("{}-drive", folder.0.path().file_name().unwrap().display());
    assert!(folder.out().join(map).join("mal/map.pgm").is_file());
}
