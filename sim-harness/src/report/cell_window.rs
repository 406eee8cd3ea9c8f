//! The part of a map that a figure shows.

use crate::lattice::Cell;
use crate::mapping::{Map, Occupancy};

/// A rectangle of cells, both corners included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellWindow {
    low: Cell,
    high: Cell,
}

impl CellWindow {
    /// The smallest window that holds every known cell; `None` when no cell is known.
    #[must_use]
    pub fn known(map: &Map) -> Option<Self> {
        map.iter()
            .filter(|(_, belief)| belief.occupancy() != Occupancy::Unknown)
            .fold(None, |window, (cell, _)| {
                Some(window.map_or(Self::of(cell), |window: Self| window.with(cell)))
            })
    }

    /// The window of one cell.
    #[must_use]
    pub fn of(cell: Cell) -> Self {
        Self {
            low: cell,
            high: cell,
        }
    }

    /// The smallest window that holds this one and a cell.
    #[must_use]
    pub fn with(self, cell: Cell) -> Self {
        Self {
            low: Cell {
                row: self.low.row.min(cell.row),
                column: self.low.column.min(cell.column),
            },
            high: Cell {
                row: self.high.row.max(cell.row),
                column: self.high.column.max(cell.column),
            },
        }
    }

    /// The smallest window that holds this one and another.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        self.with(other.low).with(other.high)
    }

    /// The window with so many cells more at each side.
    #[must_use]
    pub fn widened(self, cells: i32) -> Self {
        Self {
            low: Cell {
                row: self.low.row.saturating_sub(cells),
                column: self.low.column.saturating_sub(cells),
            },
            high: Cell {
                row: self.high.row.saturating_add(cells),
                column: self.high.column.saturating_add(cells),
            },
        }
    }

    /// The cell of lowest row and column.
    #[must_use]
    pub fn low(&self) -> Cell {
        self.low
    }

    /// Columns, at least one.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.high.column.abs_diff(self.low.column) as usize + 1
    }

    /// Rows, at least one.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.high.row.abs_diff(self.low.row) as usize + 1
    }

    /// Column and row of a cell counted from the lowest; `None` outside.
    #[must_use]
    pub fn offset(&self, cell: Cell) -> Option<(usize, usize)> {
        let inside = (self.low.column..=self.high.column).contains(&cell.column)
            && (self.low.row..=self.high.row).contains(&cell.row);
        inside.then(|| {
            (
                cell.column.abs_diff(self.low.column) as usize,
                cell.row.abs_diff(self.low.row) as usize,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Belief;

    #[test]
    fn known_cells_bound_the_window_and_unknown_ones_do_not() {
        let mut map = Map::unknown(0.01);
        assert_eq!(CellWindow::known(&map), None);
        for (row, column, p_occ) in [(0, 0, 0.5), (-3, 7, 0.9), (4, 5, 0.1), (90, 90, f32::NAN)] {
            *map.reach(Cell { row, column }).unwrap() = Belief::of_probability(p_occ);
        }
        let window = CellWindow::known(&map).unwrap();
        assert_eq!(window.low(), Cell { row: -3, column: 5 });
        assert_eq!((window.columns(), window.rows()), (3, 8));
        assert_eq!(window.offset(Cell { row: 4, column: 7 }), Some((2, 7)));
        assert_eq!(window.offset(Cell { row: 5, column: 7 }), None);
        assert_eq!(window.widened(2).columns(), 7);
    }
}
