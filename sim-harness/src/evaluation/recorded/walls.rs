//! Maps of the stepped series against the walls that stood there.

use amiro_ipf::filter::Profile;
use amiro_ipf::model::Photometry;
use amiro_ipf::node::Config;
use serde::Serialize;

use super::RecordedSettings;
use super::ends::WallEnd;
use super::error::RecordedError;
use super::face::Face;
use super::series::{RECORDED, Series};
use crate::geometry::Vector;
use crate::mapping::{Mapper, Method, Occupancy, Setup};
use crate::pipeline;
use crate::rig::Rig;

/// Side of a map cell, metres.
const CELL_M: f64 = 0.010;
/// How far an occupied cell may be from a face for that place to count as found: as in
/// the scores of simulated drives, a cell and a half; and two cells.
const RECALL_M: [f64; 2] = [0.015, 0.020];
/// Distance from all objects beyond which an occupied cell is false, metres.
const FALSE_M: f64 = 0.020;

/// A series' map by one method, against its walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeriesWalls {
    /// The series: its file's name without the extension.
    pub series: String,
    /// Where the readings are from: `recorded`, or the physics that simulated them.
    pub readings: &'static str,
    /// The method's name.
    pub method: &'static str,
    /// Stations of the series.
    pub stations: usize,
    /// Steps of the filter.
    pub steps: u32,
    /// Occupied cells in all.
    pub occupied: usize,
    /// Occupied cells beside the wall that is nearest to them: on its side of the first
    /// station, between its ends.
    pub beside: usize,
    /// Mean distance of those from the wall's face, metres; above 0 is behind it.
    pub mean_m: Option<f64>,
    /// RMS of that distance, metres.
    pub rms_m: Option<f64>,
    /// Share of the faces' lengths with an occupied cell within 15 mm.
    pub recall_15: f64,
    /// The same within 20 mm.
    pub recall_20: f64,
    /// Occupied cells more than 20 mm from all objects.
    pub false_cells: usize,
    /// The walls' ends that count, each with the mapped one; empty for a method that fits
    /// no walls.
    pub ends: Vec<WallEnd>,
}

impl SeriesWalls {
    /// Whether the readings are those of the recording, not simulated ones.
    #[must_use]
    pub fn is_recorded(&self) -> bool {
        self.readings == RECORDED
    }

    /// RMS of the distances of the mapped ends from the true ones, along the walls, metres;
    /// `None` if no end was mapped.
    #[must_use]
    pub fn end_error_m(&self) -> Option<f64> {
        WallEnd::rms_m(&self.ends)
    }

    /// Maps a series by each method, under the given law; a method that fits signals under the
    /// law of extended surfaces, which has another gain.
    pub(super) fn of(
        series: &Series,
        law: &Photometry,
        wall_law: &Photometry,
        settings: &RecordedSettings,
    ) -> Result<Vec<Self>, RecordedError> {
        let scored = |method: &Method| {
            let config = Config {
                sensors: series.used,
                photometry: if method.fits_signals { *wall_law } else { *law },
                particles_per_sensor: settings.particles_per_sensor,
                ..Config::amiro(method.profile.unwrap_or(Profile::Paper))
            };
            let mut mapper = method.mapper(&Setup::new(&Rig::from(&config), CELL_M));
            let outcome = pipeline::run(
                |take| pipeline::records(method, &config, &series.inputs(), take),
                &mut mapper,
                &mut |_, _| {},
            )?;
            Ok(Self::scored(series, method, outcome.steps, &mapper))
        };
        settings.methods.iter().map(scored).collect()
    }

    fn scored(series: &Series, method: &Method, steps: u32, mapper: &dyn Mapper) -> Self {
        let map = mapper.map();
        let occupied: Vec<Vector> = map
            .cells_of(Occupancy::Occupied)
            .map(|cell| map.centre(cell))
            .map(|(x, y)| Vector::new(x, y))
            .collect();
        let behind = |place: &Vector| nearest(&series.faces, *place)?.behind_m(*place);
        let distances: Vec<f64> = occupied.iter().filter_map(behind).collect();
        let mean = |sum: f64| (!distances.is_empty()).then(|| sum / distances.len() as f64);
        let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
        let is_false = |place: &&Vector| {
            let outside = |shape: &crate::world::Shape| shape.distance_m(**place) > FALSE_M;
            series.shapes.iter().all(outside)
        };
        let [recall_15, recall_20] =
            RECALL_M.map(|limit_m| recall(&series.faces, &occupied, limit_m));
        Self {
            series: series.name.clone(),
            readings: series.readings,
            method: method.name,
            stations: series.stations.len(),
            steps,
            occupied: occupied.len(),
            beside: distances.len(),
            mean_m: mean(distances.iter().sum()),
            rms_m: mean(squares).map(f64::sqrt),
            recall_15,
            recall_20,
            false_cells: occupied.iter().filter(is_false).count(),
            ends: if mapper.walls().is_empty() {
                Vec::new()
            } else {
                WallEnd::of(series, mapper.walls())
            },
        }
    }
}

/// The face that is nearest to a place.
fn nearest(faces: &[Face], place: Vector) -> Option<&Face> {
    let distance = |face: &&Face| face.distance_m(place);
    faces
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Share of the faces' pieces with an occupied cell within the given distance.
fn recall(faces: &[Face], occupied: &[Vector], limit_m: f64) -> f64 {
    let pieces: Vec<Vector> = faces.iter().flat_map(Face::pieces).collect();
    let is_found = |piece: &&Vector| {
        let distances = occupied.iter().map(|place| (*place - **piece).norm());
        distances.fold(f64::INFINITY, f64::min) <= limit_m
    };
    pieces.iter().filter(is_found).count() as f64 / pieces.len().max(1) as f64
}
