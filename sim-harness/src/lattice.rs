//! The geometry of square cells over the whole world.

/// A cell's place: column and row, counted from the world's origin, y upward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Row: floor of y / cell size.
    pub row: i32,
    /// Column: floor of x / cell size.
    pub column: i32,
}

/// A lattice of square cells of one size, counted from a corner of one of them: the world's
/// origin, where nothing else is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    cell_m: f64,
    /// The lower left corner of the cell of row 0 and column 0, metres.
    corner_m: [f64; 2],
}

impl Lattice {
    /// Cells of the given size, metres, counted from the world's origin.
    ///
    /// # Panics
    /// If the size is not a positive number.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        assert!(
            cell_m > 0.0 && cell_m.is_finite(),
            "cell size must be positive, not {cell_m}"
        );
        Self {
            cell_m,
            corner_m: [0.0, 0.0],
        }
    }

    /// The same cells moved by half a cell along both axes, so that lines at whole multiples
    /// of the cell size run through the centres of cells, not along their borders.
    #[must_use]
    pub fn moved_by_half_a_cell(self) -> Self {
        let half_m = -0.5 * self.cell_m;
        Self {
            corner_m: [half_m, half_m],
            ..self
        }
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
        let [corner_x, corner_y] = self.corner_m;
        let index = |metres: f64| {
            let cells = (metres / self.cell_m).floor();
            (cells.abs() < 1e9).then_some(cells as i32)
        };
        Some(Cell {
            row: index(y - corner_y)?,
            column: index(x - corner_x)?,
        })
    }

    /// The centre of a cell, metres.
    #[must_use]
    pub fn centre(self, cell: Cell) -> (f64, f64) {
        let [corner_x, corner_y] = self.corner_m;
        (
            corner_x + (f64::from(cell.column) + 0.5) * self.cell_m,
            corner_y + (f64::from(cell.row) + 0.5) * self.cell_m,
        )
    }

    /// The lower left corner of a cell, metres.
    #[must_use]
    pub fn corner(self, cell: Cell) -> (f64, f64) {
        let [corner_x, corner_y] = self.corner_m;
        (
            corner_x + f64::from(cell.column) * self.cell_m,
            corner_y + f64::from(cell.row) * self.cell_m,
        )
    }
}

/// Cells of the given size, metres, as [`Lattice::new`].
impl From<f64> for Lattice {
    fn from(cell_m: f64) -> Self {
        Self::new(cell_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_the_cell_size_are_centres_of_a_moved_lattice() {
        let lattice = Lattice::new(0.05).moved_by_half_a_cell();
        for count in [-7, 0, 20] {
            let along_m = 0.05 * f64::from(count);
            let cell = lattice.cell_at(along_m + 0.024, along_m - 0.024).unwrap();
            assert_eq!((cell.row, cell.column), (count, count));
            let (x, y) = lattice.centre(cell);
            assert!((x - along_m).abs() < 1e-12 && (y - along_m).abs() < 1e-12);
            let (x, y) = lattice.corner(cell);
            assert!((x - along_m + 0.025).abs() < 1e-12 && (y - along_m + 0.025).abs() < 1e-12);
        }
    }
}
