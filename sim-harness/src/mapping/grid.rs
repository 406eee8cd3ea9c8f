//! A grid over the world that grows as the robot drives.

use super::Lattice;

/// Most cells a grid may have, 8000 x 8000; growth beyond it is refused and counted.
pub const MAX_CELLS: usize = 64_000_000;

/// Cells added at each side beyond need, so that growing is rare.
const MARGIN: i32 = 32;

/// A cell's place: column and row, counted from the world's origin, y upward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Row: floor of y / cell size.
    pub row: i32,
    /// Column: floor of x / cell size.
    pub column: i32,
}

/// Square cells over a rectangle of the world, row-major from the lowest y.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    cell_m: f64,
    first: Cell,
    columns: usize,
    rows: usize,
    cells: Vec<T>,
    blank: T,
    refused: u64,
}

impl<T: Clone> Grid<T> {
    /// An empty grid of cells of the given size, metres; new cells are `blank`.
    ///
    /// # Panics
    /// If the size is not a positive number.
    #[must_use]
    pub fn new(cell_m: f64, blank: T) -> Self {
        assert!(
            cell_m > 0.0 && cell_m.is_finite(),
            "cell size must be positive, not {cell_m}"
        );
        Self {
            cell_m,
            first: Cell { row: 0, column: 0 },
            columns: 0,
            rows: 0,
            cells: Vec::new(),
            blank,
            refused: 0,
        }
    }

    /// Size of a cell, metres.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.cell_m
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

    /// Number of cells asked for and refused because the grid would exceed [`MAX_CELLS`],
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
        Lattice::new(self.cell_m)
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

    fn offset(&self, cell: Cell) -> Option<usize> {
        let row = usize::try_from(i64::from(cell.row) - i64::from(self.first.row)).ok()?;
        let column = usize::try_from(i64::from(cell.column) - i64::from(self.first.column)).ok()?;
        (row < self.rows && column < self.columns).then(|| row * self.columns + column)
    }

    /// What a cell holds; `None` outside the store.
    #[must_use]
    pub fn get(&self, cell: Cell) -> Option<&T> {
        self.cells.get(self.offset(cell)?)
    }

    /// A cell to write to, growing the grid as needed; `None` when it may grow no further.
    pub fn reach(&mut self, cell: Cell) -> Option<&mut T> {
        if self.offset(cell).is_none() && !self.grow(cell) {
            self.refuse();
            return None;
        }
        let offset = self.offset(cell)?;
        self.cells.get_mut(offset)
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
        if !self.cells.is_empty() {
            low.row = low.row.min(self.first.row);
            low.column = low.column.min(self.first.column);
            high.row = high.row.max(self.first.row + self.rows as i32 - 1);
            high.column = high.column.max(self.first.column + self.columns as i32 - 1);
        }
        if low.row != self.first.row || self.cells.is_empty() {
            low.row -= MARGIN;
        }
        if low.column != self.first.column || self.cells.is_empty() {
            low.column -= MARGIN;
        }
        let rows = (i64::from(high.row) - i64::from(low.row) + 1 + i64::from(MARGIN)) as usize;
        let columns =
            (i64::from(high.column) - i64::from(low.column) + 1 + i64::from(MARGIN)) as usize;
        match rows.checked_mul(columns) {
            Some(count) if count <= MAX_CELLS => {}
            _ => return false,
        }
        let mut cells = vec![self.blank.clone(); rows * columns];
        let row_shift = (i64::from(self.first.row) - i64::from(low.row)) as usize;
        let column_shift = (i64::from(self.first.column) - i64::from(low.column)) as usize;
        for (row, old) in self.cells.chunks(self.columns.max(1)).enumerate() {
            let start = (row + row_shift) * columns + column_shift;
            cells[start..start + old.len()].clone_from_slice(old);
        }
        self.cells = cells;
        self.first = low;
        self.rows = rows;
        self.columns = columns;
        true
    }

    /// Every cell in store with its place, row by row from the lowest y.
    pub fn iter(&self) -> impl Iterator<Item = (Cell, &T)> {
        let (first, columns) = (self.first, self.columns.max(1));
        self.cells.iter().enumerate().map(move |(index, value)| {
            let cell = Cell {
                row: first.row + (index / columns) as i32,
                column: first.column + (index % columns) as i32,
            };
            (cell, value)
        })
    }

    /// The same grid with every cell converted.
    pub fn map<U: Clone>(&self, blank: U, convert: impl Fn(&T) -> U) -> Grid<U> {
        Grid {
            cell_m: self.cell_m,
            first: self.first,
            columns: self.columns,
            rows: self.rows,
            cells: self.cells.iter().map(convert).collect(),
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
