//! Finds walls where the readings miss return.

use std::collections::BTreeSet;
use std::ops::Range;

use super::WallMapParameters;
use super::readings::SignalRow;
use super::refine::Unknowns;
use super::scene::WallScene;
use crate::drive::Keyframes;
use crate::geometry::{Turn, Vector};
use crate::mapping::FinishProgress;
use crate::sensors::WallSegment;

/// Distances between the places whose readings rank candidates.
const RANKED_EVERY_M: f64 = 0.025;
const RANKED_EVERY_RAD: f64 = 0.26;

/// Farthest from a lit sensor that a wall is looked for, metres.
const LOOK_M: f64 = 0.25;

/// Least signal of a candidate that its rank considers, counts.
const LEAST_SIGNAL: f64 = 0.3;

/// Most walls that are born in one window.
const MOST_BIRTHS: usize = 24;

/// Batches of candidates that are fitted before the search ends.
const BATCHES: usize = 3;

/// Steps of the fit of a candidate, and of the joint fit after a birth.
const CANDIDATE_ITERATIONS: usize = 6;
const JOINT_ITERATIONS: usize = 8;

/// Places of a drive in one window of the search.
const WINDOW: usize = 256;

/// A wall that may be there, and its return to some of the readings without any other.
#[derive(Clone, Debug)]
struct Candidate {
    wall: WallSegment,
    signals: Vec<(usize, f64)>,
}

