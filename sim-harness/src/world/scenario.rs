//! A world as a file describes it: what stands there, where the robot starts, how it drives.

use std::io::Read;
use std::path::{Path, PathBuf};

use amiro_ipf::filter::Profile;
use amiro_ipf::model::{Ring, SENSORS, SensorMask};
use amiro_ipf::node::Config;
use serde::Deserialize;

use super::bounded::{CellSize, Coordinate, Degrees, Speed};
use super::opening::{Extent, OpeningTable};
use super::shape::{BoxTable, CylinderTable};
use super::{Allowance, Leg, Opening, Rectangle, Shape};
use crate::escape::{lines_escaped, whole_escaped};
use crate::geometry::{Vector, radians};

/// Longest file, bytes.
const MAX_BYTES: usize = 4 << 20;
/// Most boxes and cylinders together.
const MAX_SHAPES: usize = 10_000;
/// Most legs of the drive, and most openings.
const MAX_LEGS: usize = 1_000;
/// Longest drive, metres.
const MAX_DRIVE_M: f64 = 1_000.0;
/// Longest drive, seconds.
const MAX_DRIVE_S: f64 = 3_600.0;
/// Most cells in the map's rectangle.
const MAX_CELLS: f64 = 4e6;
/// Longest outline of all shapes together, metres.
const MAX_OUTLINE_M: f64 = 10_000.0;
/// Most shapes times seconds of driving: minutes of computing, not hours.
const MAX_SHAPE_SECONDS: f64 = 400_000.0;

/// A world and a drive through it; the format is described in `scenarios/README.md`.
///
/// What [`parse`](Self::parse) returns is within all limits: an hour or a kilometre
/// of driving, 10 000 shapes, four million cells. A file cannot make a simulation
/// hang, only last some minutes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Scenario {
    /// A short name.
    pub name: String,
    /// What the scenario is about, in a sentence.
    pub about: String,
    /// Side of a map cell, metres.
    pub cell_m: f64,
    /// The map's rectangle; cells outside of it are not judged.
    pub extent: Rectangle,
    /// Linear speed while driving.
    pub speed_m_per_s: f64,
    /// Directions of the sensors in use, degrees; `None` is the AMiRo's ring.
    pub sensors_deg: Option<Vec<f64>>,
    /// Where the robot's centre is at the start.
    pub start: Vector,
    /// Where the robot looks at the start, degrees.
    pub start_heading_deg: f64,
    /// The legs of the drive, in order.
    pub drive: Vec<Leg>,
    /// What stands in the world.
    pub shapes: Vec<Shape>,
    /// Passages that a map must leave open.
    pub openings: Vec<Opening>,
    /// What no robot does, and this one does on purpose.
    pub allow: Vec<Allowance>,
}

/// Why a scenario was refused.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", whole_escaped(path.to_string_lossy().chars()))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The scenario of a file is none.
    #[error("{}: {source}", whole_escaped(name.chars()))]
    File {
        /// The file.
        name: String,
        /// Why.
        source: Box<ScenarioError>,
    },
    /// The text is no scenario; says the line and shows it.
    #[error("{}", lines_escaped(&.0.to_string()))]
    Format(#[from] toml::de::Error),
    /// A text that cannot be printed, values that are too much together, or a drive that
    /// cannot be.
    #[error("{key}: {what}")]
    Limit {
        /// The key, or the keys.
        key: &'static str,
        /// The value and the limit.
        what: String,
    },
}

