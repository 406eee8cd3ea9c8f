//! The readings of cones with their cells, for methods that need all readings at once.
//!
//! A batch method asks two questions: which cells does a reading look at, and which readings
//! look at a cell. [`ConeReadings`] answers the first, a [`CellIndex`] over it the second.

use super::{Belief, Grid, MAX_CELLS, Map, mount_returns};
use crate::drive::{RangeScan, Return};
use crate::geometry::{Pose2, Vector};
use crate::lattice::{Cell, Lattice};
use crate::rig::Rig;
use crate::sensors::{Cone, RangeSensor, View};

/// Most (cell, reading) pairs in store; a reading beyond it is refused and counted.
///
/// 12 bytes each, 8 more while a [`CellIndex`] exists: 160 MiB. A drive of 183 keyframes with
/// eight sonars of 25 degrees up to 5 m has 170 thousand on cells of 0.1 m.
const MAX_PAIRS: usize = 1 << 23;

/// Most readings in store, some 150 bytes each; one beyond it is refused and counted.
const MAX_READINGS: usize = 1 << 20;

/// The number of a cell that no reading in store looks at.
const NO_CELL: u32 = u32::MAX;

/// One reading of a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConeReading {
    /// When, microseconds.
    pub(super) stamp_us: u64,
    /// Number of its scan among all scans, and of the return within the scan.
    pub(super) source: [usize; 2],
    /// The measured range; the limit of a reading without an echo, metres (z).
    pub(super) range_m: f64,
    /// Whether there was an echo.
    pub(super) is_echo: bool,
    /// The sensor (H, z_max).
    pub(super) cone: Cone,
    /// The sensor's pose.
    pub(super) world_from_sensor: Pose2,
    /// Its first pair, the first that is not before the echo, the first behind it, the end.
    pairs: [u32; 4],
}

impl ConeReading {
    /// Its pairs, from near to far.
    pub(super) fn pairs(&self) -> core::ops::Range<usize> {
        let [first, _, _, end] = self.pairs;
        first as usize..end as usize
    }

    /// The pairs of cells before the range (E).
    pub(super) fn before(&self) -> core::ops::Range<usize> {
        let [first, arc, _, _] = self.pairs;
        first as usize..arc as usize
    }

    /// The pairs of cells at the echo (O); none without an echo.
    pub(super) fn at_echo(&self) -> core::ops::Range<usize> {
        let [_, arc, behind, _] = self.pairs;
        let end = if self.is_echo { behind } else { arc };
        arc as usize..end as usize
    }
}

/// Which readings are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReadingSelection {
    /// Least half width of the band in which an echo lies, metres (beta).
    pub(super) tolerance_m: f64,
    /// How far behind the range the cells of a reading go, metres; at least to the end of
    /// the band.
    pub(super) reach_m: f64,
    /// Whether readings without an echo are stored, with the limit as their range.
    pub(super) takes_no_echo: bool,
}

/// Readings of cones, their cells sorted by distance.
///
/// Infrared sensors are read as their cone (see [`Sensor::cone`](crate::sensors::Sensor::cone)),
/// scanners are passed over. Refused and counted are readings that are no numbers, whose
/// cells have no index, whose cone has more than [`MAX_CELLS`] cells around it, or that
/// exceed the limits of the store.
#[derive(Clone, Debug)]
pub(super) struct ConeReadings {
    rig: Rig,
    selection: ReadingSelection,
    max_pairs: usize,
    numbers: Grid<u32>,
    cells: Vec<Cell>,
    readings: Vec<ConeReading>,
    cell_of_pair: Vec<u32>,
    range_of_pair: Vec<f64>,
    scans: usize,
    refused: u64,
}

impl ConeReadings {
    /// An empty store for the sensors of a rig.
    pub(super) fn new(lattice: Lattice, rig: &Rig, selection: ReadingSelection) -> Self {
        Self {
            rig: rig.clone(),
            selection,
            max_pairs: MAX_PAIRS,
            numbers: Grid::new(lattice, NO_CELL),
            cells: Vec::new(),
            readings: Vec::new(),
            cell_of_pair: Vec::new(),
            range_of_pair: Vec::new(),
            scans: 0,
            refused: 0,
        }
    }