impl WallScene<'_> {
    /// Adds walls, window by window.
    pub(super) fn give_births(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        let places = self.readings.stations.len();
        let mut searched = |done| {
            progress(FinishProgress {
                stage: "places searched",
                done,
                of: places,
            });
        };
        for first in (0..places).step_by(WINDOW) {
            self.give_birth(first..(first + WINDOW).min(places), &mut searched);
        }
        searched(places);
    }

    /// Adds walls until no candidate lowers the cost by the least gain: those that explain
    /// what is missing at the stations of a window.
    ///
    /// Bounded: at most 24 births, each of at most three times `candidates` fits.
    fn give_birth(&mut self, window: Range<usize>, searched: &mut dyn FnMut(usize)) {
        searched(window.start);
        let candidates = self.dictionary(window.clone());
        for birth in 0..MOST_BIRTHS {
            searched(window.start + birth * window.len() / MOST_BIRTHS);
            let Some(wall) = self.best(&candidates) else {
                return;
            };
            let index = self.next();
            self.change(&[(index, Some(wall))]);
            let group = self.neighbours(index);
            self.refine(&group, JOINT_ITERATIONS, Unknowns::Ends);
            self.tidy(&group);
        }
    }

    /// The fitted candidate that lowers the cost most, if it does so by the least gain.
    fn best(&mut self, candidates: &[Candidate]) -> Option<WallSegment> {
        let mut ranked: Vec<(f64, &Candidate)> = candidates
            .iter()
            .map(|candidate| (self.promise(candidate), candidate))
            .filter(|(gain, _)| *gain > 0.0)
            .collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        for batch in ranked
            .chunks(self.parameters.candidates.max(1))
            .take(BATCHES)
        {
            let fitted = batch
                .iter()
                .map(|(_, candidate)| self.fitted(candidate.wall));
            let best = fitted
                .flatten()
                .max_by(|(a, _), (b, _)| a.total_cmp(b))
                .filter(|(gain, _)| *gain >= self.parameters.least_gain);
            if let Some((_, wall)) = best {
                return Some(wall);
            }
        }
        None
    }

    /// A wall after a fit of its ends alone, with the decrease of the cost; the walls stay
    /// as they are.
    fn fitted(&mut self, wall: WallSegment) -> Option<(f64, WallSegment)> {
        let index = self.next();
        self.change(&[(index, Some(wall))]);
        self.refine(&[index], CANDIDATE_ITERATIONS, Unknowns::Ends);
        let fitted = self.wall(index).and_then(|wall| self.clear(&wall));
        self.change(&[(index, fitted)]);
        let gain = self.change(&[(index, None)]);
        fitted.map(|wall| (gain, wall))
    }

    /// By how much a candidate lowers the cost of the readings that rank it: its return is
    /// added to what is expected there.
    fn promise(&self, candidate: &Candidate) -> f64 {
        let each = candidate.signals.iter().filter_map(|(row, signal)| {
            let (row, expected) = self.row(*row)?;
            let with = expected + self.gain(row.mount) * signal;
            Some(self.cost_at(row, expected) - self.cost_at(row, with))
        });
        each.sum()
    }

    /// The candidates about the lit readings of a window that lower the cost.
    fn dictionary(&self, window: Range<usize>) -> Vec<Candidate> {
        let ranking = self.ranking();
        let lattice_m = self.parameters.lattice_m;
        let mut candidates = Vec::new();
        for (column, line) in self.places(&ranking, window) {
            let middle = Vector::new(column as f64 * lattice_m, line as f64 * lattice_m);
            let point = WallSegment::new(middle, middle);
            let longest = self.parameters.lengths_m.into_iter().fold(0.0, f64::max);
            let mut near = self
                .readings
                .near(&point, self.parameters.reach_m + 0.5 * longest);
            near.retain(|station| ranking.contains(station));
            for wall in candidate_walls(self.parameters, middle) {
                if !self
                    .readings
                    .near(&wall, self.parameters.clearance_m)
                    .is_empty()
                {
                    continue;
                }
                let candidate = Candidate {
                    wall,
                    signals: self.signals(&wall, &near),
                };
                if self.promise(&candidate) > 0.0 {
                    candidates.push(candidate);
                }
            }
        }
        candidates
    }

    /// The stations whose readings rank candidates: some of all.
    fn ranking(&self) -> BTreeSet<usize> {
        let mut keyframes = Keyframes::new(RANKED_EVERY_M, RANKED_EVERY_RAD);
        let stations = self.readings.stations.iter().enumerate();
        stations
            .filter(|(_, station)| keyframes.take(&station.world_from_body))
            .map(|(index, _)| index)
            .collect()
    }

    /// The places of the search lattice in the lobes of lit sensors.
    fn places(&self, ranking: &BTreeSet<usize>, window: Range<usize>) -> BTreeSet<(i64, i64)> {
        let lattice_m = self.parameters.lattice_m;
        let mut places = BTreeSet::new();
        let rows = ranking
            .range(window)
            .flat_map(|station| self.readings.rows_of(*station));
        for row in rows.filter(|row| row.is_lit()) {
            let Some(law) = self.readings.law(row.mount) else {
                continue;
            };
            let sensor = row.world_from_sensor.position;
            let index = |metres: f64| (metres / lattice_m).round() as i64;
            for column in index(sensor.x - LOOK_M)..=index(sensor.x + LOOK_M) {
                for line in index(sensor.y - LOOK_M)..=index(sensor.y + LOOK_M) {
                    let place = Vector::new(column as f64 * lattice_m, line as f64 * lattice_m);
                    let seen = row.world_from_sensor.view(place);
                    let bearing_rad = libm::atan2(seen.y, seen.x);
                    if bearing_rad.abs() <= law.edge_rad() && seen.norm() <= LOOK_M {
                        places.insert((column, line));
                    }
                }
            }
        }
        places
    }

    /// The return of a wall alone to the readings of stations.
    fn signals(&self, wall: &WallSegment, stations: &[usize]) -> Vec<(usize, f64)> {
        let rows = stations.iter().filter_map(|station| {
            let range = self.readings.stations.get(*station)?.rows.clone();
            Some(range.zip(self.readings.rows_of(*station)))
        });
        let signal = |row: &SignalRow| {
            let law = self.readings.law(row.mount)?;
            let signal = law.signal(&[wall.viewed_from(&row.world_from_sensor)]);
            (signal > LEAST_SIGNAL).then_some(signal)
        };
        rows.flatten()
            .filter_map(|(index, row)| Some((index, signal(row)?)))
            .collect()
    }
}

/// The walls that are looked for about a place.
fn candidate_walls(
    parameters: &WallMapParameters,
    middle: Vector,
) -> impl Iterator<Item = WallSegment> {
    let directions = parameters.directions;
    let lengths_m = parameters.lengths_m;
    (0..directions).flat_map(move |direction| {
        let share = f64::from(direction) / f64::from(directions);
        let along = Turn::by_radians_f64(core::f64::consts::PI * share).direction();
        lengths_m.into_iter().map(move |length_m| {
            let half = along.scaled(0.5 * length_m);
            WallSegment::new(middle - half, middle + half)
        })
    })
}
