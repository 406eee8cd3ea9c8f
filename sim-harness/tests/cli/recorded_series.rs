//! `cargo ipf evaluate --recordings`: anybody's series, and descriptions that are refused.

use std::fs;
use std::process::{Command, Output};

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{Photometry, Ring, Sample, SensorMask};
use amiro_ipf::random::Generator;
use sim_harness::world::{Physics, Scenario, Sensing};
use tempfile::TempDir;

use crate::common;

/// Two series beside a wall 50 mm to the left of the robot's rim.
const DESCRIPTION: &str = r#"alpha_from = "near.txt"
[[series]]
file = "near.txt"
truth = "by the ruler"
first_station_m = -0.2
station_step_m = 0.04
masked_sensors = [3, 4]
[[series.wall]]
from = [0.0, 0.1]
to = [0.3, 0.1]
[[series]]
file = "corner.txt"
truth = "by the ruler"
first_station_m = -0.2
station_step_m = 0.04
[[series.wall]]
from = [0.3, 0.1]
to = [0.0, 0.1]
depth_m = 0.05
[[series.wall]]
from = [0.5, -0.3]
to = [0.5, 0.3]
[[series.box]]
min = [0.0, -0.3]
max = [0.1, -0.2]
[[series.cylinder]]
center = [0.2, -0.2]
radius_m = 0.03
"#;

/// A folder with recordings; removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = Self(common::own_folder(name));
        folder.write("near.txt", &recording(14));
        folder.write("corner.txt", &recording(14));
        folder
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).unwrap();
    }

    fn evaluate(&self, more: &[&str]) -> Output {
        let mut ipf = Command::new(env!("CARGO_BIN_EXE_ipf"));
        ipf.args(["evaluate", "--recordings", "."]).args(more);
        ipf.current_dir(&self.0).output().unwrap()
    }

    /// What is printed about a description that is refused with exit code 2.
    fn refusal(&self, description: &str) -> String {
        self.write("series.toml", description);
        let output = self.evaluate(&["--methods", "ism-tuned"]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{description}\n{message}");
        message
    }
}

/// What the simulator's sensors read at the stations of the first series.
fn recording(stations: u32) -> String {
    let wall = "name = \"w\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\n\
                start = [0, 0, 0]\n[[box]]\nmin = [0.0, 0.1]\nmax = [0.3, 0.2]\n";
    let shapes = Scenario::parse(wall).unwrap().shapes;
    let (physics, noise) = (Physics::Matched, Generator::seeded(1));
    let law = Photometry::VCNL4020;
    let mut sensing = Sensing::new(Ring::AMIRO, SensorMask::ALL, law, physics, noise);
    let prv: Vec<String> = (0..8).map(|sensor| format!("PRV {sensor}")).collect();
    let mut text = format!("{}\tX [ym]\tY [ym]\tTheta [yrad]\n", prv.join("\t"));
    for station in 0..stations {
        let x_m = -0.2 + 0.04 * station as f32;
        for sample in sensing.sample(&shapes, &Pose::new(x_m, 0.0, 0.0), 0.0) {
            match sample {
                Sample::Counts(counts) => text += &format!("{}\t", counts.max(0)),
                Sample::Saturated | Sample::Missing => text += "x\t",
            }
        }
        // A row that repeats the one before would be refused.
        text += &format!("{}\t0\t0\n", 256 * (station % 3));
    }
    text
}