    /// Adds the readings of a scan.
    pub(super) fn add(&mut self, scan: &RangeScan) {
        let mut found = Vec::new();
        let mut number = 0;
        for mounted in mount_returns(&self.rig, scan) {
            let cone = mounted.mount.sensor.cone();
            for measured in mounted.recorded() {
                found.extend(cone.map(|cone| (number, mounted.world_from_sensor, cone, measured)));
                number += 1;
            }
        }
        for (number, world_from_sensor, cone, measured) in found {
            let (range_m, sigma_m, is_echo) = match measured {
                Return::Echo { range_m, sigma_m } => (range_m, sigma_m, true),
                Return::NoEcho { limit_m, sigma_m } if self.selection.takes_no_echo => {
                    (limit_m, sigma_m, false)
                }
                Return::NoEcho { .. } | Return::TooClose | Return::Invalid => continue,
            };
            let reading = ConeReading {
                stamp_us: scan.stamp_us,
                source: [self.scans, number],
                range_m,
                is_echo,
                cone,
                world_from_sensor,
                pairs: [0; 4],
            };
            if self.store(reading, sigma_m).is_none() {
                self.refused += 1;
            }
        }
        self.scans += 1;
    }

    /// Stores a reading with its cells; `None` if it is refused.
    fn store(&mut self, mut reading: ConeReading, sigma_m: f64) -> Option<()> {
        let tolerance_m = self.selection.tolerance_m.max(sigma_m);
        let reach_m = self.selection.reach_m.max(tolerance_m);
        let first = self.cell_of_pair.len();
        let room = self.max_pairs.saturating_sub(first);
        if self.readings.len() == MAX_READINGS || !self.fits(&reading, reach_m, room) {
            return None;
        }
        let view = View {
            index: 0,
            measured: Return::Echo {
                range_m: reading.range_m,
                sigma_m,
            },
            world_from_sensor: reading.world_from_sensor,
            tolerance_m: reach_m,
            lattice: self.lattice(),
        };
        let mut seen_cells = Vec::new();
        let all_have_an_index = reading.cone.footprint(&view, &mut |seen| {
            seen_cells.push((seen.range_m, seen.cell));
        });
        if !all_have_an_index || seen_cells.len() > room {
            return None;
        }
        seen_cells.sort_unstable_by(|(a_m, a), (b_m, b)| a_m.total_cmp(b_m).then(a.cmp(b)));
        for (range_m, cell) in &seen_cells {
            let Some(number) = self.number(*cell) else {
                self.cell_of_pair.truncate(first);
                self.range_of_pair.truncate(first);
                return None;
            };
            self.cell_of_pair.push(number);
            self.range_of_pair.push(*range_m);
        }
        let near_m = reading.range_m - tolerance_m;
        let far_m = reading.range_m + tolerance_m;
        let before = seen_cells.partition_point(|(range_m, _)| *range_m < near_m);
        let within = seen_cells.partition_point(|(range_m, _)| *range_m <= far_m);
        // At most MAX_PAIRS.
        reading.pairs = [0, before, within, seen_cells.len()].map(|pair| (first + pair) as u32);
        self.readings.push(reading);
        Some(())
    }

    /// Whether a reading is one of numbers, and its cells few enough.
    fn fits(&self, reading: &ConeReading, reach_m: f64, room: usize) -> bool {
        let reach_cells = (reading.range_m + reach_m) / self.lattice().cell_m();
        let cone_cells = reading.cone.half_angle_rad * reach_cells * reach_cells;
        self.is_walkable(reading.range_m + reach_m)
            && reading.range_m > 0.0
            && cone_cells <= room as f64
            && reading.world_from_sensor.is_finite()
    }

    /// Whether the cells around a sensor up to a range are at most [`MAX_CELLS`]; false for
    /// NaN.
    pub(super) fn is_walkable(&self, range_m: f64) -> bool {
        let reach_cells = range_m / self.lattice().cell_m();
        (2.0 * reach_cells + 1.0).powi(2) <= MAX_CELLS as f64
    }

