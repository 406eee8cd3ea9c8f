//! The real robot beside walls whose place is known: maps, and the simulator's own error.
//!
//! The robot was put down by hand at stations of equal distance beside walls that were
//! measured; a TOML file beside the recordings describes stations and walls. Alpha is
//! calibrated on one of the series, the other parameters are the default's; then each
//! series is mapped with the same law by each method, and simulated under both physics.
//!
//! **Steps.** The stations of the series of 2015 are 50 mm apart, five times the filter's
//! step of 10 mm. The step rule makes at most one step per reading and loses the whole
//! steps inside a longer piece: every station is one step. A place beside the robot is then in
//! view for a fifth of the steps that a drive gives it, and few particles survive the
//! four or five that the gate asks for. The scores of the filter's profiles show the
//! effect of that, not the quality of a drive's map; the maps of the same stations in a
//! simulation separate the effect of the spacing from that of the readings.

mod counts;
mod ends;
mod error;
mod face;
mod records;
mod report;
mod series;
mod series_file;
mod walls;

use std::path::{Path, PathBuf};

use amiro_ipf::model::Photometry;
use serde::Serialize;

use self::counts::{CountComparison, alpha_under, matched_alpha, simulated};
use self::series::Series;
use self::series_file::SeriesFile;
use crate::mapping::Method;
use crate::world::Physics;

pub use counts::SensorError;
pub use ends::{MappedEnd, WallEnd};
pub use error::{KeyPlace, RecordedError};
pub use walls::SeriesWalls;

/// Name of the file that describes the series of a folder.
pub const SERIES_FILE: &str = "series.toml";

/// What recorded series are mapped with.
#[derive(Clone, Debug)]
pub struct RecordedSettings {
    /// The methods that are compared, in the order of the report.
    pub methods: Vec<Method>,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
}

/// How well a physics explains the recorded counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicsError {
    /// Its name.
    pub physics: String,
    /// The gain that was simulated with, counts m^2.
    pub alpha_counts_m2: f64,
    /// Whether that gain was fitted under this very physics.
    pub is_own_alpha: bool,
    /// Sensor by sensor, over all series.
    pub sensors: Vec<SensorError>,
    /// All sensors together, series by series.
    pub series: Vec<(String, SensorError)>,
    /// All sensors and series together.
    pub together: SensorError,
}

/// The results of the real robot's readings beside known walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordedReport {
    /// Gain calibrated on one of the series with the filter's own law, counts m^2.
    pub alpha_counts_m2: f64,
    /// The series that it is calibrated on.
    pub alpha_from: String,
    /// The series, and where its stations and walls are known from.
    pub sources: Vec<(String, String)>,
    /// Maps against walls: series by series, method by method.
    pub walls: Vec<SeriesWalls>,
    /// The simulator against the recordings: `matched` and `patch` with the calibrated
    /// gain, then `patch` with the gain that it fits best itself on the same readings.
    pub physics: Vec<PhysicsError>,
}

/// Described series with their recordings.
#[derive(Clone, Debug)]
pub struct RecordedSeries {
    all: Vec<Series>,
    /// Index of the series that alpha is calibrated on.
    alpha_from: usize,
    /// The files that were read.
    files: Vec<PathBuf>,
}

impl RecordedSeries {
    /// Reads the recordings of a folder that a file describes.
    ///
    /// # Errors
    /// The description is refused, a recording is missing or lacks rows. There is no
    /// report of some of them: the figures are compared over all.
    pub fn load(folder: &Path, description: &Path) -> Result<Self, RecordedError> {
        let file = SeriesFile::load(description, folder)?;
        let all: Result<_, _> = file.settings.iter().map(Series::load).collect();
        let recordings = file.settings.iter().map(|setting| setting.path.clone());
        Ok(Self {
            all: all?,
            alpha_from: file.alpha_from,
            files: recordings.chain([description.to_owned()]).collect(),
        })
    }

    /// The files that were read: the recordings and their description.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Maps and simulates the series; `progress` is called with the number of readings
    /// that are mapped by all methods, and of those to be mapped.
    ///
    /// Everything in the report is repeatable to the digit.
    ///
    /// # Errors
    /// [`RecordedError::Calibration`] and [`RecordedError::Run`].
    pub fn judge(
        &self,
        settings: &RecordedSettings,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<RecordedReport, RecordedError> {
        let all = &self.all;
        let default = Photometry::VCNL4020;
        let calibrated = &all[self.alpha_from];
        let alpha =
            matched_alpha(calibrated, &default).map_err(|error| RecordedError::Calibration {
                series: calibrated.name.clone(),
                what: error.to_string(),
            })?;
        let law = with_alpha(&default, alpha);
        let own = alpha_under(calibrated, &default, Physics::Patch);
        let wall_law = with_alpha(&default, own.unwrap_or(alpha));
        let mut walls = Vec::new();
        let both = [Physics::Matched, Physics::Patch];
        let readings = (1 + both.len()) * all.len();
        let mut mapped = (1..).map(|done| progress(done, readings));
        for series in all {
            walls.extend(SeriesWalls::of(series, &law, &wall_law, settings)?);
            mapped.next();
            for physics in both {
                let simulated = simulated(series, &law, physics);
                walls.extend(SeriesWalls::of(&simulated, &law, &law, settings)?);
                mapped.next();
            }
        }
        let same = both.map(|physics| PhysicsError::of(all, &default, physics, alpha, false));
        let own = own.map(|alpha| PhysicsError::of(all, &default, Physics::Patch, alpha, true));
        Ok(RecordedReport {
            alpha_counts_m2: alpha,
            alpha_from: calibrated.name.clone(),
            sources: all
                .iter()
                .map(|series| (series.name.clone(), series.truth.clone()))
                .collect(),
            walls,
            physics: same.into_iter().chain(own).collect(),
        })
    }
}

fn with_alpha(law: &Photometry, alpha: f64) -> Photometry {
    Photometry {
        alpha_counts_m2: alpha as f32,
        ..*law
    }
}

impl PhysicsError {
    fn of(
        all: &[Series],
        law: &Photometry,
        physics: Physics,
        alpha: f64,
        is_own_alpha: bool,
    ) -> Self {
        let law = with_alpha(law, alpha);
        let comparison = CountComparison::of(all, &law, physics);
        let alone = |series: &Series| {
            let alone = CountComparison::of(std::slice::from_ref(series), &law, physics);
            (series.name.clone(), alone.together())
        };
        Self {
            physics: physics.to_string(),
            alpha_counts_m2: alpha,
            is_own_alpha,
            sensors: comparison.sensors(),
            series: all.iter().map(alone).collect(),
            together: comparison.together(),
        }
    }
}
