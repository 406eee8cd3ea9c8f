//! Walls under all readings: what they return, and what the difference costs.

use std::collections::BTreeSet;

use super::WallMapParameters;
use super::readings::{Readings, SignalRow};
use crate::sensors::{EndGradient, WallLaw, WallSegment};

/// Added to the reach when the places that see a wall are listed, metres.
const SLACK_M: f64 = 0.05;

/// Walls, and the signals that they return at every reading.
#[derive(Clone, Debug)]
pub(super) struct WallScene<'r> {
    pub(super) readings: &'r Readings,
    pub(super) parameters: &'r WallMapParameters,
    /// The walls; `None` for one that was removed.
    walls: Vec<Option<WallSegment>>,
    /// The walls within reach of each station.
    in_reach: Vec<Vec<usize>>,
    /// The signal that is expected of each reading by the law.
    expected: Vec<f64>,
    /// ln of the gain of each mount relative to the law's.
    gains: Vec<f64>,
}

/// A change of a wall: its index, and what it becomes.
pub(super) type WallChange = (usize, Option<WallSegment>);

impl<'r> WallScene<'r> {
    pub(super) fn new(readings: &'r Readings, parameters: &'r WallMapParameters) -> Self {
        Self {
            readings,
            parameters,
            walls: Vec::new(),
            in_reach: vec![Vec::new(); readings.stations.len()],
            expected: vec![0.0; readings.rows.len()],
            gains: vec![0.0; readings.mounts()],
        }
    }

    /// The indices of the walls that are there.
    pub(super) fn indices(&self) -> Vec<usize> {
        let all = self.walls.iter().enumerate();
        all.filter_map(|(index, wall)| wall.is_some().then_some(index))
            .collect()
    }

    pub(super) fn wall(&self, index: usize) -> Option<WallSegment> {
        self.walls.get(index).copied().flatten()
    }

    /// The walls within reach of a station.
    pub(super) fn walls_at(&self, station: usize) -> impl Iterator<Item = (usize, WallSegment)> {
        let indices = self.in_reach.get(station).into_iter().flatten();
        indices.filter_map(|index| Some((*index, self.wall(*index)?)))
    }

    /// The index that the next new wall has.
    pub(super) fn next(&self) -> usize {
        let free = self.walls.iter().position(Option::is_none);
        free.unwrap_or(self.walls.len())
    }

    /// A reading and the signal that is expected of it, by the reading's index.
    pub(super) fn row(&self, index: usize) -> Option<(&SignalRow, f64)> {
        let row = self.readings.rows.get(index)?;
        let expected = self.expected.get(index)?;
        Some((row, self.gain(row.mount) * expected))
    }

    /// Gain of a mount relative to the law's.
    pub(super) fn gain(&self, mount: usize) -> f64 {
        libm::exp(self.gains.get(mount).copied().unwrap_or(0.0))
    }

    /// ln of the gain of each mount.
    pub(super) fn gains(&self) -> &[f64] {
        &self.gains
    }

    /// Changes the gains; by how much the cost rises.
    ///
    /// Cost: all readings, without the law.
    pub(super) fn change_gains(&mut self, gains: &[f64]) -> f64 {
        let all: Vec<usize> = (0..self.readings.stations.len()).collect();
        let before = self.cost(&all) + self.cost_of_gains();
        self.gains = gains.to_vec();
        self.cost(&all) + self.cost_of_gains() - before
    }

    /// Cost of all readings and of the priors of walls and gains.
    pub(super) fn total_cost(&self) -> f64 {
        let all: Vec<usize> = (0..self.readings.stations.len()).collect();
        let walls = self.walls.iter().flatten();
        let priors: f64 = walls.map(|wall| self.cost_of(self.prior(wall))).sum();
        self.cost(&all) + priors + self.cost_of_gains()
    }

    /// The readings that stand out of the noise, each with its cost.
    pub(super) fn lit_costs(&self) -> impl Iterator<Item = (&SignalRow, f64)> {
        let all = (0..self.readings.stations.len()).flat_map(|station| self.rows_of(station));
        all.filter(|(row, _)| row.is_lit())
            .map(|(row, expected)| (row, self.cost_at(row, expected)))
    }

    fn cost_of_gains(&self) -> f64 {
        let sigma = self.parameters.gain_sigma;
        if sigma <= 0.0 {
            return 0.0;
        }
        let squares = self
            .gains
            .iter()
            .map(|gain| (gain / sigma) * (gain / sigma));
        squares.sum()
    }

    /// Cost of one residual.
    pub(super) fn cost_of(&self, residual: f64) -> f64 {
        let huber = self.parameters.huber;
        let size = residual.abs();
        if size <= huber {
            size * size
        } else {
            huber * (2.0 * size - huber)
        }
    }

    /// Cost of a reading for which a signal is expected.
    pub(super) fn cost_at(&self, row: &SignalRow, expected: f64) -> f64 {
        self.cost_of(row.residual(expected, self.parameters.floor_counts))
    }