    /// The number of a cell, a new one for a cell that no reading looked at before; `None` if
    /// the grid would become too large.
    fn number(&mut self, cell: Cell) -> Option<u32> {
        let held = self.numbers.reach(cell)?;
        if *held == NO_CELL {
            // At most MAX_CELLS.
            *held = self.cells.len() as u32;
            self.cells.push(cell);
        }
        Some(*held)
    }

    pub(super) fn lattice(&self) -> Lattice {
        self.numbers.lattice()
    }

    /// All readings, in the order in which they came.
    pub(super) fn readings(&self) -> &[ConeReading] {
        &self.readings
    }

    /// The numbers of the readings by stamp, those of one stamp as they came.
    pub(super) fn by_time(&self) -> Vec<usize> {
        let mut numbers: Vec<usize> = (0..self.readings.len()).collect();
        numbers.sort_by_key(|number| self.readings[*number].stamp_us);
        numbers
    }

    /// All cells that readings look at, by number.
    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Number of (cell, reading) pairs.
    pub(super) fn pairs(&self) -> usize {
        self.cell_of_pair.len()
    }

    /// The number of the cell of a pair.
    pub(super) fn cell(&self, pair: usize) -> usize {
        self.cell_of_pair[pair] as usize
    }

    /// Distance of the cell's centre from the sensor, metres (r).
    pub(super) fn range_m(&self, pair: usize) -> f64 {
        self.range_of_pair[pair]
    }

    /// Bearing of the cell's centre off the axis, radians (theta).
    pub(super) fn bearing_rad(&self, reading: &ConeReading, pair: usize) -> f64 {
        let (x, y) = self.lattice().centre(self.cells[self.cell(pair)]);
        let seen = reading.world_from_sensor.view(Vector::new(x, y));
        libm::atan2(seen.y, seen.x)
    }

    /// An unknown map that counts the refused readings.
    pub(super) fn blank_map(&self) -> Map {
        let mut map = Map::unknown(self.lattice());
        (0..self.refused).for_each(|_| map.refuse());
        map
    }

    /// The map of cells with a probability each, by number; that counts the refused readings.
    pub(super) fn map(&self, p_occ: &[Option<f32>]) -> Map {
        let mut map = self.blank_map();
        for (cell, p_occ) in self.cells.iter().zip(p_occ) {
            let (Some(p_occ), Some(belief)) = (p_occ, map.reach(*cell)) else {
                continue;
            };
            *belief = Belief::of_probability(*p_occ);
        }
        map
    }

    /// Number of readings that were refused.
    pub(super) fn refused(&self) -> u64 {
        self.refused
    }

    /// Which of the readings that `is_used` look at each cell.
    pub(super) fn index(&self, is_used: impl Fn(usize) -> bool) -> CellIndex {
        let mut ends = vec![0_u32; self.cells.len() + 1];
        let used = || (0..self.readings.len()).filter(|number| is_used(*number));
        for reading in used() {
            for pair in self.readings[reading].pairs() {
                ends[self.cell(pair) + 1] += 1;
            }
        }
        for cell in 1..ends.len() {
            ends[cell] += ends[cell - 1];
        }
        let count = ends.last().map_or(0, |end| *end as usize);
        let mut places = ends.clone();
        let mut entries = vec![[0; 2]; count];
        for reading in used() {
            for pair in self.readings[reading].pairs() {
                let place = &mut places[self.cell(pair)];
                entries[*place as usize] = [reading as u32, pair as u32];
                *place += 1;
            }
        }
        CellIndex { ends, entries }
    }
}

/// Which readings look at each cell: their pairs, cell by cell.
#[derive(Clone, Debug)]
pub(super) struct CellIndex {
    ends: Vec<u32>,
    /// Reading and pair.
    entries: Vec<[u32; 2]>,
}

impl CellIndex {
    /// Reading and pair of each reading that looks at a cell.
    pub(super) fn of_cell(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let entries = self.ends[cell] as usize..self.ends[cell + 1] as usize;
        let entries = self.entries[entries].iter();
        entries.map(|[reading, pair]| (*reading as usize, *pair as usize))
    }
}

#[cfg(test)]
mod tests;
