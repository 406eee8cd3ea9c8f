//! Maps of the stepped series against the walls that stood there.

use amiro_ipf::filter::Profile;
use amiro_ipf::model::Photometry;
use amiro_ipf::node::{Config, Event};
use serde::Serialize;

use super::RecordedError;
use super::series::{Face, SIDES, Series};
use crate::mapping::{
    CountingMapper, InverseSensorMapper, InverseSensorParameters, Map, Mapper, Occupancy,
};
use crate::run;
use crate::world::Vector;

/// Side of a map cell, metres.
const CELL_M: f64 = 0.010;
/// How far an occupied cell may be from a face for that place to count as found: as in
/// the scores of simulated drives, a cell and a half.
const RECALL_M: f64 = 0.015;
/// How far outside of everything that stands there an occupied cell is false, metres.
const FALSE_M: f64 = 0.020;

/// What made a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The faithful filter.
    Paper,
    /// Ours.
    Plus,
    /// The inverse sensor model in its tuned form.
    Ism,
}

impl Method {
    /// All, in the order of reports.
    pub const ALL: [Self; 3] = [Self::Paper, Self::Plus, Self::Ism];
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Paper => "paper",
            Self::Plus => "plus",
            Self::Ism => "ISM",
        })
    }
}

/// A series' map by one method, against its walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeriesWalls {
    /// The series: the file's name.
    pub series: &'static str,
    /// Where the readings are from: `recorded`, or the physics that simulated them.
    pub readings: &'static str,
    /// The method.
    pub method: Method,
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
    /// Maps a series by each method, under the given law.
    pub(super) fn of(series: &Series, law: &Photometry) -> Result<Vec<Self>, RecordedError> {
        let map = |method: &Method| {
            let (map, steps) = method.map(series, law)?;
            Ok(Self::scored(series, *method, steps, &map))
        };
        Method::ALL.iter().map(map).collect()
    }

    fn scored(series: &Series, method: Method, steps: u32, map: &Map) -> Self {
        let occupied: Vec<Vector> = map
            .iter()
            .filter(|(_, p_occ)| Occupancy::of(**p_occ) == Occupancy::Occupied)
            .map(|(cell, _)| map.centre(cell))
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
            method,
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

impl Method {
    /// The map of a series, and the filter's steps.
    fn map(self, series: &Series, law: &Photometry) -> Result<(Map, u32), RecordedError> {
        let profile = match self {
            Self::Paper | Self::Ism => Profile::Paper,
            Self::Plus => Profile::Plus,
        };
        let mut config = Config {
            sensors: SIDES,
            photometry: *law,
            ..Config::amiro(profile)
        };
        if self == Self::Ism {
            // It takes the readings of the steps and needs no particles.
            config.particles_per_sensor = 1;
            let tuned = InverseSensorParameters::TUNED;
            let mut mapper = InverseSensorMapper::new(CELL_M, &config, tuned);
            return mapped(&mut mapper, &config, series);
        }
        mapped(&mut CountingMapper::new(CELL_M), &config, series)
    }
}

fn mapped(
    mapper: &mut impl Mapper,
    config: &Config,
    series: &Series,
) -> Result<(Map, u32), RecordedError> {
    let outcome = run(config, &series.inputs(), |event: &Event| mapper.take(event))?;
    Ok((mapper.map(), outcome.steps))
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
