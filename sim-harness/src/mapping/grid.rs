//! A grid over the world that grows as the robot drives.

use crate::lattice::{Cell, Lattice};

/// Most cells a grid may have, 8000 x 8000; growth beyond it is refused and counted.
pub const MAX_CELLS: usize = 64_000_000;

/// Cells added at each side beyond need, so that growing is rare.
const MARGIN: i32 = 32;

/// Cells along a side of a tile.
const TILE: usize = 64;

/// Square cells over a rectangle of the world.
///
/// Stored in tiles of 64 x 64 cells, and only those in which a cell was reached: memory
/// goes with the area that was mapped, not with the rectangle around it. A drive of 130 m
/// along a diagonal reaches 1.6 % of its rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    lattice: Lattice,
    first: Cell,
    columns: usize,
    rows: usize,
    /// The tile of the first cell, and the tiles in a row of them; rows of tiles follow
    /// each other from the lowest y.
    first_tile: Cell,
    tile_columns: usize,
    tiles: Vec<Option<Box<[T]>>>,
    blank: T,
    refused: u64,
}

/// The tile that holds a cell.
fn tile_of(cell: Cell) -> Cell {
    Cell {
        row: cell.row.div_euclid(TILE as i32),
        column: cell.column.div_euclid(TILE as i32),
    }
}

/// The place of a cell within its tile.
fn within_tile(cell: Cell) -> usize {
    let place = |index: i32| index.rem_euclid(TILE as i32) as usize;
    place(cell.row) * TILE + place(cell.column)
}

/// Cells or tiles from one index to another that is not below it.
fn span(low: i32, high: i32) -> usize {
    (i64::from(high) - i64::from(low)) as usize
}

