//! The cells in which the maps of a drive are scored.

use super::{TrueCell, TrueCells};
use crate::drive::{RangeScan, Record, Return};
use crate::lattice::{Cell, Lattice};
use crate::mapping::{Grid, Map, Occupancy, mount_returns};
use crate::rig::Rig;
use crate::sensors::View;

/// The cells that the sensors looked at, the same for all methods of a table.
///
/// A cell is marked if it lies within the footprint of a return with an echo, up to a cell
/// behind it, whatever a method makes of that return.
#[derive(Clone, Debug)]
pub struct ScoredCells {
    rig: Rig,
    /// Of each mount, whether its footprints are marked.
    mounts: Vec<bool>,
    marked: Grid<bool>,
}

impl ScoredCells {
    /// No cell yet; the footprints of these mounts of the rig will be marked.
    #[must_use]
    pub fn new(lattice: Lattice, rig: &Rig, mounts: Vec<bool>) -> Self {
        Self {
            rig: rig.clone(),
            mounts,
            marked: Grid::new(lattice, false),
        }
    }

    /// Marks the cells that are known in one of these maps.
    #[must_use]
    pub fn known_in(maps: &[&Map], lattice: Lattice, rig: &Rig) -> Self {
        let mut cells = Self::new(lattice, rig, Vec::new());
        for map in maps {
            for (cell, belief) in map.iter() {
                if belief.occupancy() != Occupancy::Unknown {
                    cells.mark(cell);
                }
            }
        }
        cells
    }

    fn mark(&mut self, cell: Cell) {
        if let Some(marked) = self.marked.reach(cell) {
            *marked = true;
        }
    }

    /// Takes the next record of the drive.
    pub fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Self {
            rig,
            mounts,
            marked,
        } = self;
        let lattice = marked.lattice();
        for mounted in mount_returns(rig, scan) {
            if mounts.get(mounted.index) != Some(&true) {
                continue;
            }
            let model = mounted.mount.sensor.model();
            for (index, measured) in mounted.recorded().enumerate() {
                if !matches!(measured, Return::Echo { .. }) {
                    continue;
                }
                let view = View {
                    index,
                    measured,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: lattice.cell_m(),
                    lattice,
                };
                model.footprint(&view, &mut |seen| {
                    if let Some(marked) = marked.reach(seen.cell) {
                        *marked = true;
                    }
                });
            }
        }
    }

    /// The marked cells whose truth is known.
    pub(super) fn with_truth<'a>(
        &'a self,
        truth: &'a TrueCells,
    ) -> impl Iterator<Item = (Cell, bool)> + 'a {
        let marked = self.marked.iter().filter(|(_, is_marked)| **is_marked);
        marked.filter_map(|(cell, _)| match truth.get(cell)? {
            TrueCell::Occupied => Some((cell, true)),
            TrueCell::Free => Some((cell, false)),
            TrueCell::Outside => None,
        })
    }
}
