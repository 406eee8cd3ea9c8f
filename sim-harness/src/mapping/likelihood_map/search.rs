//! The greedy search of the map of greatest likelihood.

use super::forward_model::{ForwardModel, Measured, Obstacle, bearings, union_rad};
use super::{LikelihoodParameters, Sweep};
use crate::mapping::cone_readings::{CellIndex, ConeReadings};

/// Least gain of a flip: smaller ones are rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Distances from the echo that differ by less than one over this are equal, metres.
const PER_METRE: f64 = 1e9;

/// A map of occupied cells, and the likelihood of the readings in it.
///
/// Memory: 28 bytes per (cell, reading) pair besides those of the readings.
pub(super) struct Search<'a> {
    readings: &'a ConeReadings,
    is_used: &'a [bool],
    index: CellIndex,
    model: ForwardModel,
    hit: [f64; 2],
    gap_m: f64,
    /// The bearings of the cell of each pair.
    bearings: Vec<[f64; 2]>,
    is_occupied: Vec<bool>,
    /// The pairs of occupied cells, from near to far, in each reading's share of the pairs.
    occupied: Vec<u32>,
    occupied_counts: Vec<u32>,
    log_likelihoods: Vec<f64>,
}

impl<'a> Search<'a> {
    /// The empty map, in which the search starts.
    pub(super) fn new(
        readings: &'a ConeReadings,
        is_used: &'a [bool],
        parameters: &LikelihoodParameters,
    ) -> Self {
        let cell_m = readings.lattice().cell_m();
        let mut all_bearings = vec![[0.0; 2]; readings.pairs()];
        for reading in readings.readings() {
            for pair in reading.pairs() {
                let bearing_rad = readings.bearing_rad(reading, pair);
                let range_m = readings.range_m(pair);
                let half_angle_rad = reading.cone.half_angle_rad;
                all_bearings[pair] = bearings(bearing_rad, range_m, cell_m, half_angle_rad);
            }
        }
        let mut search = Self {
            readings,
            is_used,
            index: readings.index(|number| is_used[number]),
            model: ForwardModel::new(parameters, cell_m),
            hit: parameters.hit,
            gap_m: parameters.gap_cells * cell_m,
            bearings: all_bearings,
            is_occupied: vec![false; readings.cells().len()],
            occupied: vec![0; readings.pairs()],
            occupied_counts: vec![0; readings.readings().len()],
            log_likelihoods: Vec::new(),
        };
        let mut intervals = Vec::new();
        search.log_likelihoods = (0..is_used.len())
            .map(|reading| search.evaluate(reading, &mut intervals))
            .collect();
        search
    }

    /// The logarithm of the likelihood of all readings, l(M).
    pub(super) fn log_likelihood(&self) -> f64 {
        let used = self.log_likelihoods.iter().zip(self.is_used);
        used.filter_map(|(value, is_used)| is_used.then_some(*value))
            .sum()
    }

    /// Of each cell in the cone of a used reading, whether it is occupied.
    pub(super) fn cells(&self) -> Vec<Option<bool>> {
        let cells = self.is_occupied.iter().enumerate();
        cells
            .map(|(cell, is_occupied)| {
                let is_known = self.index.of_cell(cell).next().is_some();
                is_known.then_some(*is_occupied)
            })
            .collect()
    }

    /// Tries each cell once: from reading to reading by time, within one from its range
    /// both ways. A flip stays if the readings become more likely by it.
    pub(super) fn sweep(&mut self, by_time: &[usize], progress: &mut dyn FnMut(usize)) -> Sweep {
        let mut is_tried = vec![false; self.is_occupied.len()];
        let mut trial = FlipTrial::default();
        let mut flips = 0;
        for (done, reading) in by_time.iter().enumerate() {
            progress(done);
            if !self.is_used[*reading] {
                continue;
            }
            for cell in self.cells_by_misfit(*reading) {
                if !core::mem::replace(&mut is_tried[cell], true) && self.try_flip(cell, &mut trial)
                {
                    flips += 1;
                }
            }
        }
        Sweep {
            flips,
            log_likelihood: self.log_likelihood(),
        }
    }

