//! Rigs as TOML files.

use std::io;
use std::path::Path;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::Photometry;
use amiro_ipf::node::Config;
use serde::Deserialize;

use super::{Rig, SensorMount};
use crate::bounded::read_at_most;
use crate::escape::{lines_escaped, whole_escaped};
use crate::geometry::Pose2;
use crate::sensors::{Cone, Directivity, Infrared, Scanner, Sensor};

/// Longest file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Most mounts.
const MAX_MOUNTS: usize = 256;

/// Most beams of a scanner.
const MAX_BEAMS: u16 = 8192;

/// Farthest place of a mount and largest radius, metres.
const MAX_SIZE_M: f64 = 10.0;

/// Longest range, metres.
const MAX_RANGE_M: f64 = 200.0;

/// Why a rig was refused.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file's name, escaped.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The text is no rig: an unknown key, a missing one, a value of another type.
    #[error("{file}: {}", lines_escaped(&.source.to_string()))]
    Format {
        /// The file's name, escaped.
        file: String,
        /// The error with its line.
        source: Box<toml::de::Error>,
    },
    /// A value is outside its range.
    #[error("{file}: {key} is {value}; {range}")]
    Value {
        /// The file's name, escaped.
        file: String,
        /// The key, with the mount's name where it belongs to one.
        key: String,
        /// The value.
        value: String,
        /// What is allowed.
        range: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Keys")]
struct RigKeys {
    name: String,
    about: String,
    radius_m: f64,
    track_m: Option<f64>,
    mount: Vec<MountKeys>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MountKeys {
    name: String,
    position_m: [f64; 2],
    heading_deg: f64,
    sensor: SensorKeys,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum SensorKeys {
    Infrared(InfraredKeys),
    Cone(ConeKeys),
    Scanner(ScannerKeys),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InfraredKeys {
    alpha_counts_m2: f32,
    beta_counts: f32,
    delta_m2: f32,
    xi: f32,
    sigma_counts: f32,
    x_max_m: f32,
    theta_max_deg: f32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ConeKeys {
    half_angle_deg: f64,
    range_m: [f64; 2],
    sigma_m: f64,
    #[serde(default)]
    directivity: DirectivityKey,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DirectivityKey {
    #[default]
    Piston,
    Flat,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScannerKeys {
    beams: u16,
    first_deg: f64,
    step_deg: f64,
    range_m: [f64; 2],
    sigma_m: f64,
}

impl Rig {
    /// Reads a rig from a file of at most 1 MiB.
    ///
    /// # Errors
    /// [`RigError::Read`], and as for [`parse`](Self::parse).
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let name = whole_escaped(path.to_string_lossy().chars());
        let text = read_at_most(path, MAX_BYTES)
            .and_then(|bytes| String::from_utf8(bytes).map_err(io::Error::other));
        match text {
            Ok(text) => Self::parse(&name, &text),
            Err(source) => Err(RigError::Read { file: name, source }),
        }
    }

    /// Reads a rig from its text; `file` is the name that errors begin with.
    ///
    /// # Errors
    /// [`RigError::Format`] with the line, [`RigError::Value`] with key, value and range.
    pub fn parse(file: &str, text: &str) -> Result<Self, RigError> {
        let check = Check { file, mount: None };
        check.within("file", text.len() as f64, 0.0, MAX_BYTES as f64, "bytes")?;
        let keys: RigKeys = toml::from_str(text).map_err(|source| RigError::Format {
            file: file.to_owned(),
            source: Box::new(source),
        })?;
        check.text("name", &keys.name)?;
        check.text("about", &keys.about)?;
        let mounts = keys.mount.len() as f64;
        check.within("mount", mounts, 1.0, MAX_MOUNTS as f64, "mounts")?;
        check.within("radius_m", keys.radius_m, 0.001, MAX_SIZE_M, "m")?;
        if let Some(track_m) = keys.track_m {
            check.within("track_m", track_m, 0.001, MAX_SIZE_M, "m")?;
        }
        let mounts: Result<_, _> = keys
            .mount
            .into_iter()
            .map(|keys| mount(file, keys))
            .collect();
        Ok(Self {
            name: keys.name,
            about: keys.about,
            radius_m: keys.radius_m,
            track_m: keys.track_m,
            mounts: mounts?,
        })
    }
}

fn mount(file: &str, keys: MountKeys) -> Result<SensorMount, RigError> {
    Check { file, mount: None }.text("mount.name", &keys.name)?;
    let check = Check {
        file,
        mount: Some(&keys.name),
    };
    let [x, y] = keys.position_m;
    check.within("position_m", x, -MAX_SIZE_M, MAX_SIZE_M, "m")?;
    check.within("position_m", y, -MAX_SIZE_M, MAX_SIZE_M, "m")?;
    check.within("heading_deg", keys.heading_deg, -360.0, 360.0, "degrees")?;
    let sensor = match keys.sensor {
        SensorKeys::Infrared(keys) => Sensor::Infrared(infrared(check, &keys)?),
        SensorKeys::Cone(keys) => Sensor::Cone(cone(check, &keys)?),
        SensorKeys::Scanner(keys) => Sensor::Scanner(scanner(check, &keys)?),
    };
    Ok(SensorMount {
        name: keys.name,
        body_from_sensor: Pose2::new(x, y, keys.heading_deg.to_radians()),
        sensor,
    })
}

fn infrared(check: Check<'_>, keys: &InfraredKeys) -> Result<Infrared, RigError> {
    let photometry = Photometry {
        alpha_counts_m2: keys.alpha_counts_m2,
        beta_counts: keys.beta_counts,
        delta_m2: keys.delta_m2,
        xi: keys.xi,
        sigma_counts: keys.sigma_counts,
        x_max_m: keys.x_max_m,
        theta_max_rad: keys.theta_max_deg.to_radians(),
    };
    let config = Config {
        photometry,
        ..Config::amiro(Profile::Paper)
    };
    config
        .validate()
        .map_err(|error| check.refusal("sensor.infrared", "refused", error.to_string()))?;
    Ok(Infrared::new(photometry))
}

fn cone(check: Check<'_>, keys: &ConeKeys) -> Result<Cone, RigError> {
    check.within("half_angle_deg", keys.half_angle_deg, 0.1, 89.0, "degrees")?;
    check.ranges(keys.range_m, keys.sigma_m)?;
    Ok(Cone {
        half_angle_rad: keys.half_angle_deg.to_radians(),
        range_m: keys.range_m,
        sigma_m: keys.sigma_m,
        directivity: match keys.directivity {
            DirectivityKey::Piston => Directivity::Piston,
            DirectivityKey::Flat => Directivity::Flat,
        },
    })
}

fn scanner(check: Check<'_>, keys: &ScannerKeys) -> Result<Scanner, RigError> {
    let beams = f64::from(keys.beams);
    check.within("beams", beams, 1.0, f64::from(MAX_BEAMS), "beams")?;
    check.within("first_deg", keys.first_deg, -360.0, 360.0, "degrees")?;
    check.within("step_deg", keys.step_deg, -90.0, 90.0, "degrees")?;
    check.ranges(keys.range_m, keys.sigma_m)?;
    Ok(Scanner {
        beams: keys.beams,
        first_rad: keys.first_deg.to_radians(),
        step_rad: keys.step_deg.to_radians(),
        range_m: keys.range_m,
        sigma_m: keys.sigma_m,
    })
}

/// Checks values and names the place of one that is refused.
#[derive(Clone, Copy)]
struct Check<'a> {
    file: &'a str,
    mount: Option<&'a str>,
}

impl Check<'_> {
    fn within(
        self,
        key: &str,
        value: f64,
        low: f64,
        high: f64,
        unit: &str,
    ) -> Result<(), RigError> {
        // NaN lies in no range.
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(self.refusal(
            key,
            &value.to_string(),
            format!("{low} to {high} {unit} are allowed"),
        ))
    }

    fn ranges(self, [nearest, farthest]: [f64; 2], sigma_m: f64) -> Result<(), RigError> {
        self.within("range_m", nearest, 0.0, farthest, "m")?;
        self.within("range_m", farthest, nearest.max(0.001), MAX_RANGE_M, "m")?;
        self.within("sigma_m", sigma_m, 0.0, farthest, "m")
    }

    fn text(self, key: &str, text: &str) -> Result<(), RigError> {
        if !text.is_empty() && !text.chars().any(char::is_control) {
            return Ok(());
        }
        let shown = whole_escaped(text.chars());
        Err(self.refusal(
            key,
            &format!("\"{shown}\""),
            "a text without control characters is needed".to_owned(),
        ))
    }

    fn refusal(self, key: &str, value: &str, range: String) -> RigError {
        let key = match self.mount {
            Some(mount) => format!("{key} of mount \"{mount}\""),
            None => key.to_owned(),
        };
        RigError::Value {
            file: self.file.to_owned(),
            key,
            value: value.to_owned(),
            range,
        }
    }
}

#[cfg(test)]
mod tests {
    use amiro_ipf::model::{Ring, SENSORS};

    use super::*;

    const AMIRO: &str = include_str!("../../../rigs/amiro.toml");
    const PIONEER: &str = include_str!("../../../rigs/pioneer2dx.toml");
    const KCMA: &str = include_str!("../../../rigs/kcma.toml");

    fn message(text: &str) -> String {
        Rig::parse("a.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn the_amiro_is_the_ring_and_the_law_of_the_firmware() {
        let rig = Rig::parse("amiro.toml", AMIRO).unwrap();
        assert_eq!(rig.mounts.len(), SENSORS);
        for (index, mount) in rig.mounts.iter().enumerate() {
            let expected = Ring::AMIRO.mount(index);
            let Pose2 { position, heading } = mount.body_from_sensor;
            // The file has five decimals.
            assert!(
                (position.x - f64::from(expected.position.x)).abs() < 1e-5,
                "{index}"
            );
            assert!(
                (position.y - f64::from(expected.position.y)).abs() < 1e-5,
                "{index}"
            );
            assert!(
                (heading.sine - f64::from(expected.direction.sine)).abs() < 1e-6,
                "{index}"
            );
            let Sensor::Infrared(infrared) = &mount.sensor else {
                panic!("sensor {index} is {:?}", mount.sensor);
            };
            assert_eq!(
                *infrared.photometry(),
                Photometry::VCNL4020,
                "sensor {index}"
            );
        }
    }

    #[test]
    fn the_pioneer_has_sixteen_sonars_around_and_gaps_of_forty_degrees() {
        let rig = Rig::parse("pioneer2dx.toml", PIONEER).unwrap();
        let axes_deg: Vec<_> = rig
            .mounts
            .iter()
            .map(|mount| {
                let heading = mount.body_from_sensor.heading;
                libm::atan2(heading.sine, heading.cosine)
                    .to_degrees()
                    .round()
            })
            .collect();
        let half = [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0];
        assert_eq!(axes_deg[..8], half);
        assert_eq!(
            axes_deg[8..],
            half.map(|axis| -f64::copysign(180.0 - f64::abs(axis), axis))
        );
    }

    #[test]
    fn a_scan_of_the_kcma_robot_is_eight_sonars_and_a_laser() {
        let rig = Rig::parse("kcma.toml", KCMA).unwrap();
        let returns: Vec<_> = rig
            .mounts
            .iter()
            .map(|mount| mount.sensor.model().returns())
            .collect();
        assert_eq!(returns, [1, 1, 1, 1, 1, 1, 1, 1, 361]);
    }

    #[test]
    fn refusals_name_file_key_value_and_range() {
        let radius = message(&PIONEER.replace("radius_m = 0.22", "radius_m = -1"));
        assert_eq!(radius, "a.toml: radius_m is -1; 0.001 to 10 m are allowed");
        let cone = message(&KCMA.replacen("half_angle_deg = 12.5", "half_angle_deg = 95.0", 1));
        assert_eq!(
            cone,
            "a.toml: half_angle_deg of mount \"sonar 0\" is 95; 0.1 to 89 degrees are allowed"
        );
        let reversed = message(&KCMA.replacen("range_m = [0.17, 5.0]", "range_m = [5.0, 0.17]", 1));
        assert!(
            reversed.contains("range_m of mount \"sonar 0\" is 5"),
            "{reversed}"
        );
        let not_a_number = message(&KCMA.replacen("sigma_m = 0.03", "sigma_m = nan", 1));
        assert!(not_a_number.contains("sigma_m"), "{not_a_number}");
        let unknown = message(&KCMA.replacen("sigma_m", "sigma", 1));
        assert!(
            unknown.starts_with("a.toml: ") && unknown.contains("sigma"),
            "{unknown}"
        );
        let escape = message(&KCMA.replacen("sonar 0", "\\u001b[2J", 1));
        assert!(!escape.contains('\u{1b}'), "{escape}");
    }
}
