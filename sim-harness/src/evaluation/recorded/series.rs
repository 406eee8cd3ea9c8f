//! A stepped series: its stations, and the world that it was recorded in.
//!
//! The robot is put down by hand at stations of equal distance along a straight line. Its
//! own odometry sees nothing of that and is not used, nor is its heading: row i of the
//! recording is the station at x = `first_station_m` + i `station_step_m`, y = 0, and
//! the robot looks along x.

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample, SensorMask};
use amiro_ipf::node::Input;

use super::error::RecordedError;
use super::face::Face;
use super::series_file::Setting;
use crate::log;
use crate::world::Shape;

/// Greatest number of stations of a series.
const MAX_STATIONS: usize = 10_000;
/// The speed of the paper's drives, which gives the stations stamps: they have no time of
/// their own.
const SPEED_M_PER_S: f64 = 0.08;

/// What readings are called that are those of the recording.
pub(super) const RECORDED: &str = "recorded";

/// A station: where the robot stood and what its sensors read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) pose: Pose,
    pub(super) samples: [Sample; SENSORS],
}

/// A stepped series with its world.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) truth: String,
    /// Where the readings are from.
    pub(super) readings: &'static str,
    /// The sensors that are used.
    pub(super) used: SensorMask,
    /// Time between stations, microseconds.
    period_us: u64,
    pub(super) stations: Vec<Station>,
    pub(super) faces: Vec<Face>,
    pub(super) shapes: Vec<Shape>,
}

impl Series {
    /// Reads the recording of a described series.
    ///
    /// # Errors
    /// [`RecordedError::Value`] at the recording's name if it cannot be read, if a row is
    /// refused, which would move all stations behind it, or for too many stations.
    pub(super) fn load(setting: &Setting) -> Result<Self, RecordedError> {
        let refused = |what: String| RecordedError::Value {
            at: setting.at.clone(),
            what,
        };
        let recording = log::read(&setting.path).map_err(|error| refused(error.to_string()))?;
        let rows: Vec<_> = recording
            .inputs
            .iter()
            .filter_map(|input| match input {
                Input::Proximity { samples, .. } => Some(*samples),
                _ => None,
            })
            .collect();
        let count = rows.len();
        if count == 0 || !recording.refusals.is_empty() {
            let refusals = recording.refusals.count();
            return Err(refused(format!(
                "{count} rows, {refusals} refused: a station that is left out would move all \
                 behind it"
            )));
        }
        if count > MAX_STATIONS {
            let what = format!("{count} stations, at most {MAX_STATIONS} are allowed");
            return Err(refused(what));
        }
        Ok(Self::of(setting, rows))
    }

    /// A series with the given readings, one station each.
    fn of(setting: &Setting, rows: impl IntoIterator<Item = [Sample; SENSORS]>) -> Self {
        let (first_m, step_m) = (setting.first_station_m, setting.station_step_m);
        let station = |(index, samples): (u16, _)| Station {
            pose: Pose::new(first_m as f32 + step_m as f32 * f32::from(index), 0.0, 0.0),
            samples,
        };
        Self {
            name: setting.name.clone(),
            truth: setting.truth.clone(),
            readings: RECORDED,
            used: setting.used,
            period_us: (1e6 * step_m / SPEED_M_PER_S).round() as u64,
            stations: (0..).zip(rows).map(station).collect(),
            faces: setting.faces.clone(),
            shapes: setting.shapes.clone(),
        }
    }

    /// The first series of the example with empty readings, for tests.
    #[cfg(test)]
    pub(super) fn blank() -> Self {
        let text = include_str!("../../../../scenarios/recorded_series.toml");
        let folder = std::path::Path::new("");
        let file = super::series_file::SeriesFile::parse("example", text, folder).unwrap();
        let nothing = std::iter::repeat_n([Sample::Counts(0); SENSORS], 19);
        Self::of(&file.settings[0], nothing)
    }

    /// A node's inputs: pose and readings of each station.
    pub(super) fn inputs(&self) -> Vec<Input> {
        (0_u64..)
            .zip(&self.stations)
            .flat_map(|(index, station)| {
                let stamp_us = index * self.period_us;
                let (pose, samples) = (station.pose, station.samples);
                [
                    Input::Odometry { stamp_us, pose },
                    Input::Proximity { stamp_us, samples },
                ]
            })
            .collect()
    }
}
