//! Scenarios from TOML files.

use std::io::Read;
use std::path::Path;

use amiro_ipf::model::SENSORS;
use serde::Deserialize;

use super::bounded::{CellSize, Coordinate, Degrees, Speed};
use super::opening::{Extent, OpeningTable};
use super::scenario_error::is_standard_input;
use super::scenario_limits::{MAX_BYTES, at_most};
use super::shape::{BoxTable, CylinderTable};
use super::{Allowance, Leg, Scenario, ScenarioError, Shape};
use crate::geometry::Vector;

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
        let keys: ScenarioKeys = toml::from_str(text)?;
        let scenario = Self::from(keys);
        scenario.check_limits()?;
        Ok(scenario)
    }
}

/// The keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Keys")]
struct ScenarioKeys {
    name: String,
    #[serde(default)]
    about: String,
    cell_m: CellSize,
    extent_m: Extent,
    speed_m_per_s: Speed,
    sensors_deg: Option<Angles>,
    start: StartPose,
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
#[serde(rename = "Start")]
struct StartPose(Coordinate, Coordinate, Degrees);

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

impl From<ScenarioKeys> for Scenario {
    fn from(keys: ScenarioKeys) -> Self {
        let StartPose(x, y, heading) = keys.start;
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
    use std::path::PathBuf;

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
            assert_eq!(scenario.ring().1.len(), sensors, "{name}");
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
