//! The truth about cells from a laser scanner on the robot itself.

use std::collections::BTreeSet;

use super::{TrueCell, TrueCells};
use crate::drive::{RangeScan, Record, Return};
use crate::geometry::Vector;
use crate::lattice::{Cell, Lattice};
use crate::mapping::{Grid, mount_returns};
use crate::rig::Rig;
use crate::sensors::{RangeSensor, Region, Sensor, View};

/// Longest range that is believed, metres.
const REACH_M: f64 = 8.0;
/// Shortest range that is believed, metres.
const NEAREST_M: f64 = 0.05;
/// How far from the robot's places cells are judged, metres.
const MARGIN_M: f64 = 6.0;
/// Least share of hits of an occupied cell, and greatest of a free one.
const OCCUPIED_SHARE: f64 = 0.25;
const FREE_SHARE: f64 = 0.05;

/// Counts the scans of a laser scanner that hit a cell, and those that passed it.
///
/// A scan hits a cell if one of its beams ends there within 8 m, and passes it if a beam
/// crosses it before its end and none ends there; each counts once per scan. A cell is
/// occupied with `least` hits or more and a share of hits of at least 0.25, and free with
/// `least` passes and a share of at most 0.05. Everything else is [`TrueCell::Outside`]:
/// the far sides of walls, people, cells that beams graze.
///
/// The poses are those that the map is made with, so errors of the poses move truth and
/// map alike, and a map from the scanner itself is not judged by an independent truth.
#[derive(Clone, Debug)]
pub struct ScannerTruth {
    rig: Rig,
    least: u16,
    counts: Grid<[u16; 2]>,
    corners: Option<[Vector; 2]>,
}

impl ScannerTruth {
    /// Without a scan; a class needs `least` scans.
    #[must_use]
    pub fn new(lattice: Lattice, rig: &Rig, least: u16) -> Self {
        Self {
            rig: rig.clone(),
            least,
            counts: Grid::new(lattice, [0, 0]),
            corners: None,
        }
    }

    /// Takes the next record; only scans of scanners are used.
    pub fn take(&mut self, record: &Record) {
        let Record::Scan(scan) = record else {
            return;
        };
        let place = scan.world_from_body.position;
        let [low, high] = self.corners.get_or_insert([place, place]);
        *low = Vector::new(low.x.min(place.x), low.y.min(place.y));
        *high = Vector::new(high.x.max(place.x), high.y.max(place.y));
        self.add(scan);
    }

    fn add(&mut self, scan: &RangeScan) {
        let lattice = self.counts.lattice();
        let (mut hits, mut passes) = (BTreeSet::new(), BTreeSet::new());
        for mounted in mount_returns(&self.rig, scan) {
            let Sensor::Scanner(scanner) = &mounted.mount.sensor else {
                continue;
            };
            for (index, measured) in mounted.recorded().enumerate() {
                let Some(measured) = believed(measured) else {
                    continue;
                };
                let view = View {
                    index,
                    measured,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: 0.0,
                    lattice,
                };
                scanner.footprint(&view, &mut |seen| {
                    let cells = match seen.region {
                        Region::AtEcho => &mut hits,
                        _ => &mut passes,
                    };
                    cells.insert(seen.cell);
                });
            }
        }
        for cell in &hits {
            if let Some([count, _]) = self.counts.reach(*cell) {
                *count = count.saturating_add(1);
            }
        }
        for cell in passes.difference(&hits) {
            if let Some([_, count]) = self.counts.reach(*cell) {
                *count = count.saturating_add(1);
            }
        }
    }

    /// The truth from the scans so far, within 6 m of the robot's places in x and y.
    #[must_use]
    pub fn cells(&self) -> TrueCells {
        let lattice = self.counts.lattice();
        let mut cells = TrueCells::new(lattice, TrueCell::Outside);
        let Some([low, high]) = self.corners else {
            return cells;
        };
        let (low, high) = (
            lattice.cell_at(low.x - MARGIN_M, low.y - MARGIN_M),
            lattice.cell_at(high.x + MARGIN_M, high.y + MARGIN_M),
        );
        let (Some(low), Some(high)) = (low, high) else {
            return cells;
        };
        let is_near = |cell: Cell| {
            (low.row..=high.row).contains(&cell.row)
                && (low.column..=high.column).contains(&cell.column)
        };
        for (cell, counts) in self.counts.iter() {
            let kind = self.class(*counts);
            if kind != TrueCell::Outside
                && is_near(cell)
                && let Some(held) = cells.reach(cell)
            {
                *held = kind;
            }
        }
        cells
    }

    fn class(&self, [hits, passes]: [u16; 2]) -> TrueCell {
        let share = f64::from(hits) / (f64::from(hits) + f64::from(passes));
        if hits >= self.least && share >= OCCUPIED_SHARE {
            TrueCell::Occupied
        } else if passes >= self.least && share <= FREE_SHARE {
            TrueCell::Free
        } else {
            TrueCell::Outside
        }
    }
}

/// A return cut to the range that is believed; `None` without a range.
fn believed(measured: Return) -> Option<Return> {
    let no_echo = Return::NoEcho {
        limit_m: REACH_M,
        sigma_m: 0.0,
    };
    match measured {
        Return::Echo { range_m, .. } if range_m <= NEAREST_M => None,
        Return::Echo { range_m, .. } if range_m < REACH_M => Some(Return::Echo {
            range_m,
            sigma_m: 0.0,
        }),
        Return::Echo { .. } | Return::NoEcho { .. } => Some(no_echo),
        Return::TooClose | Return::Invalid => None,
    }
}
