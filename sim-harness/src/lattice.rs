//! The geometry of square cells over the whole world.

/// A cell's place: column and row, counted from the world's origin, y upward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Row: floor of y / cell size.
    pub row: i32,
    /// Column: floor of x / cell size.
    pub column: i32,
}

/// A lattice of square cells of one size, counted from the world's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    cell_m: f64,
}

impl Lattice {
    /// Cells of the given size, metres.
    ///
    /// # Panics
    /// If the size is not a positive number.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        assert!(
            cell_m > 0.0 && cell_m.is_finite(),
            "cell size must be positive, not {cell_m}"
        );
        Self { cell_m }
    }

    /// Size of a cell, metres.
    #[must_use]
    pub fn cell_m(self) -> f64 {
        self.cell_m
    }

    /// The cell that holds a point of the world; `None` for NaN and points beyond the range
    /// of the indices.
    #[must_use]
    pub fn cell_at(self, x: f64, y: f64) -> Option<Cell> {
        let index = |metres: f64| {
            let cells = (metres / self.cell_m).floor();
            (cells.abs() < 1e9).then_some(cells as i32)
        };
        Some(Cell {
            row: index(y)?,
            column: index(x)?,
        })
    }

    /// The centre of a cell, metres.
    #[must_use]
    pub fn centre(self, cell: Cell) -> (f64, f64) {
        (
            (f64::from(cell.column) + 0.5) * self.cell_m,
            (f64::from(cell.row) + 0.5) * self.cell_m,
        )
    }
}