impl<T: Clone> Grid<T> {
    /// An empty grid over the cells of a lattice; new cells are `blank`.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, blank: T) -> Self {
        Self {
            lattice: lattice.into(),
            first: Cell { row: 0, column: 0 },
            columns: 0,
            rows: 0,
            first_tile: Cell { row: 0, column: 0 },
            tile_columns: 0,
            tiles: Vec::new(),
            blank,
            refused: 0,
        }
    }

    /// Size of a cell, metres.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.lattice.cell_m()
    }

    /// Columns in store.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows in store.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The cell of lowest row and column in store.
    #[must_use]
    pub fn first(&self) -> Cell {
        self.first
    }

    /// Number of cells refused because the grid would exceed [`MAX_CELLS`],
    /// repetitions included: above zero, the grid is cut.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Counts a cell as refused that lies too far away to have a place in any grid.
    pub fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
    }

    /// Where its cells lie.
    #[must_use]
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// As [`Lattice::cell_at`].
    #[must_use]
    pub fn cell_at(&self, x: f64, y: f64) -> Option<Cell> {
        self.lattice().cell_at(x, y)
    }

    /// As [`Lattice::centre`].
    #[must_use]
    pub fn centre(&self, cell: Cell) -> (f64, f64) {
        self.lattice().centre(cell)
    }

    /// Whether the rectangle holds a cell.
    fn contains(&self, cell: Cell) -> bool {
        let inside = |index: i32, first: i32, count: usize| {
            usize::try_from(i64::from(index) - i64::from(first)).is_ok_and(|place| place < count)
        };
        inside(cell.row, self.first.row, self.rows)
            && inside(cell.column, self.first.column, self.columns)
    }

    /// The place of a cell's tile, of a cell that the rectangle holds.
    fn tile_place(&self, cell: Cell) -> usize {
        let tile = tile_of(cell);
        span(self.first_tile.row, tile.row) * self.tile_columns
            + span(self.first_tile.column, tile.column)
    }

    /// What a cell holds; `None` outside the rectangle.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Option<&T> {
        if !self.contains(cell) {
            return None;
        }
        let tile = self.tiles.get(self.tile_place(cell))?;
        let cells = tile.as_ref().and_then(|cells| cells.get(within_tile(cell)));
        Some(cells.unwrap_or(&self.blank))
    }

    /// A cell to write to, growing the grid as needed; `None` when it may grow no further.
    pub fn reach(&mut self, cell: Cell) -> Option<&mut T> {
        if !self.contains(cell) && !self.grow(cell) {
            self.refuse();
            return None;
        }
        let place = self.tile_place(cell);
        let Self { tiles, blank, .. } = self;
        let blank = || vec![blank.clone(); TILE * TILE].into_boxed_slice();
        let cells = tiles.get_mut(place)?.get_or_insert_with(blank);
        cells.get_mut(within_tile(cell))
    }

    /// The cell that holds a point of the world, as [`reach`](Self::reach); a point
    /// without a cell is counted as refused.
    pub fn reach_at(&mut self, x: f64, y: f64) -> Option<&mut T> {
        let Some(cell) = self.cell_at(x, y) else {
            self.refuse();
            return None;
        };
        self.reach(cell)
    }

    fn grow(&mut self, cell: Cell) -> bool {
        let (mut low, mut high) = (cell, cell);
        let is_empty = self.tiles.is_empty();
        if !is_empty {
            low.row = low.row.min(self.first.row);
            low.column = low.column.min(self.first.column);
            high.row = high.row.max(self.first.row + self.rows as i32 - 1);
            high.column = high.column.max(self.first.column + self.columns as i32 - 1);
        }
        if low.row != self.first.row || is_empty {
            low.row -= MARGIN;
        }
        if low.column != self.first.column || is_empty {
            low.column -= MARGIN;
        }
        let rows = (i64::from(high.row) - i64::from(low.row) + 1 + i64::from(MARGIN)) as usize;
        let columns =
            (i64::from(high.column) - i64::from(low.column) + 1 + i64::from(MARGIN)) as usize;
        match rows.checked_mul(columns) {
            Some(count) if count <= MAX_CELLS => {}
            _ => return false,
        }
        let last = Cell {
            // Both sides of the rectangle are in range: below 2e9 + 64 cells away.
            row: low.row + (rows - 1) as i32,
            column: low.column + (columns - 1) as i32,
        };
        self.lay_tiles(tile_of(low), tile_of(last));
        self.first = low;
        self.rows = rows;
        self.columns = columns;
        true
    }

    /// Makes room for the tiles from one to another and keeps those that are there.
    fn lay_tiles(&mut self, first: Cell, last: Cell) {
        let columns = span(first.column, last.column) + 1;
        let rows = span(first.row, last.row) + 1;
        let mut tiles = Vec::new();
        tiles.resize_with(rows * columns, || None);
        let old_columns = self.tile_columns.max(1);
        for (number, tile) in self.tiles.drain(..).enumerate() {
            let row = span(first.row, self.first_tile.row) + number / old_columns;
            let column = span(first.column, self.first_tile.column) + number % old_columns;
            if let Some(place) = tiles.get_mut(row * columns + column) {
                *place = tile;
            }
        }
        self.tiles = tiles;
        self.first_tile = first;
        self.tile_columns = columns;
    }

    /// Every cell in store with its place, row by row from the lowest y: those of the tiles
    /// in which a cell was reached.
    pub fn iter(&self) -> impl Iterator<Item = (Cell, &T)> {
        let rows = self.tiles.chunks(self.tile_columns.max(1)).enumerate();
        rows.flat_map(move |(tile_row, tiles)| {
            (0..TILE * tiles.len()).filter_map(move |number| {
                // Along the lowest row of cells through all tiles, then the next.
                let (row, tile) = (number / tiles.len(), number % tiles.len());
                let cells = tiles.get(tile)?.as_ref()?;
                Some((
                    tile_row,
                    row,
                    tile,
                    cells.get(row * TILE..(row + 1) * TILE)?,
                ))
            })
        })
        .flat_map(move |(tile_row, row, tile, cells)| {
            let first = Cell {
                row: self.first_tile.row * TILE as i32 + (tile_row * TILE + row) as i32,
                column: self.first_tile.column * TILE as i32 + (tile * TILE) as i32,
            };
            cells.iter().zip(0_i32..).map(move |(value, along)| {
                let cell = Cell {
                    column: first.column + along,
                    ..first
                };
                (cell, value)
            })
        })
        .filter(|(cell, _)| self.contains(*cell))
    }

    /// The same grid with every cell converted.
    pub fn map<U: Clone>(&self, blank: U, convert: impl Fn(&T) -> U) -> Grid<U> {
        Grid {
            lattice: self.lattice,
            first: self.first,
            columns: self.columns,
            rows: self.rows,
            first_tile: self.first_tile,
            tile_columns: self.tile_columns,
            tiles: self
                .tiles
                .iter()
                .map(|tile| Some(tile.as_ref()?.iter().map(&convert).collect()))
                .collect(),
            blank,
            refused: self.refused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_their_content_while_the_grid_grows_every_way() {
        let mut grid = Grid::new(0.01, 0_u32);
        let places = [
            (0, 0),
            (100, 3),
            (-250, 40),
            (7, -90),
            (-251, -91),
            (400, 400),
        ];
        for (value, (column, row)) in (1..).zip(places) {
            *grid.reach(Cell { row, column }).unwrap() = value;
        }
        for (value, (column, row)) in (1..).zip(places) {
            assert_eq!(
                grid.get(Cell { row, column }),
                Some(&value),
                "({column}, {row})"
            );
        }
        let sum: u32 = grid.iter().map(|(_, value)| value).sum();
        assert_eq!(sum, 21);
        for (cell, value) in grid.iter() {
            assert_eq!(grid.get(cell), Some(value));
        }
    }

    #[test]
    fn cells_come_row_by_row_and_only_from_tiles_that_were_reached() {
        let mut grid = Grid::new(0.01, 0_u32);
        let cells = [(-70, 200), (-70, 3), (5, -300), (5, 64), (300, 0)];
        for (row, column) in cells {
            *grid.reach(Cell { row, column }).unwrap() = 1;
        }
        let all: Vec<Cell> = grid.iter().map(|(cell, _)| cell).collect();
        assert!(all.is_sorted());
        let marked: Vec<Cell> = grid
            .iter()
            .filter(|(_, value)| **value == 1)
            .map(|(cell, _)| cell)
            .collect();
        let mut expected = cells.map(|(row, column)| Cell { row, column });
        expected.sort();
        assert_eq!(marked, expected);
        // Five tiles at most, of a rectangle of more than sixty.
        assert!(all.len() <= 5 * TILE * TILE, "{}", all.len());
        assert!(grid.rows() * grid.columns() > 60 * TILE * TILE);
        // Inside the rectangle, outside of all tiles.
        let between = Cell {
            row: 150,
            column: 150,
        };
        assert_eq!(grid.get(between), Some(&0));
        assert_eq!(grid.map(7_u8, |value| *value as u8).get(between), Some(&7));
    }

    #[test]
    fn points_fall_into_the_cell_below_and_left() {
        let grid = Grid::new(0.01, ());
        assert_eq!(
            grid.cell_at(0.005, -0.005),
            Some(Cell { row: -1, column: 0 })
        );
        assert_eq!(grid.cell_at(f64::NAN, 0.0), None);
        assert_eq!(grid.cell_at(1e30, 0.0), None);
        let (x, y) = grid.centre(Cell { row: -1, column: 2 });
        assert!((x - 0.025).abs() < 1e-12 && (y + 0.005).abs() < 1e-12);
    }

    #[test]
    fn growth_beyond_the_cap_is_refused_and_counted() {
        let mut grid = Grid::new(0.01, 0_u8);
        assert!(grid.reach(Cell { row: 0, column: 0 }).is_some());
        assert!(
            grid.reach(Cell {
                row: 100_000_000,
                column: 5
            })
            .is_none()
        );
        assert!(
            grid.reach(Cell {
                row: -999_999_999,
                column: 999_999_999
            })
            .is_none()
        );
        assert_eq!(grid.refused(), 2);
        assert!(grid.reach_at(1e30, 0.0).is_none(), "no cell has this place");
        assert_eq!(grid.refused(), 3);
        assert!(grid.reach(Cell { row: 5, column: 5 }).is_some());
    }
}
