//! The description of recorded series, a TOML file beside the recordings.
//!
//! `scenarios/README.md` lists the keys.

use std::path::{Path, PathBuf};

use amiro_ipf::model::{SENSORS, SensorMask};
use serde::Deserialize;
use toml::Spanned;

use super::error::{KeyPlace, RecordedError};
use super::face::Face;
use crate::bounded::read_at_most;
use crate::escape::whole_escaped;
use crate::geometry::Vector;
use crate::world::{Bounded, BoxTable, Coordinate, CylinderTable, Reflectivity, Shape};

/// Longest file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Greatest number of series in a file.
const MAX_SERIES: usize = 100;
/// Greatest number of walls and other shapes of a series.
const MAX_SHAPES: usize = 50;
/// Depth of a wall whose depth is not given, metres.
const WALL_DEPTH_M: f64 = 0.1;

/// A length of a wall, metres: 1 mm to 10 m.
type Length = Bounded<1, 10_000>;
/// A distance between stations, metres: 1 mm to 1 m.
type StationStep = Bounded<1, 1_000>;

/// A series as its description has it.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    /// Name of the recording's file without its extension.
    pub(super) name: String,
    /// The recording's file.
    pub(super) path: PathBuf,
    /// Where the recording's file is named.
    pub(super) at: KeyPlace,
    /// Where the stations and the walls are known from.
    pub(super) truth: String,
    pub(super) first_station_m: f64,
    pub(super) station_step_m: f64,
    /// The sensors that are not masked.
    pub(super) used: SensorMask,
    pub(super) faces: Vec<Face>,
    /// The walls, then the other shapes.
    pub(super) shapes: Vec<Shape>,
}

/// The description of all series of a folder.
#[derive(Clone, Debug)]
pub(super) struct SeriesFile {
    pub(super) settings: Vec<Setting>,
    /// Index of the series that alpha is calibrated on.
    pub(super) alpha_from: usize,
}

/// The keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SeriesFileKeys {
    alpha_from: Spanned<String>,
    series: Vec<SeriesKeys>,
}

/// The keys of a `[[series]]` table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SeriesKeys {
    file: Spanned<String>,
    truth: Spanned<String>,
    first_station_m: Coordinate,
    station_step_m: StationStep,
    masked_sensors: Option<Spanned<Vec<u64>>>,
    wall: Vec<Spanned<WallKeys>>,
    #[serde(default, rename = "box")]
    boxes: Vec<BoxTable>,
    #[serde(default, rename = "cylinder")]
    cylinders: Vec<CylinderTable>,
}

/// The keys of a `[[series.wall]]` table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WallKeys {
    from: [Coordinate; 2],
    to: [Coordinate; 2],
    depth_m: Option<Length>,
    reflectivity: Option<Reflectivity>,
}

impl SeriesFile {
    /// Reads the description of the recordings in a folder.
    ///
    /// # Errors
    /// [`RecordedError`] with file, line and key; the recordings are not looked at.
    pub(super) fn load(path: &Path, folder: &Path) -> Result<Self, RecordedError> {
        let bytes = read_at_most(path, MAX_BYTES);
        let text = bytes.and_then(|bytes| String::from_utf8(bytes).map_err(std::io::Error::other));
        let text = text.map_err(|source| RecordedError::unreadable(path, source))?;
        Self::parse(&path.to_string_lossy(), &text, folder)
    }

    /// Reads a description from its text; `file` is the name that errors begin with.
    pub(super) fn parse(file: &str, text: &str, folder: &Path) -> Result<Self, RecordedError> {
        let source = SeriesText {
            file: whole_escaped(file.chars()),
            text,
        };
        let keys: SeriesFileKeys = toml::from_str(text).map_err(|error| RecordedError::Format {
            file: source.file.clone(),
            source: Box::new(error),
        })?;
        let alpha_from = &keys.alpha_from;
        let count = keys.series.len();
        if count > MAX_SERIES {
            let what = format!("{count} series, at most {MAX_SERIES} are allowed");
            return source.refuse("series", alpha_from, what);
        }
        let mut settings: Vec<Setting> = Vec::new();
        for keys in keys.series {
            let at = keys.file.clone();
            let setting = source.setting(keys, folder)?;
            if settings.iter().any(|other| other.name == setting.name) {
                let what = format!("a second series named {}", setting.name);
                return source.refuse("file", &at, what);
            }
            settings.push(setting);
        }
        let wanted = folder.join(alpha_from.get_ref());
        let Some(alpha_from) = settings.iter().position(|setting| setting.path == wanted) else {
            let what = "is the `file` of no series".to_owned();
            return source.refuse("alpha_from", alpha_from, what);
        };
        Ok(Self {
            settings,
            alpha_from,
        })
    }
}

