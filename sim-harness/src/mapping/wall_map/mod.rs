//! The map of a drive as straight walls that are fitted to all of its readings at once.
//!
//! The signals of reflective infrared sensors are explained by segments with ends, under
//! the [law of walls](crate::sensors::WallLaw). A signal s of which s^ is expected has the
//! residual
//!
//! ```text
//! r     = (ln(s + s_0) - ln(s^ + s_0)) / sd
//! sd^2  = (sig / (s + s_0))^2 + rel^2
//! cost  = sum of Huber(r) over the readings + sum of ((length - l_0) / sig_l)^2
//! ```
//!
//! with the noise sig of a sample and the error rel of the law relative to the return, both
//! at one standard deviation. Readings that a recorder has clipped at its lowest count are
//! upper bounds: they cost only where more is expected. If a standard deviation of gains is
//! given, ln of each sensor's gain relative to the law is an unknown with the prior
//! N(0, gain_sigma^2). The distance of a wall and the gain of all sensors together are
//! hard to tell apart: on a drive along a single wall they are not.
//!
//! **Search.** At the lit readings candidates on a lattice, in eight directions and three
//! lengths, are ranked by the decrease of the cost that their return alone would bring.
//! The best six are fitted; the best of these becomes a wall if it lowers the cost by the
//! least gain. Then all walls nearby are fitted together, walls that the readings do not
//! need are dropped, and two that the readings do not tell from one are joined. The search
//! ends when no candidate gains enough. It is greedy: it can end in a local minimum, above
//! all where short faces stand in a row.
//!
//! **Map.** A piece of a wall is occupied if the readings would change without it: by
//! chi^2 above a bound, as if 20 mm of it were removed. A cell is free if a surface of
//! 20 mm at it, square to each sensor, would change the readings by chi^2 above a bound
//! and make the fit worse. All else is unknown: a map of walls knows less than a map of
//! ranges. Before [`finish`](crate::mapping::Mapper::finish) all is unknown.
//!
//! **Bounds.** At most 20 000 places are kept, and at most 8 in a square of 20 mm and an
//! eighth of a turn; scans beyond that are left out and counted. The search passes over
//! windows of 256 places, with at most 24 births each; at most 24 walls are fitted
//! together, the others are held, and no wall grows beyond 2 m: a fit looks at the places
//! about its walls. The work goes with the number of places that are kept.

mod births;
mod draw;
mod gain_statistics;
mod parameters;
mod readings;
mod refine;
mod ring_gains;
mod scene;
mod segments;
#[cfg(test)]
mod tests;
mod tidy;

use nalgebra::DMatrix;

use self::readings::Readings;
use self::refine::{NormalEquations, Unknowns};
use self::scene::WallScene;
use self::tidy::MOST_TOGETHER;
use super::{FinishProgress, Map, MappedWall, Mapper};
use crate::drive::Record;
use crate::lattice::Lattice;
use crate::rig::Rig;

pub use parameters::WallMapParameters;
pub use ring_gains::{RingGainFit, RingGains};
pub use segments::SegmentMapper;

/// The gain of a sensor that was fitted with the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorGain {
    /// Gain relative to that of the rig's law.
    pub ratio: f64,
    /// Standard deviation of its logarithm, with that of the walls in it.
    pub sigma: f64,
}

/// Maps straight walls by a fit to all signals of a drive.
///
/// Records other than scans with signals are passed over. The work is done by `finish`,
/// which does nothing if no scan was taken since its last call.
#[derive(Clone, Debug)]
pub struct WallMapper {
    parameters: WallMapParameters,
    readings: Readings,
    is_finished: bool,
    walls: Vec<MappedWall>,
    gains: Vec<SensorGain>,
    map: Map,
}

impl WallMapper {
    /// A mapper with square cells of the given size, metres, for the infrared sensors of a
    /// robot.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, rig: &Rig, parameters: WallMapParameters) -> Self {
        Self {
            parameters,
            readings: Readings::new(rig, parameters),
            is_finished: false,
            walls: Vec::new(),
            gains: Vec::new(),
            map: Map::unknown(lattice),
        }
    }

    /// The gain of each mount; empty before `finish` and where no gains are fitted.
    #[must_use]
    pub fn gains(&self) -> &[SensorGain] {
        &self.gains
    }

    /// Number of scans that were left out to bound the work.
    #[must_use]
    pub fn left_out(&self) -> u64 {
        self.readings.left_out()
    }
}

impl Mapper for WallMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record
            && self.readings.take(scan)
        {
            self.is_finished = false;
        }
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        if self.is_finished {
            return;
        }
        self.readings.mark_clipped();
        let mut scene = WallScene::new(&self.readings, &self.parameters);
        scene.give_births(progress);
        let fitted = if self.parameters.gain_sigma > 0.0 {
            Unknowns::EndsAndGains
        } else {
            Unknowns::Ends
        };
        scene.settle(fitted);
        if fitted == Unknowns::EndsAndGains {
            // With other gains other walls are missing.
            scene.give_births(progress);
            scene.settle(fitted);
        }
        self.map = scene.draw(self.map.lattice(), progress);
        self.walls = mapped_walls(&mut scene);
        self.gains = sensor_gains(&scene, fitted);
        self.is_finished = true;
    }

    fn map(&self) -> Map {
        self.map.clone()
    }

    fn is_online(&self) -> bool {
        false
    }

    /// The walls that were found; none before `finish`.
    fn walls(&self) -> &[MappedWall] {
        &self.walls
    }
}

fn mapped_walls(scene: &mut WallScene<'_>) -> Vec<MappedWall> {
    let indices = scene.indices();
    let mut walls = Vec::new();
    for index in indices {
        let Some(segment) = scene.wall(index) else {
            continue;
        };
        // The wall is the first of its neighbours.
        let normal = NormalEquations::of(scene, &scene.neighbours(index), Unknowns::Ends);
        walls.push(MappedWall {
            segment,
            covariance_m2: covariance(normal.information),
            gain: scene.gain_of(index),
        });
    }
    walls
}

/// The gains with their standard deviations, the first walls fitted with them.
fn sensor_gains(scene: &WallScene<'_>, fitted: Unknowns) -> Vec<SensorGain> {
    if fitted == Unknowns::Ends {
        return Vec::new();
    }
    let group: Vec<usize> = scene.indices().into_iter().take(MOST_TOGETHER).collect();
    let normal = NormalEquations::of(scene, &group, fitted);
    let inverse = normal.information.cholesky().map(|factor| factor.inverse());
    let gains = scene.gains().iter().zip(4 * group.len()..);
    gains
        .map(|(gain, place)| SensorGain {
            ratio: libm::exp(*gain),
            sigma: inverse
                .as_ref()
                .map_or(f64::INFINITY, |inverse| inverse[(place, place)].sqrt()),
        })
        .collect()
}

/// The covariance of the first four unknowns.
fn covariance(information: DMatrix<f64>) -> [[f64; 4]; 4] {
    let mut covariance = [[f64::INFINITY; 4]; 4];
    if let Some(inverse) = information.cholesky().map(|factor| factor.inverse()) {
        for (line, row) in covariance.iter_mut().enumerate() {
            for (column, value) in row.iter_mut().enumerate() {
                *value = inverse[(line, column)];
            }
        }
    }
    covariance
}