impl Scenario {
    /// Reads a scenario from a file, and checks its drive.
    ///
    /// # Errors
    /// As for [`load_with_text`](Self::load_with_text).
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        Self::load_with_text(path).map(|(scenario, _)| scenario)
    }

    /// Reads a scenario from a file, and checks its drive; gives also the text that was
    /// read, for a pipe can be read once only. `-` is standard input.
    ///
    /// # Errors
    /// [`ScenarioError::Read`] if the file could not be read; otherwise
    /// [`ScenarioError::File`] with what [`parse`](Self::parse) or
    /// [`check_drive`](Self::check_drive) refuse.
    pub fn load_with_text(path: &Path) -> Result<(Self, String), ScenarioError> {
        let read = |path: &Path| {
            let mut text = String::new();
            // One byte more than is allowed: enough for the refusal.
            let limit = MAX_BYTES as u64 + 1;
            if is_standard_input(path) {
                std::io::stdin().take(limit).read_to_string(&mut text)?;
            } else {
                let file = std::fs::File::open(path)?;
                file.take(limit).read_to_string(&mut text)?;
            }
            Ok(text)
        };
        let text = read(path).map_err(|source| ScenarioError::Read {
            path: path.to_owned(),
            source,
        })?;
        let parsed = Self::parse(&text).and_then(|scenario| {
            scenario.check_drive()?;
            Ok(scenario)
        });
        match parsed {
            Ok(scenario) => Ok((scenario, text)),
            Err(source) => Err(source.of_file(path)),
        }
    }

    /// Reads a scenario from its text.
    ///
    /// # Errors
    /// [`ScenarioError::Format`] for an unknown key, a missing one and a value outside
    /// its range, with the line; [`ScenarioError::Limit`] for a world that is too
    /// large as a whole.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        at_most("file", text.len(), MAX_BYTES, "bytes")?;
        let keys: Keys = toml::from_str(text)?;
        let scenario = Self::from(keys);
        scenario.check()?;
        Ok(scenario)
    }

    /// The configuration of the filter for this world: the given profile, 1000
    /// particles a sensor, seed 1, and the sensors that the scenario uses.
    #[must_use]
    pub fn config(&self, profile: Profile) -> Config {
        let (ring, sensors) = self.ring();
        Config {
            ring,
            sensors,
            ..Config::amiro(profile)
        }
    }

    /// The ring and the sensors of it that are in use.
    #[must_use]
    pub fn ring(&self) -> (Ring, SensorMask) {
        let Some(angles) = &self.sensors_deg else {
            return (Ring::AMIRO, SensorMask::ALL);
        };
        let mut ring = Ring::AMIRO;
        let mut mask = SensorMask::NONE;
        for (sensor, (axis, angle)) in ring.axis_rad.iter_mut().zip(angles).enumerate() {
            *axis = radians(*angle);
            mask = mask.with(sensor);
        }
        (ring, mask)
    }

    /// How long the drive takes, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let durations = self
            .drive
            .iter()
            .map(|leg| leg.duration_s(self.speed_m_per_s));
        durations.sum()
    }

    fn check(&self) -> Result<(), ScenarioError> {
        for (key, text) in [("name", &self.name), ("about", &self.about)] {
            // Both are printed.
            if text.chars().any(char::is_control) {
                let what = "holds a control character".to_owned();
                return Err(ScenarioError::Limit { key, what });
            }
        }
        at_most("box, cylinder", self.shapes.len(), MAX_SHAPES, "shapes")?;
        at_most("drive", self.drive.len(), MAX_LEGS, "legs")?;
        at_most("opening", self.openings.len(), MAX_LEGS, "openings")?;
        let length_m: f64 = self.drive.iter().map(|leg| leg.length_m()).sum();
        within("drive", length_m, MAX_DRIVE_M, "metres in all")?;
        let duration_s = self.duration_s();
        within(
            "drive, speed_m_per_s",
            duration_s,
            MAX_DRIVE_S,
            "seconds in all",
        )?;
        let size = self.extent.max - self.extent.min;
        let cells = (size.x / self.cell_m) * (size.y / self.cell_m);
        within("extent_m, cell_m", cells, MAX_CELLS, "cells")?;
        let outline_m: f64 = self.shapes.iter().map(Shape::outline_m).sum();
        within(
            "box, cylinder",
            outline_m,
            MAX_OUTLINE_M,
            "metres of outline",
        )?;
        within(
            "box, cylinder, drive",
            self.shapes.len() as f64 * duration_s,
            MAX_SHAPE_SECONDS,
            "shapes times seconds of driving",
        )
    }
}

impl ScenarioError {
    /// The same with the name of the file that the scenario came from.
    #[must_use]
    pub fn of_file(self, path: &Path) -> Self {
        let name = if is_standard_input(path) {
            "standard input".to_owned()
        } else {
            path.to_string_lossy().into_owned()
        };
        Self::File {
            name,
            source: Box::new(self),
        }
    }
}

fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn at_most(key: &'static str, count: usize, limit: usize, of: &str) -> Result<(), ScenarioError> {
    within(key, count as f64, limit as f64, of)
}

fn within(key: &'static str, value: f64, limit: f64, of: &str) -> Result<(), ScenarioError> {
    if value <= limit {
        return Ok(());
    }
    Err(ScenarioError::Limit {
        key,
        what: format!("{value} {of}, at most {limit} are allowed"),
    })
}

/// The keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    name: String,
    #[serde(default)]
    about: String,
    cell_m: CellSize,
    extent_m: Extent,
    speed_m_per_s: Speed,
    sensors_deg: Option<Angles>,
    start: Start,
    #[serde(default)]
    drive: Vec<Leg>,
    #[serde(default, rename = "box")]
    boxes: Vec<BoxTable>,
    #[serde(default, rename = "cylinder")]
    cylinders: Vec<CylinderTable>,
    #[serde(default, rename = "opening")]
    openings: Vec<OpeningTable>,
    #[serde(default)]
    allow: Vec<Allowance>,
}

/// `[x, y, heading_deg]`.
#[derive(Debug, Deserialize)]
struct Start(Coordinate, Coordinate, Degrees);

/// One to eight angles.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Vec<Degrees>")]
struct Angles(Vec<f64>);

impl TryFrom<Vec<Degrees>> for Angles {
    type Error = String;

    fn try_from(angles: Vec<Degrees>) -> Result<Self, Self::Error> {
        if (1..=SENSORS).contains(&angles.len()) {
            Ok(Self(
                angles.into_iter().map(|angle| angle.value()).collect(),
            ))
        } else {
            Err(format!(
                "{} angles, 1 to {SENSORS} are allowed",
                angles.len()
            ))
        }
    }
}