#[test]
fn a_folder_of_anybody_is_judged_by_its_own_description() {
    let folder = Folder::new("own");
    folder.write("series.toml", DESCRIPTION);
    let methods = ["--methods", "ism-tuned,plus,ism-tuned"];
    let output = folder.evaluate(&[methods.as_slice(), &["--json", "out.json"]].concat());
    let shown = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(shown.contains("from near with the face abeam"), "{shown}");
    let json = fs::read_to_string(folder.0.path().join("out.json")).unwrap();
    let records: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    let names = records.iter().map(|record| {
        let text = |key: &str| record[key].as_str().unwrap().to_owned();
        (text("series"), text("method"))
    });
    let expected = [
        ("near", "ism-tuned"),
        ("near", "plus"),
        ("corner", "ism-tuned"),
        ("corner", "plus"),
    ];
    let expected = expected.map(|(series, method)| (series.to_owned(), method.to_owned()));
    assert_eq!(names.collect::<Vec<_>>(), expected);
    let first = &records[0];
    // Of the example's simulated series the worst has 10 mm, 34 mm and 1.
    assert!(first["bias_mm"].as_f64().unwrap().abs() < 10.0, "{json}");
    assert!(first["rms_mm"].as_f64().unwrap() < 35.0, "{json}");
    assert!(first["recall_15"].as_f64().unwrap() > 0.9, "{json}");
    assert!(first["recall_20"].as_f64() >= first["recall_15"].as_f64());
    assert!(first["false_cells"].is_u64(), "{json}");
    assert!(first["end_error_mm"].is_null(), "{json}");
    // The same description from elsewhere, and the ends of a wall swapped.
    let turned = DESCRIPTION.replacen(
        "from = [0.0, 0.1]\nto = [0.3, 0.1]",
        "from = [0.3, 0.1]\nto = [0.0, 0.1]",
        1,
    );
    fs::create_dir(folder.0.path().join("elsewhere")).unwrap();
    folder.write("elsewhere/other.toml", &turned);
    let other = [
        methods.as_slice(),
        &["--series", "elsewhere/other.toml", "--json", "other.json"],
    ];
    let again = folder.evaluate(&other.concat());
    assert_eq!(again.status.code(), Some(0), "{again:?}");
    let other = fs::read_to_string(folder.0.path().join("other.json")).unwrap();
    let other: Vec<serde_json::Value> = serde_json::from_str(&other).unwrap();
    assert_eq!(other[0]["recall_15"], first["recall_15"]);
    assert_eq!(other[0]["false_cells"], first["false_cells"]);
}