    /// The cells of a reading by their distance from its range, equally distant ones by row
    /// and column.
    fn cells_by_misfit(&self, number: usize) -> Vec<usize> {
        let reading = &self.readings.readings()[number];
        let mut cells: Vec<_> = reading
            .pairs()
            .map(|pair| {
                let distance_m = (self.readings.range_m(pair) - reading.range_m).abs();
                let cell = self.readings.cell(pair);
                // Below 1e14: the cone has been walked.
                let rank = (PER_METRE * distance_m).round() as u64;
                (rank, self.readings.cells()[cell], cell)
            })
            .collect();
        cells.sort_unstable();
        cells.into_iter().map(|(_, _, cell)| cell).collect()
    }

    /// Flips a cell if the readings become more likely by it.
    pub(super) fn try_flip(&mut self, cell: usize, trial: &mut FlipTrial) -> bool {
        trial.flipped.clear();
        self.flip(cell);
        let (mut before, mut after) = (0.0, 0.0);
        for (reading, _) in self.index.of_cell(cell) {
            let flipped = self.evaluate(reading, &mut trial.intervals);
            before += self.log_likelihoods[reading];
            after += flipped;
            trial.flipped.push((reading, flipped));
        }
        let is_better = after > before + LEAST_GAIN;
        if is_better {
            for (reading, flipped) in &trial.flipped {
                self.log_likelihoods[*reading] = *flipped;
            }
        } else {
            self.flip(cell);
        }
        is_better
    }

    /// Marks a free cell as occupied, whatever the readings say.
    #[cfg(test)]
    pub(super) fn set_occupied(&mut self, cell: usize) {
        self.flip(cell);
        let mut intervals = Vec::new();
        let readings: Vec<usize> = self.index.of_cell(cell).map(|(it, _)| it).collect();
        for reading in readings {
            self.log_likelihoods[reading] = self.evaluate(reading, &mut intervals);
        }
    }

    /// Flips a cell in the map and in the lists of the readings.
    fn flip(&mut self, cell: usize) {
        let is_occupied = !self.is_occupied[cell];
        self.is_occupied[cell] = is_occupied;
        for (reading, pair) in self.index.of_cell(cell) {
            let first = self.readings.readings()[reading].pairs().start;
            let count = self.occupied_counts[reading] as usize;
            let listed = &self.occupied[first..first + count];
            // Pairs are numbered below MAX_PAIRS, and from near to far.
            let place = first + listed.partition_point(|other| (*other as usize) < pair);
            if is_occupied {
                self.occupied.copy_within(place..first + count, place + 1);
                self.occupied[place] = pair as u32;
                self.occupied_counts[reading] += 1;
            } else {
                self.occupied.copy_within(place + 1..first + count, place);
                self.occupied_counts[reading] -= 1;
            }
        }
    }

    /// The logarithm of a reading's likelihood in the map as it is.
    fn evaluate(&self, number: usize, intervals: &mut Vec<[f64; 2]>) -> f64 {
        let reading = &self.readings.readings()[number];
        let mut causes = self.model.causes(Measured {
            range_m: reading.range_m,
            limit_m: reading.cone.range_m[1],
            is_maximum: !reading.is_echo,
        });
        let whole_rad = 2.0 * reading.cone.half_angle_rad;
        let mut obstacle = |sum_m: f64, intervals: &mut Vec<[f64; 2]>| {
            let [least, most] = self.hit;
            let coverage = (union_rad(intervals) / whole_rad).min(1.0);
            let distance_m = sum_m / intervals.len() as f64;
            intervals.clear();
            causes.add(Obstacle {
                distance_m,
                hit: least + (most - least) * coverage,
            })
        };
        let first = reading.pairs().start;
        let count = self.occupied_counts[number] as usize;
        let mut sum_m = 0.0;
        intervals.clear();
        for pair in &self.occupied[first..first + count] {
            let pair = *pair as usize;
            let range_m = self.readings.range_m(pair);
            let mean_m = sum_m / intervals.len() as f64;
            // NaN, so false, of the first cell.
            if (range_m - mean_m).abs() >= self.gap_m
                && !obstacle(core::mem::take(&mut sum_m), intervals)
            {
                break;
            }
            sum_m += range_m;
            intervals.push(self.bearings[pair]);
        }
        if !intervals.is_empty() {
            obstacle(sum_m, intervals);
        }
        causes.log_likelihood()
    }
}

/// What a flip is tried with, kept for the next one.
#[derive(Default)]
pub(super) struct FlipTrial {
    /// The readings of the cell and their likelihoods behind the flip.
    flipped: Vec<(usize, f64)>,
    intervals: Vec<[f64; 2]>,
}