/// The text of a description, for the places in it.
struct SeriesText<'t> {
    file: String,
    text: &'t str,
}

impl SeriesText<'_> {
    fn at<T>(&self, key: &'static str, value: &Spanned<T>) -> KeyPlace {
        let before = self.text.as_bytes().iter().take(value.span().start);
        KeyPlace {
            file: self.file.clone(),
            line: 1 + before.filter(|byte| **byte == b'\n').count(),
            key,
        }
    }

    fn refuse<T, R>(
        &self,
        key: &'static str,
        value: &Spanned<T>,
        what: String,
    ) -> Result<R, RecordedError> {
        let at = self.at(key, value);
        Err(RecordedError::Value { at, what })
    }

    fn setting(&self, keys: SeriesKeys, folder: &Path) -> Result<Setting, RecordedError> {
        let name = self.name(&keys.file)?;
        // It is printed.
        if keys.truth.get_ref().chars().any(char::is_control) {
            let what = "holds a control character".to_owned();
            return self.refuse("truth", &keys.truth, what);
        }
        let shapes = keys.wall.len() + keys.boxes.len() + keys.cylinders.len();
        if shapes > MAX_SHAPES || keys.wall.is_empty() {
            let what = format!("{shapes} walls and shapes; 1 wall to {MAX_SHAPES} are allowed");
            return self.refuse("wall", &keys.file, what);
        }
        let first_station_m = keys.first_station_m.value();
        let used = match &keys.masked_sensors {
            Some(masked) => self.used(masked)?,
            None => SensorMask::ALL,
        };
        let (mut faces, mut shapes) = (Vec::new(), Vec::new());
        for wall in &keys.wall {
            let (face, shape) = self.wall(wall, Vector::new(first_station_m, 0.0))?;
            faces.push(face);
            shapes.push(shape);
        }
        shapes.extend(keys.boxes.into_iter().map(|table| table.0));
        shapes.extend(keys.cylinders.into_iter().map(Shape::from));
        Ok(Setting {
            name,
            path: folder.join(keys.file.get_ref()),
            at: self.at("file", &keys.file),
            truth: keys.truth.into_inner(),
            first_station_m,
            station_step_m: keys.station_step_m.value(),
            used,
            faces,
            shapes,
        })
    }

    /// The series' name: that of its file, which must lie in the folder itself.
    fn name(&self, file: &Spanned<String>) -> Result<String, RecordedError> {
        let text = file.get_ref();
        let is_plain = Path::new(text)
            .file_name()
            .is_some_and(|name| name == text.as_str());
        if !is_plain || text.chars().any(|c| c.is_control() || c == '\\') {
            let shown = whole_escaped(text.chars());
            let what = format!("`{shown}` is no name of a file in the folder of the recordings");
            return self.refuse("file", file, what);
        }
        let stem = Path::new(text).file_stem().unwrap_or_default();
        Ok(stem.to_string_lossy().into_owned())
    }

    fn used(&self, masked: &Spanned<Vec<u64>>) -> Result<SensorMask, RecordedError> {
        let mut mask = SensorMask::NONE;
        for sensor in masked.get_ref() {
            let index = usize::try_from(*sensor)
                .ok()
                .filter(|index| *index < SENSORS);
            let Some(index) = index else {
                let what = format!("there is no sensor {sensor}; they are 0 to {}", SENSORS - 1);
                return self.refuse("masked_sensors", masked, what);
            };
            mask = mask.with(index);
        }
        if mask == SensorMask::ALL {
            let what = "all sensors are masked".to_owned();
            return self.refuse("masked_sensors", masked, what);
        }
        Ok(mask.complement())
    }

    fn wall(
        &self,
        keys: &Spanned<WallKeys>,
        first: Vector,
    ) -> Result<(Face, Shape), RecordedError> {
        let wall = keys.get_ref();
        let [from, to] = [wall.from, wall.to].map(|[x, y]| Vector::new(x.value(), y.value()));
        let length_m = (to - from).norm();
        let (least, most) = Length::RANGE;
        if !(least..=most).contains(&length_m) {
            let what = format!("a length of {length_m} m is outside {least} to {most}");
            return self.refuse("wall", keys, what);
        }
        let Some(face) = Face::towards(first, from, to) else {
            let what = "is in line with the first station, which must see its face".to_owned();
            return self.refuse("wall", keys, what);
        };
        let depth_m = wall.depth_m.map_or(WALL_DEPTH_M, Length::value);
        let reflectivity = wall.reflectivity.map_or(1.0, Reflectivity::value);
        let shape = Shape::behind(from, to, face.away.scaled(depth_m), reflectivity);
        Ok((face, shape))
    }
}