    /// Residual of a wall's prior.
    pub(super) fn prior(&self, wall: &WallSegment) -> f64 {
        (wall.length_m() - self.parameters.length_m) / self.parameters.length_sigma_m
    }

    /// The stations within reach of walls, in the order of the drive.
    pub(super) fn stations_near(&self, walls: impl Iterator<Item = WallSegment>) -> Vec<usize> {
        let reach_m = self.parameters.reach_m + SLACK_M;
        let all: BTreeSet<usize> = walls
            .flat_map(|wall| self.readings.near(&wall, reach_m))
            .collect();
        all.into_iter().collect()
    }

    /// Changes walls; by how much the cost rises.
    ///
    /// Cost: all readings within reach of the walls, before and after, under the law.
    pub(super) fn change(&mut self, changes: &[WallChange]) -> f64 {
        let old = changes.iter().filter_map(|(index, _)| self.wall(*index));
        let new = changes.iter().filter_map(|(_, wall)| *wall);
        let both: Vec<WallSegment> = old.chain(new).collect();
        let stations = self.stations_near(both.into_iter());
        let before = self.cost(&stations);
        let mut prior = 0.0;
        for (index, wall) in changes {
            if let Some(old) = self.wall(*index) {
                prior -= self.cost_of(self.prior(&old));
            }
            self.put(*index, *wall);
            if let Some(new) = wall {
                prior += self.cost_of(self.prior(new));
            }
        }
        for station in &stations {
            self.expect(*station);
        }
        self.cost(&stations) - before + prior
    }

    fn put(&mut self, index: usize, wall: Option<WallSegment>) {
        let reach_m = self.parameters.reach_m;
        if let Some(old) = self.wall(index) {
            for station in self.readings.near(&old, reach_m) {
                if let Some(list) = self.in_reach.get_mut(station) {
                    list.retain(|listed| *listed != index);
                }
            }
        }
        if let Some(new) = wall {
            for station in self.readings.near(&new, reach_m) {
                if let Some(list) = self.in_reach.get_mut(station) {
                    list.push(index);
                    list.sort_unstable();
                }
            }
        }
        if index >= self.walls.len() {
            self.walls.resize(index + 1, None);
        }
        if let Some(slot) = self.walls.get_mut(index) {
            *slot = wall;
        }
    }

    /// Cost of the readings of stations.
    pub(super) fn cost(&self, stations: &[usize]) -> f64 {
        let mut sum = 0.0;
        for station in stations {
            for (row, expected) in self.rows_of(*station) {
                sum += self.cost_at(row, expected);
            }
        }
        sum
    }

    /// The readings of a station with what is expected of them.
    pub(super) fn rows_of(&self, station: usize) -> impl Iterator<Item = (&SignalRow, f64)> {
        let rows = self.readings.rows_of(station);
        let range = self.readings.stations.get(station).map(|s| s.rows.clone());
        let expected = range.and_then(|range| self.expected.get(range));
        let both = rows.iter().zip(expected.unwrap_or_default());
        both.map(|(row, expected)| (row, self.gain(row.mount) * expected))
    }

    /// Computes what is expected of the readings of a station.
    fn expect(&mut self, station: usize) {
        let walls: Vec<WallSegment> = self.walls_at(station).map(|(_, wall)| wall).collect();
        let Some(range) = self.readings.stations.get(station).map(|s| s.rows.clone()) else {
            return;
        };
        let rows = self.readings.rows_of(station);
        let Some(expected) = self.expected.get_mut(range) else {
            return;
        };
        let mut views = Vec::with_capacity(walls.len());
        for (row, expected) in rows.iter().zip(expected) {
            views.clear();
            views.extend(walls.iter().map(|w| w.viewed_from(&row.world_from_sensor)));
            let law = self.readings.law(row.mount);
            *expected = law.map_or(0.0, |law| law.signal(&views));
        }
    }

    /// The expected signal of a reading and its derivatives by the ends of the walls within
    /// reach, in the world, in the order of [`walls_at`](Self::walls_at).
    pub(super) fn linearised(
        &self,
        law: &WallLaw,
        row: &SignalRow,
        walls: &[WallSegment],
        gradients: &mut Vec<EndGradient>,
    ) -> f64 {
        let views: Vec<WallSegment> = walls
            .iter()
            .map(|wall| wall.viewed_from(&row.world_from_sensor))
            .collect();
        gradients.clear();
        gradients.resize(walls.len(), [0.0; 4]);
        let signal = law.linearised(&views, gradients);
        let gain = self.gain(row.mount);
        let turn = row.world_from_sensor.heading;
        for gradient in gradients {
            let [from_x, from_y, to_x, to_y] = *gradient;
            let from = crate::geometry::Vector::new(from_x, from_y).turned(turn);
            let to = crate::geometry::Vector::new(to_x, to_y).turned(turn);
            *gradient = [from.x, from.y, to.x, to.y].map(|slope| gain * slope);
        }
        gain * signal
    }
}
