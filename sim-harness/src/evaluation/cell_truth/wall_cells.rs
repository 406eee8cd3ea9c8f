//! The cells that known walls pass.

use std::collections::HashMap;

use crate::geometry::Vector;
use crate::lattice::{Cell, Lattice};

/// Cells along a side of a tile: a row of them is a word of bits.
const TILE: u8 = 64;

/// Finds the cells whose centres lie near a wall, tile by tile as they are asked for.
///
/// Cost: per tile the number of walls, and per wall the cells of the tile in the rectangle
/// around it. Memory: 512 bytes per tile.
#[derive(Debug)]
pub(super) struct WallCells<'a> {
    walls: &'a [[Vector; 2]],
    lattice: Lattice,
    /// Distance from a centre within which a wall passes the cell, metres.
    reach_m: f64,
    /// Rows of cells from the lowest y, the lowest bit at the lowest x.
    tiles: HashMap<Cell, [u64; TILE as usize]>,
}

impl<'a> WallCells<'a> {
    pub(super) fn new(walls: &'a [[Vector; 2]], lattice: Lattice, reach_m: f64) -> Self {
        Self {
            walls,
            lattice,
            reach_m,
            tiles: HashMap::new(),
        }
    }

    /// Whether a wall passes a cell.
    pub(super) fn is_wall(&mut self, cell: Cell) -> bool {
        let side = i32::from(TILE);
        let first = Cell {
            row: cell.row - cell.row.rem_euclid(side),
            column: cell.column - cell.column.rem_euclid(side),
        };
        let Self {
            walls,
            lattice,
            reach_m,
            tiles,
        } = self;
        let rows = tiles
            .entry(first)
            .or_insert_with(|| tile(walls, *lattice, *reach_m, first));
        let row = rows.get(cell.row.abs_diff(first.row) as usize);
        row.is_some_and(|row| row >> cell.column.abs_diff(first.column) & 1 == 1)
    }
}

/// The rows of the tile of a first cell.
fn tile(
    walls: &[[Vector; 2]],
    lattice: Lattice,
    reach_m: f64,
    first: Cell,
) -> [u64; TILE as usize] {
    let mut rows = [0; TILE as usize];
    let (first_x, first_y) = lattice.centre(first);
    let most = f64::from(TILE - 1);
    // The first and last cell along an axis that a wall may reach.
    let span = |from: f64, to: f64, origin: f64| {
        let cells = |metres: f64| (metres - origin) / lattice.cell_m();
        let low = cells(from.min(to) - reach_m).floor();
        let high = cells(from.max(to) + reach_m).ceil();
        // Within 0 to 63.
        (low <= most && high >= 0.0).then(|| low.max(0.0) as u8..=high.min(most) as u8)
    };
    for [from, to] in walls {
        let spans = span(from.x, to.x, first_x).zip(span(from.y, to.y, first_y));
        let Some((columns, lines)) = spans else {
            continue;
        };
        for line in lines {
            let Some(row) = rows.get_mut(usize::from(line)) else {
                continue;
            };
            for column in columns.clone() {
                if *row >> column & 1 == 1 {
                    continue;
                }
                let (x, y) = lattice.centre(Cell {
                    row: first.row + i32::from(line),
                    column: first.column + i32::from(column),
                });
                if Vector::new(x, y).distance_from_segment(*from, *to) <= reach_m {
                    *row |= 1_u64 << column;
                }
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_of_any_direction_pass_the_cells_that_are_near_them() {
        let place = Vector::new;
        let walls = [
            [place(-3.1, -2.0), place(4.7, 3.3)],
            [place(1.0, -4.0), place(1.0, 4.0)],
            [place(-0.65, 0.05), place(-0.65, 0.05)],
            [place(2.0, 2.5), place(-2.0, 2.45)],
        ];
        for lattice in [
            Lattice::new(0.05),
            Lattice::new(0.05).moved_by_half_a_cell(),
        ] {
            let mut cells = WallCells::new(&walls, lattice, 0.025);
            let mut found = 0;
            for row in -100..100 {
                for column in -100..100 {
                    let cell = Cell { row, column };
                    let (x, y) = lattice.centre(cell);
                    let is_near = |[from, to]: &[Vector; 2]| {
                        place(x, y).distance_from_segment(*from, *to) <= 0.025
                    };
                    let expected = walls.iter().any(is_near);
                    assert_eq!(cells.is_wall(cell), expected, "{cell:?} of {lattice:?}");
                    found += u32::from(expected);
                }
            }
            assert!(found > 300, "{found}");
        }
    }
}