#[test]
fn a_folder_without_a_description_names_what_to_copy() {
    let folder = Folder::new("none");
    let output = folder.evaluate(&[]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for words in [
        "series.toml: cannot be read",
        "scenarios/recorded_series.toml",
        "--series",
    ] {
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn the_files_that_are_read_are_not_written() {
    let folder = Folder::new("input");
    folder.write("series.toml", DESCRIPTION);
    for file in ["near.txt", "series.toml"] {
        let before = fs::read(folder.0.path().join(file)).unwrap();
        let output = folder.evaluate(&["--methods", "plus", "--json", file]);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert_eq!(
            fs::read(folder.0.path().join(file)).unwrap(),
            before,
            "{file}"
        );
    }
}

#[test]
fn descriptions_that_are_wrong_are_refused_with_file_line_and_key() {
    let folder = Folder::new("hostile");
    let cases = [
        ("station_step_m = 0.04", "station_step_m = nan", "line 6"),
        (
            "station_step_m = 0.04",
            "station_step_m = 1e300",
            "outside 0.001 to 1",
        ),
        (
            "station_step_m = 0.04",
            "station_step_m = 0.0",
            "outside 0.001 to 1",
        ),
        ("first_station_m = -0.2", "first_station_m = -inf", "line 5"),
        (
            "first_station_m = -0.2",
            "first_station_m = 1e9",
            "outside -1000 to 1000",
        ),
        (
            "first_station_m = -0.2\n",
            "",
            "missing field `first_station_m`",
        ),
        ("truth =", "story =", "unknown field `story`"),
        (
            "\"by the ruler\"",
            "\"\\u001b[2J\"",
            "line 4: truth: holds a control",
        ),
        (
            "[3, 4]",
            "[3, 8]",
            "line 7: masked_sensors: there is no sensor 8",
        ),
        ("[3, 4]", "[-1]", "line 7"),
        (
            "[3, 4]",
            "[0,1,2,3,4,5,6,7]",
            "line 7: masked_sensors: all sensors",
        ),
        ("[3, 4]", "[0, 1, 2]", "no alpha from near: "),
        ("[0.0, 0.1]", "[nan, 0.1]", "line 9"),
        (
            "[0.0, 0.1]",
            "[-900, 0.1]",
            "line 8: wall: a length of 900.3 m",
        ),
        ("[0.0, 0.1]", "[0.3, 0.1]", "line 8: wall: a length of 0 m"),
        (
            "to = [0.3, 0.1]",
            "to = [0.3, 0.1]\nheight_m = 1",
            "unknown field `height_m`",
        ),
        (
            "from = [0.0, 0.1]\nto = [0.3, 0.1]",
            "from = [0, 0]\nto = [1, 0]",
            "in line with",
        ),
        ("radius_m = 0.03", "radius_m = 0", "outside 0.001 to 10"),
        (
            "file = \"near.txt\"",
            "file = \"../near.txt\"",
            "line 3: file: `../near.txt`",
        ),
        (
            "file = \"near.txt\"",
            "file = \"/dev/zero\"",
            "line 3: file: `/dev/zero`",
        ),
        ("file = \"near.txt\"", "file = \"\"", "line 3: file: ``"),
        (
            "file = \"corner.txt\"",
            "file = \"near.txt\"",
            "line 12: file: a second series",
        ),
        (
            "file = \"corner.txt\"",
            "file = \"gone.txt\"",
            "line 12: file: ",
        ),
        (
            "alpha_from = \"near.txt\"",
            "alpha_from = \"far\"",
            "line 1: alpha_from: is the",
        ),
        (
            "alpha_from = \"near.txt\"",
            "alpha_from = [",
            "TOML parse error at line 3",
        ),
    ];
    for (old, new, words) in cases {
        assert!(DESCRIPTION.contains(old), "{old}");
        let message = folder.refusal(&DESCRIPTION.replacen(old, new, 1));
        assert!(message.contains(words), "{new}: wanted {words}\n{message}");
        let is_named = message.contains("series.toml") || words.starts_with("no alpha");
        assert!(is_named, "{new}\n{message}");
        assert!(!message.contains('\u{1b}'), "{message}");
    }
    let wall = "[[series.wall]]\nfrom = [0, 0.1]\nto = [1, 0.1]\n";
    let message = folder.refusal(&(DESCRIPTION.to_owned() + &wall.repeat(100)));
    assert!(message.contains("104 walls and shapes"), "{message}");
    let message = folder.refusal(&"#\n".repeat(1 << 20));
    assert!(message.contains("more than 1048576 bytes"), "{message}");
    fs::write(folder.0.path().join("series.toml"), b"\xff\xfe").unwrap();
    assert_eq!(folder.evaluate(&[]).status.code(), Some(2));
}

#[test]
fn recordings_that_are_no_series_are_refused_at_their_name() {
    let folder = Folder::new("stations");
    let three = (0..3).map(|x| format!("0\t0\t0\t0\t0\t0\t0\t0\t{}\t0\t0\n", 256 * x));
    let three: String = three.collect();
    let cases = [
        (
            recording(1) + &three.repeat(333_333),
            "1000000 stations, at most 10000 are allowed",
        ),
        (recording(14) + "1\t2\n", "14 rows, 1 refused"),
        (recording(0), "near.txt"),
        (String::new(), "near.txt: is empty"),
        ("\0".repeat(4096), "near.txt"),
    ];
    for (text, words) in cases {
        folder.write("near.txt", &text);
        let message = folder.refusal(DESCRIPTION);
        assert!(message.contains("line 3: file: "), "{message}");
        assert!(message.contains(words), "wanted {words}: {message}");
    }
}
