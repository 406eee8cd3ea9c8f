//! The real robot beside walls whose place is known: maps, and the simulator's own error.
//!
//! Six series that the AMiRo's group recorded with the robot put down every 50 mm
//! along a box (`follow_wall*`, `Data_*`). Alpha is calibrated on `follow_wall40`, the
//! other parameters are the default's; then each series is mapped with the same law by
//! both profiles and the inverse sensor model, and simulated under both physics.
//!
//! **Steps.** A station is 50 mm from the one before, five times the filter's step of
//! 10 mm. The step rule makes at most one step a reading and loses the whole steps
//! inside a longer piece: every station is one step. A place beside the robot is then in
//! view for a fifth of the steps that a drive gives it, and few particles survive the
//! four or five that the gate asks for. The figures of the filter's profiles say how
//! they bear that, not how they map a drive; beside them stand the maps of the same
//! stations simulated, which tell the spacing's part from the readings'.
//!
//! Sensors 3 and 4 see the guide robot at all stations and are left out throughout.

mod counts;
mod report;
mod series;
mod walls;

use std::path::Path;

use amiro_ipf::model::Photometry;
use serde::Serialize;

use self::counts::{Comparison, alpha_under, matched_alpha, simulated};
use self::series::Series;
use crate::RunError;
use crate::calibration::{FitError, FixedError, TableError};
use crate::log::LogError;
use crate::world::{Physics, ScenarioError};

pub use counts::SensorError;
pub use walls::SeriesWalls;

/// The series that alpha is calibrated on.
const CALIBRATED_ON: &str = "follow_wall40";

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// A recording cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A recording lacks stations: those behind a gap would be in the wrong place.
    #[error("{series}: {rows} rows, {refused} refused")]
    Incomplete {
        /// Which.
        series: &'static str,
        /// Rows that are there.
        rows: usize,
        /// Rows that were refused.
        refused: u64,
    },
    /// The known world is no scenario.
    #[error(transparent)]
    World(#[from] ScenarioError),
    /// Too little to calibrate with.
    #[error("{CALIBRATED_ON}: {0}")]
    Calibration(String),
    /// The filter refused its configuration.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl From<TableError> for RecordedError {
    fn from(error: TableError) -> Self {
        Self::Calibration(error.to_string())
    }
}

impl From<FixedError> for RecordedError {
    fn from(error: FixedError) -> Self {
        Self::Calibration(error.to_string())
    }
}

impl From<FitError> for RecordedError {
    fn from(error: FitError) -> Self {
        Self::Calibration(error.to_string())
    }
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
    pub series: Vec<(&'static str, SensorError)>,
    /// All sensors and series together.
    pub together: SensorError,
}

/// What the real robot's readings beside known walls show.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordedReport {
    /// Gain calibrated on `follow_wall40` with the filter's own law, counts m^2.
    pub alpha_counts_m2: f64,
    /// The series, and where its stations and walls are known from.
    pub sources: Vec<(&'static str, &'static str)>,
    /// Maps against walls: series by series, method by method.
    pub walls: Vec<SeriesWalls>,
    /// The simulator against the recordings: `matched` and `patch` with the calibrated
    /// gain, then `patch` with the gain that it fits best itself on the same readings.
    pub physics: Vec<PhysicsError>,
}

/// Maps and simulates the stepped series of a folder.
///
/// The folder is that of the text files themselves. Everything in the report is
/// repeatable to the digit.
///
/// # Errors
/// A series is missing or lacks rows. There is no report of some of them: the figures
/// are compared over all.
pub fn recorded_walls(folder: &Path) -> Result<RecordedReport, RecordedError> {
    let all = Series::load_all(folder)?;
    let default = Photometry::VCNL4020;
    let calibrated = all.iter().find(|series| series.name == CALIBRATED_ON);
    let Some(calibrated) = calibrated else {
        return Err(RecordedError::Calibration("no such series".to_owned()));
    };
    let alpha = matched_alpha(calibrated, &default)?;
    let law = with_alpha(&default, alpha);
    let own = alpha_under(calibrated, &default, Physics::Patch);
    let wall_law = with_alpha(&default, own.unwrap_or(alpha));
    let mut walls = Vec::new();
    let both = [Physics::Matched, Physics::Patch];
    for series in &all {
        walls.extend(SeriesWalls::of(series, &law, &wall_law)?);
        for physics in both {
            let simulated = simulated(series, &law, physics);
            walls.extend(SeriesWalls::of(&simulated, &law, &law)?);
        }
    }
    let same = both.map(|physics| PhysicsError::of(&all, &default, physics, alpha, false));
    let own = own.map(|alpha| PhysicsError::of(&all, &default, Physics::Patch, alpha, true));
    Ok(RecordedReport {
        alpha_counts_m2: alpha,
        sources: all
            .iter()
            .map(|series| (series.name, series.about))
            .collect(),
        walls,
        physics: same.into_iter().chain(own).collect(),
    })
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
        let comparison = Comparison::of(all, &law, physics);
        let alone = |series: &Series| {
            let alone = Comparison::of(std::slice::from_ref(series), &law, physics);
            (series.name, alone.together())
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
