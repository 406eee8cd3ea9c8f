//! Maps of the stepped series against the walls that stood there.

use amiro_ipf::filter::Profile;
use amiro_ipf::model::Photometry;
use amiro_ipf::node::Config;
use serde::Serialize;

use super::RecordedError;
use super::series::{Face, SIDES, Series};
use crate::geometry::Vector;
use crate::mapping::{Map, Mapper, Method, Occupancy, Setup};
use crate::pipeline;
use crate::rig::Rig;

/// Side of a map cell, metres.
const CELL_M: f64 = 0.010;
/// How far an occupied cell may be from a face for that place to count as found: as in
/// the scores of simulated drives, a cell and a half.
const RECALL_M: f64 = 0.015;
/// How far outside of everything that stands there an occupied cell is false, metres.
const FALSE_M: f64 = 0.020;

/// The methods that are compared, in the order of the report.
const METHODS: [Method; 4] = [
    Method::PAPER,
    Method::PLUS,
    Method::ISM_TUNED,
    Method::WALL_MAP,
];

/// A series' map by one method, against its walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeriesWalls {
    /// The series: the file's name.
    pub series: &'static str,
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
    /// Occupied cells beside a wall: on its side of the robot, between its ends.
    pub beside: usize,
    /// Mean distance of those from the wall's face, metres; above 0 is behind it.
    pub mean_m: Option<f64>,
    /// RMS of that distance, metres.
    pub rms_m: Option<f64>,
    /// Share of the faces' lengths with an occupied cell within 15 mm.
    pub recall: f64,
    /// Occupied cells more than 20 mm outside of everything that stands there.
    pub false_cells: usize,
}

impl SeriesWalls {
    /// Maps a series by each method, under the given law; the map of walls under the law of
    /// extended surfaces, whose gain is another one.
    pub(super) fn of(
        series: &Series,
        law: &Photometry,
        wall_law: &Photometry,
    ) -> Result<Vec<Self>, RecordedError> {
        let scored = |method: &Method| {
            let is_of_walls = *method == Method::WALL_MAP;
            let config = Config {
                sensors: SIDES,
                photometry: if is_of_walls { *wall_law } else { *law },
                ..Config::amiro(method.profile.unwrap_or(Profile::Paper))
            };
            let mut mapper = method.mapper(&Setup::new(&Rig::from(&config), CELL_M));
            let outcome = pipeline::run(
                |take| pipeline::records(method, &config, &series.inputs(), take),
                &mut mapper,
                &mut |_, _| {},
            )?;
            Ok(Self::scored(series, method, outcome.steps, &mapper.map()))
        };
        METHODS.iter().map(scored).collect()
    }

    fn scored(series: &Series, method: &Method, steps: u32, map: &Map) -> Self {
        let occupied: Vec<Vector> = map
            .cells_of(Occupancy::Occupied)
            .map(|cell| map.centre(cell))
            .map(|(x, y)| Vector::new(x, y))
            .collect();
        let distances: Vec<f64> = series
            .faces
            .iter()
            .flat_map(|face| occupied.iter().filter_map(|place| face.behind_m(*place)))
            .collect();
        let mean = |sum: f64| (!distances.is_empty()).then(|| sum / distances.len() as f64);
        let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
        let is_false = |place: &&Vector| {
            let outside = |shape: &crate::world::Shape| shape.distance_m(**place) > FALSE_M;
            series.shapes.iter().all(outside)
        };
        Self {
            series: series.name,
            readings: series.readings,
            method: method.name,
            stations: series.stations.len(),
            steps,
            occupied: occupied.len(),
            beside: distances.len(),
            mean_m: mean(distances.iter().sum()),
            rms_m: mean(squares).map(f64::sqrt),
            recall: recall(&series.faces, &occupied),
            false_cells: occupied.iter().filter(is_false).count(),
        }
    }
}

impl Face {
    /// How far behind the face a place is, if it is between the ends and on the face's
    /// side of the robot; below 0 before it.
    fn behind_m(&self, place: Vector) -> Option<f64> {
        let is_beside = (self.near.x..=self.far.x).contains(&place.x);
        let side = 1.0_f64.copysign(self.near.y);
        (is_beside && side * place.y > 0.0).then_some(side * (place.y - self.near.y))
    }

    /// Middles of the pieces, a cell long, that the face is looked for in.
    fn pieces(&self) -> impl Iterator<Item = Vector> {
        let way = self.far - self.near;
        let count = (way.norm() / CELL_M).round().max(1.0) as u32;
        let near = self.near;
        (0..count).map(move |piece| near + way.scaled((f64::from(piece) + 0.5) / f64::from(count)))
    }
}

fn recall(faces: &[Face], occupied: &[Vector]) -> f64 {
    let pieces: Vec<Vector> = faces.iter().flat_map(Face::pieces).collect();
    let is_found = |piece: &&Vector| {
        let distances = occupied.iter().map(|place| (*place - **piece).norm());
        distances.fold(f64::INFINITY, f64::min) <= RECALL_M
    };
    pieces.iter().filter(is_found).count() as f64 / pieces.len().max(1) as f64
}