impl From<Keys> for Scenario {
    fn from(keys: Keys) -> Self {
        let Start(x, y, heading) = keys.start;
        let boxes = keys.boxes.into_iter().map(|table| table.0);
        let cylinders = keys.cylinders.into_iter().map(Shape::from);
        Self {
            name: keys.name,
            about: keys.about,
            cell_m: keys.cell_m.value(),
            extent: keys.extent_m.0,
            speed_m_per_s: keys.speed_m_per_s.value(),
            sensors_deg: keys.sensors_deg.map(|angles| angles.0),
            start: Vector::new(x.value(), y.value()),
            start_heading_deg: heading.value(),
            drive: keys.drive,
            shapes: boxes.chain(cylinders).collect(),
            openings: keys.openings.into_iter().map(|table| table.0).collect(),
            allow: keys.allow,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "name = \"small\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\n\
        speed_m_per_s = 0.08\nstart = [0, 0, 0]\n";

    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
    }

    #[test]
    fn the_five_scenarios_of_the_paper_parse() {
        for (name, shapes, legs, openings, sensors, seconds) in [
            ("ssso", 1, 1, 0, 1, 3.625),
            ("msso", 1, 1, 0, 8, 3.625),
            ("msod", 1, 1, 0, 8, 7.5),
            ("msm_l", 10, 3, 1, 8, 12.75),
            ("msm_t", 13, 3, 2, 8, 12.75),
        ] {
            let scenario = Scenario::load(&folder().join(format!("{name}.toml"))).unwrap();
            assert_eq!(scenario.name, name);
            assert_eq!(scenario.shapes.len(), shapes, "{name}");
            assert_eq!(scenario.drive.len(), legs, "{name}");
            assert_eq!(scenario.openings.len(), openings, "{name}");
            let config = scenario.config(Profile::Plus);
            assert_eq!(config.sensors.len(), sensors, "{name}");
            assert_eq!(config.validate(), Ok(()), "{name}");
            assert!((scenario.duration_s() - seconds).abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn every_key_of_the_format_is_understood() {
        let text = format!(
            "about = \"all\"\nsensors_deg = [0, 90.0]\n{SMALL}\
             [[drive]]\nstraight_m = -0.5\n[[drive]]\narc_deg = 90\nradius_m = 0.04\n\
             [[box]]\nmin = [0.5, 0.5]\nmax = [0.6, 0.6]\nangle_deg = 30\nreflectivity = 0.5\n\
             [[cylinder]]\ncenter = [0, 0.5]\nradius_m = 0.03\nreflectivity = 2\n\
             [[opening]]\nmin = [0, 0]\nmax = [0.1, 0.1]\njudged_at_m = 0.5\n"
        );
        let scenario = Scenario::parse(&text).unwrap();
        assert_eq!(scenario.shapes.len(), 2);
        assert!((scenario.shapes[0].reflectivity() - 0.5).abs() < 1e-12);
        let (ring, mask) = scenario.ring();
        assert!(mask.iter().eq([0, 1]));
        assert!((ring.axis_rad[1] - core::f32::consts::FRAC_PI_2).abs() < 1e-6);
        assert_eq!(
            scenario.drive[1],
            Leg::Arc {
                angle_deg: 90.0,
                radius_m: 0.04
            }
        );
    }

    #[test]
    fn what_is_wrong_is_refused_with_key_value_and_line() {
        // A scenario's text, and what its refusal must say.
        let with = |more: &str| format!("{SMALL}{more}");
        let instead = |key: &str, line: &str| {
            let lines = SMALL.lines().filter(|old| !old.starts_with(key));
            lines
                .chain([line])
                .fold(String::new(), |text, line| text + line + "\n")
        };
        let cases = [
            (
                instead("cell_m", "cell_m = 0"),
                vec!["line 5", "cell_m", "0 is outside 0.001 to 0.1"],
            ),
            (
                instead("cell_m", "cell_m = nan"),
                vec!["line 5", "cell_m", "NaN is outside"],
            ),
            (
                instead("cell_m", "cell_m = \"a\""),
                vec!["line 5", "cell_m", "string"],
            ),
            (instead("cell_m", ""), vec!["missing field `cell_m`"]),
            (
                instead("speed", "speed_m_per_s = 1e9"),
                vec!["line 5", "speed_m_per_s", "1000000000"],
            ),
            (
                instead("extent", "extent_m = [1, 0, 0, 1]"),
                vec!["line 5", "extent_m", "min [1, 0]"],
            ),
            (
                instead("extent", "extent_m = [0, 0, 1]"),
                vec!["line 5", "extent_m"],
            ),
            (
                instead("start", "start = [0, inf, 0]"),
                vec!["line 5", "start", "inf is outside"],
            ),
            (
                with("sensors_deg = []"),
                vec!["line 6", "sensors_deg", "0 angles"],
            ),
            (
                with("sensors_deg = [1,2,3,4,5,6,7,8,9]"),
                vec!["line 6", "9 angles"],
            ),
            (
                with("allow = [\"flight\"]"),
                vec!["line 6", "allow", "unknown variant `flight`"],
            ),
            (with("colour = 1"), vec!["line 6", "unknown field `colour`"]),
            (
                with("[[box]]\nmin = [0, 0]\nmax = [1, 1]\nwidth = 1"),
                vec!["line 9", "width"],
            ),
            (
                with("[[box]]\nmin = [0, 0]\nmax = [1, 0]"),
                vec!["line 6", "[[box]]", "max [1, 0]"],
            ),
            (
                with("[[box]]\nmin = [0, 0]\nmax = [1, 1]\nreflectivity = 0"),
                vec!["line 9", "reflectivity"],
            ),
            (
                with("[[cylinder]]\ncenter = [0, 0]\nradius_m = -1"),
                vec!["line 8", "radius_m", "-1"],
            ),
            (
                with("[[drive]]\nstraight_m = 1\nturn_deg = 1"),
                vec!["line 6", "[[drive]]", "a drive leg has"],
            ),
            (
                with("[[drive]]\narc_deg = 1"),
                vec!["line 6", "arc_deg with radius_m"],
            ),
            (
                with("[[drive]]\nstraight_m = 1e4"),
                vec!["line 7", "straight_m", "10000"],
            ),
            (
                with("[[opening]]\nmin = [0, 0]\nmax = [1, 1]"),
                vec!["line 6", "judged_at_m"],
            ),
            (with("this is no TOML"), vec!["line 6"]),
        ];
        for (text, parts) in cases {
            let error = Scenario::parse(&text).unwrap_err().to_string();
            for part in parts {
                assert!(
                    error.contains(part),
                    "no {part:?} in:\n{error}\nfor:\n{text}"
                );
            }
        }
    }

    #[test]
    fn worlds_that_would_never_end_are_refused() {
        let leg = "[[drive]]\nstraight_m = 250\n";
        let shape = "[[cylinder]]\ncenter = [0, 0]\nradius_m = 0.01\n";
        let large = "[[box]]\nmin = [-1000, -1000]\nmax = [1000, 1000]\n";
        for (text, part) in [
            (SMALL.to_owned() + &leg.repeat(5), "drive: 1250 metres"),
            (
                SMALL.to_owned() + &leg.repeat(4),
                "speed_m_per_s: 12500 seconds",
            ),
            (
                SMALL.to_owned() + &"[[drive]]\nturn_deg = 1\n".repeat(1001),
                "1001 legs",
            ),
            (SMALL.to_owned() + &shape.repeat(10_001), "10001 shapes"),
            (
                SMALL.to_owned() + leg + &shape.repeat(1000),
                "shapes times seconds",
            ),
            (
                SMALL.to_owned() + &large.repeat(2),
                "16000 metres of outline",
            ),
            (
                SMALL.replace("[-1, -1, 1, 1]", "[-500, -1, 500, 1]"),
                "20000000 cells",
            ),
            (SMALL.to_owned() + &"#".repeat(MAX_BYTES), "bytes"),
            ("x = ".to_owned() + &"[".repeat(100_000), "recursion"),
        ] {
            let error = Scenario::parse(&text).unwrap_err().to_string();
            assert!(error.contains(part), "no {part:?} in {error:.300}");
        }
    }

    #[test]
    fn what_is_shown_of_a_bad_line_moves_no_cursor() {
        for text in [
            "\x1b[2J",
            "name = \"\x1b]0;owned\x07\"",
            "\"\u{9b}2J\u{202e}",
        ] {
            let error = Scenario::parse(text).unwrap_err().to_string();
            let moving = |letter: char| letter.is_control() && letter != '\n';
            assert!(!error.contains(moving), "{error:?}");
        }
    }

    #[test]
    fn a_name_that_would_move_the_cursor_is_refused() {
        for key in ["name", "about"] {
            let rest: Vec<_> = SMALL
                .lines()
                .filter(|line| !line.starts_with(key))
                .collect();
            let text = format!("{key} = \"\\u001b[2J\"\n{}\n", rest.join("\n"));
            let error = Scenario::parse(&text).unwrap_err().to_string();
            assert_eq!(error, format!("{key}: holds a control character"));
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = Scenario::load(Path::new("nowhere.toml")).unwrap_err();
        assert!(error.to_string().contains("nowhere.toml"), "{error}");
    }

    #[test]
    fn every_refusal_of_a_file_names_the_file_the_key_and_the_value() {
        let path = std::env::temp_dir().join(format!("ipf-scenario-{}.toml", std::process::id()));
        for (text, key, value) in [
            (SMALL.replace("0.01", "0"), "cell_m", "0 is outside"),
            (SMALL.replace("0.08", "3"), "speed_m_per_s", "3 m/s"),
            (
                SMALL.to_owned() + &"[[drive]]\nstraight_m = 250\n".repeat(5),
                "drive",
                "1250 metres",
            ),
            (
                SMALL.to_owned() + "[[cylinder]]\ncenter = [0, 0]\nradius_m = 0.1\n",
                "start",
                "[0.000, 0.000]",
            ),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = Scenario::load(&path).unwrap_err().to_string();
            let name = path.to_string_lossy();
            for part in [&*name, key, value] {
                assert!(error.contains(part), "no {part:?} in {error}");
            }
        }
        std::fs::remove_file(&path).unwrap();
    }
}
