//! Which cells of a room are wall and which are free, and scores of maps against it.

use crate::drive::{RangeScan, Return};
use crate::geometry::Vector;
use crate::lattice::{Cell, Lattice};
use crate::mapping::{Grid, Map, Occupancy};
use crate::rig::Rig;
use crate::sensors::View;

use super::RoomWalls;

/// Rounding that is allowed for at a wall's edge, metres.
const ROUNDING_M: f64 = 1e-9;

/// Cells of a room: walls, free cells, and the cells that are scored.
#[derive(Clone, Debug)]
pub struct CellTruth {
    /// Whether a cell is wall; `None` outside of the room.
    is_wall: Grid<Option<bool>>,
    /// Cells that an echo looks at.
    mask: Grid<bool>,
}

/// Scores of a map within the mask; a cell that is unknown counts as not occupied.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellScores {
    /// Share of the cells that are classified wrongly.
    pub error: f64,
    /// Share of the walls that are occupied.
    pub true_positives: f64,
    /// Share of the free cells that are occupied.
    pub false_positives: f64,
    /// Share of the free cells that are free in the map.
    pub true_negatives: f64,
    /// Share of the cells with a class.
    pub coverage: f64,
}

impl CellTruth {
    /// Cells whose centre is within a distance of a wall are wall; cells that are connected
    /// with one of the robot's places without a wall between are free.
    #[must_use]
    pub fn new(
        lattice: Lattice,
        walls: &RoomWalls,
        within_m: f64,
        places: impl Iterator<Item = Vector>,
    ) -> Self {
        let mut is_wall = Grid::new(lattice, None);
        let mut open: Vec<Cell> = places
            .filter_map(|it| lattice.cell_at(it.x, it.y))
            .collect();
        while let Some(cell) = open.pop() {
            // A grid that is full ends the search: the room has no closed walls.
            let Some(known) = is_wall.reach(cell).filter(|known| known.is_none()) else {
                continue;
            };
            let (x, y) = lattice.centre(cell);
            let found = walls.distance_m(Vector::new(x, y)) <= within_m + ROUNDING_M;
            *known = Some(found);
            if !found {
                open.extend(
                    [(0, 1), (0, -1), (1, 0), (-1, 0)].map(|(row, column)| Cell {
                        row: cell.row + row,
                        column: cell.column + column,
                    }),
                );
            }
        }
        Self {
            is_wall,
            mask: Grid::new(lattice, false),
        }
    }

    /// Adds the cells that the echoes of a scan look at to those that are scored.
    pub fn look(&mut self, rig: &Rig, scan: &RangeScan) {
        let lattice = self.mask.lattice();
        let mut returns = scan.returns.iter();
        for mount in rig.mounts.get(scan.mounts.clone()).unwrap_or_default() {
            let model = mount.sensor.model();
            for (index, measured) in returns.by_ref().take(model.returns()).enumerate() {
                if !matches!(measured, Return::Echo { .. }) {
                    continue;
                }
                let view = View {
                    index,
                    measured: *measured,
                    world_from_sensor: scan.world_from_body * mount.body_from_sensor,
                    tolerance_m: lattice.cell_m(),
                    lattice,
                };
                model.footprint(&view, &mut |seen| {
                    if let Some(is_scored) = self.mask.reach(seen.cell) {
                        *is_scored = true;
                    }
                });
            }
        }
    }

    /// The cells that are scored, and whether they are wall.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, bool)> {
        let cells = self.is_wall.iter();
        let scored = cells.filter(|(cell, _)| self.mask.get(*cell) == Some(&true));
        scored.filter_map(|(cell, is_wall)| is_wall.map(|is_wall| (cell, is_wall)))
    }

    /// Scores of a map.
    #[must_use]
    pub fn scores(&self, map: &Map) -> CellScores {
        self.scores_of(map, |_| true)
    }

    /// Scores over the cells of a part of the room, by their centres.
    #[must_use]
    pub fn scores_of(&self, map: &Map, is_wanted: impl Fn(Vector) -> bool) -> CellScores {
        let [mut walls, mut free] = [[0.0_f64; 3]; 2];
        let lattice = self.mask.lattice();
        for (cell, is_wall) in self.cells() {
            let (x, y) = lattice.centre(cell);
            if !is_wanted(Vector::new(x, y)) {
                continue;
            }
            let row = if is_wall { &mut walls } else { &mut free };
            match map.occupancy(cell) {
                Occupancy::Occupied => row[0] += 1.0,
                Occupancy::Free => row[1] += 1.0,
                Occupancy::Unknown => row[2] += 1.0,
            }
        }
        let [all_walls, all_free] = [walls, free].map(|row| row.iter().sum::<f64>());
        CellScores {
            error: (free[0] + all_walls - walls[0]) / (all_walls + all_free),
            true_positives: walls[0] / all_walls,
            false_positives: free[0] / all_free,
            true_negatives: free[1] / all_free,
            coverage: 1.0 - (walls[2] + free[2]) / (all_walls + all_free),
        }
    }
}

impl CellScores {
    /// The mean of several.
    #[must_use]
    pub fn mean(all: &[Self]) -> Self {
        let mean = |value: fn(&Self) -> f64| all.iter().map(value).sum::<f64>() / all.len() as f64;
        Self {
            error: mean(|it| it.error),
            true_positives: mean(|it| it.true_positives),
            false_positives: mean(|it| it.false_positives),
            true_negatives: mean(|it| it.true_negatives),
            coverage: mean(|it| it.coverage),
        }
    }
}
