//! `cargo ipf map` over drives that no robot drove: a clear result or a message with the
//! place, exit code 0 or 2, no panic and no run without end.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common;

/// Ranges of the eight sonars, millimetres; 5110 is no echo.
const RANGES: &str = "1000 1200 900 5110 2000 3000 700 800";

/// Methods that hold evidence in each way: counts, log odds, masses, fuzzy pairs, echoes
/// that are consistent, a search over all returns, walls along the axis.
const METHODS: &str = "ism,bayes,ds,fuzzy,bayes-box,cemal,fsm,pgc,nav2-range,sonar,kleppe";

/// A drive in a folder of its own, and its maps.
struct Drive(TempDir);

impl Drive {
    /// Rows of `poses.txt` behind the stamp, and of `measurement.txt`.
    fn new(rows: impl IntoIterator<Item = (String, String)>) -> Self {
        let folder = common::own_folder("hostile");
        let (mut poses, mut ranges) = (String::new(), String::new());
        for (stamp, (pose, range)) in rows.into_iter().enumerate() {
            writeln!(poses, "{stamp} {pose}").unwrap();
            writeln!(ranges, "{stamp} {range}").unwrap();
        }
        let drive = Self(folder);
        fs::create_dir(drive.path("drive")).unwrap();
        fs::write(drive.path("drive/poses.txt"), poses).unwrap();
        fs::write(drive.path("drive/measurement.txt"), ranges).unwrap();
        drive
    }

    /// Poses with the same ranges at each.
    fn at(poses: &[&str]) -> Self {
        let rows = poses
            .iter()
            .map(|pose| ((*pose).to_owned(), RANGES.to_owned()));
        Self::new(rows)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    }

    /// Maps it: exit code, and what was printed.
    fn map(&self, options: &[&str]) -> (Option<i32>, String) {
        let mut ipf = Command::new(env!("CARGO_BIN_EXE_ipf"));
        ipf.arg("map")
            .arg(self.path("drive"))
            .arg("--out")
            .arg(self.path("out"));
        let output = ipf.args(options).stdin(Stdio::null()).output().unwrap();
        let both = [output.stdout.as_slice(), &output.stderr].concat();
        let shown = String::from_utf8(both).unwrap();
        assert!(!shown.contains("panicked"), "{options:?}: {shown}");
        (output.status.code(), shown)
    }

    fn maps(&self, options: &[&str], words: &[&str]) {
        self.ends(0, options, words);
    }

    fn refuses(&self, options: &[&str], words: &[&str]) {
        self.ends(2, options, words);
        assert!(!self.path("out").exists(), "{options:?}");
    }

    fn ends(&self, expected: i32, options: &[&str], words: &[&str]) {
        let (code, shown) = self.map(options);
        assert_eq!(code, Some(expected), "{options:?}: {shown}");
        for words in words {
            assert!(shown.contains(words), "{options:?}, {words}: {shown}");
        }
    }
}

#[test]
fn a_drive_without_a_pose_is_refused_with_its_file() {
    Drive::at(&[]).refuses(
        &["--methods", "all"],
        &["poses.txt: no row of the format kcma"],
    );
}

#[test]
fn one_record_is_mapped_by_every_method_that_has_its_sensors() {
    let drive = Drive::at(&["0 0 0"]);
    drive.maps(
        &["--methods", "all"],
        &["\nism ", "\npgc ", "\nkleppe-paper "],
    );
    for method in ["ism", "cemal", "bayes", "pgc"] {
        assert!(
            drive.path("out").join(method).join("map.pgm").is_file(),
            "{method}"
        );
    }
}

#[test]
fn numbers_that_are_none_are_refused_with_file_and_line() {
    let row = |pose: &str, range: &str| {
        (
            pose.to_owned(),
            format!("{range} 1000 900 900 900 900 900 900"),
        )
    };
    let drive = Drive::new([
        row("0 0 0", "1000"),
        row("NaN 0 0", "1000"),
        row("0 -inf 0", "1000"),
        row("200 0 0", "NaN"),
        row("200 0 0", "inf"),
        row("1e400 0 0", "1000"),
        row("1e9 0 0", "1000"),
        row("200 0 0", "-1"),
    ]);
    let words = [
        "poses.txt line 2: 'NaN' is no number",
        "poses.txt line 3: '-inf' is no number",
        "measurement.txt line 4: 'NaN' is no number",
        "measurement.txt line 5: 'inf' is no number",
        "7 rows refused",
        "1 of 8 rows used",
    ];
    drive.maps(&["--methods", METHODS], &words);
    drive.ends(2, &["--methods", "ism", "--strict"], &words);
}

#[test]
fn cells_of_which_a_cone_has_more_than_a_map_are_refused_with_the_mount() {
    let drive = Drive::at(&["0 0 0"]);
    let rig = fs::read_to_string(common::root().join("rigs/kcma.toml")).unwrap();
    let rig = drive.write("rig.toml", rig.replace("[0.17, 5.0]", "[0.17, 200.0]"));
    let words = [
        "mount \"sonar 0\" is 200 m: cells of 1 mm",
        "--cell-mm 50 is enough",
    ];
    let one_mm = ["--methods", "all", "--rig", &rig, "--cell-mm", "1"];
    drive.refuses(&one_mm, &words);
    drive.refuses(
        &["--methods", "all", "--cell-mm", "1"],
        &["--cell-mm 2 is enough"],
    );
    drive.maps(&["--methods", "ism", "--cell-mm", "2"], &["cells of 2 mm"]);
    drive.maps(
        &["--methods", "ism", "--rig", &rig, "--cell-mm", "500"],
        &["of 500 mm"],
    );
}

#[test]
fn poses_that_are_kilometres_apart_are_mapped_and_the_cut_is_reported() {
    // Along a line the map holds both; along a diagonal the second place is beyond it.
    let line = Drive::at(&["0 0 0", "9990000 0 0"]);
    let (code, shown) = line.map(&["--methods", "ism,cemal"]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(!shown.contains("CUT"), "{shown}");
    let diagonal = Drive::at(&["0 0 0", "9990000 9990000 0"]);
    let cut = [
        "ism: THE MAP IS CUT",
        "bayes: THE MAP IS CUT",
        "fsm: THE MAP IS CUT",
    ];
    diagonal.maps(&["--methods", "ism,bayes,fsm"], &cut);
    diagonal.maps(&["--methods", "ism"], &cut[..1]);
    Drive::at(&["0 0 0", "10000001 0 0"]).maps(&["--methods", "ism"], &["poses.txt line 2: "]);
}

#[test]
fn a_file_of_walls_that_is_none_is_refused_with_its_line() {
    let drive = Drive::at(&["0 0 0", "200 0 0"]);
    let walls = |rows: &str| format!("x1,y1,x2,y2\n0,0,1,0\n{rows}\n");
    let header = "walls.csv, line 1: the header is not x1,y1,x2,y2";
    for (content, words) in [
        (String::new(), header),
        ("0,0,1,0\n".to_owned(), header),
        ("x1,y1,x2\n0,0,1\n".to_owned(), header),
        (
            "x1,y1,x2,y2\n".to_owned(),
            "walls.csv, line 1: there is no wall",
        ),
        (
            walls("0,0,1"),
            "walls.csv, line 3: four numbers are expected",
        ),
        (
            walls("0,0,1,0,1"),
            "walls.csv, line 3: four numbers are expected",
        ),
        (
            walls("0,NaN,1,0"),
            "walls.csv, line 3: a number within 10000 m",
        ),
        (
            walls("0,0,-inf,0"),
            "walls.csv, line 3: a number within 10000 m",
        ),
        (
            walls("0,0,20000,0"),
            "walls.csv, line 3: a number within 10000 m",
        ),
        (
            walls("0,0,1,"),
            "walls.csv, line 3: a number within 10000 m",
        ),
    ] {
        let file = drive.write("walls.csv", content);
        drive.refuses(
            &["--methods", "ism", "--walls", &file],
            &["--walls: ", words],
        );
    }
    let binary: Vec<u8> = (0..4096_u32)
        .map(|it| (it.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let file = drive.write("walls.csv", binary);
    drive.refuses(
        &["--methods", "ism", "--walls", &file],
        &["walls.csv, line 1: "],
    );
    let folder = drive.path("drive");
    let folder = folder.to_str().unwrap();
    drive.refuses(
        &["--methods", "ism", "--walls", folder],
        &["--walls: ", "drive: Is a directory"],
    );
    drive.refuses(
        &["--methods", "ism", "--walls", "nowhere"],
        &["nowhere: No such file"],
    );
}

#[test]
fn ten_thousand_walls_cost_seconds() {
    let drive = Drive::at(&["0 0 0", "200 0 0"]);
    let mut walls = "x1,y1,x2,y2\n".to_owned();
    for wall in 0..10_000 {
        let x = 0.01 * f64::from(wall);
        writeln!(walls, "{x:.2},3,{:.2},3.5", x + 1.0).unwrap();
    }
    let file = drive.write("walls.csv", walls);
    let started = Instant::now();
    drive.maps(
        &["--methods", "ism", "--cell-mm", "20", "--walls", &file],
        &["truth from 10000 walls: "],
    );
    // A second on an idle machine; testing every wall at every cell takes an hour.
    let elapsed = started.elapsed();
    assert!(elapsed < Duration::from_secs(60), "{elapsed:?}");
}

#[test]
fn a_truth_that_is_larger_than_a_map_is_cut_and_reported() {
    // A corridor along a diagonal of 2 km: few cells, in a rectangle of 4e8.
    let drive = Drive::at(&["0 0 0", "1990000 1990000 0"]);
    let corridor = "x1,y1,x2,y2\n-1,0,2000,2001\n0,-1,2001,2000\n-1,0,0,-1\n2000,2001,2001,2000\n";
    let file = drive.write("walls.csv", corridor);
    let cut = ["THE TRUTH IS CUT: it holds at most 64000000 cells"];
    drive.maps(&["--methods", "ism", "--walls", &file], &cut);
}

#[test]
fn a_hundred_thousand_records_are_mapped_in_a_bounded_time() {
    // Rounds in a room; the robot turns once per 31 300 rows.
    let rows = (0..100_000_u32).map(|row| {
        let angle = 2e-4 * f64::from(row);
        let (x, y) = (2000.0 * angle.cos(), 1500.0 * angle.sin());
        let heading = (0.115 * f64::from(row)) % 3600.0;
        let ranges: Vec<_> = (0..8)
            .map(|sonar| (700 + (7 * row + 311 * sonar) % 2400).to_string())
            .collect();
        (format!("{x:.0} {y:.0} {heading:.1}"), ranges.join(" "))
    });
    let drive = Drive::new(rows);
    drive.maps(
        &["--methods", "ism,cemal,bayes,fsm", "--sensors", "sonar"],
        &["\nism ", "\ncemal ", "\nbayes ", "\nfsm "],
    );
    let summary = fs::read_to_string(drive.path("out/ism/summary.json")).unwrap();
    assert!(summary.contains("\"poses\": 100000"), "{summary}");
}
