//! The truth about the cells of a map.

use crate::mapping::{Belief, Grid, Map};

/// What a cell truly is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrueCell {
    /// A surface passes it.
    Occupied,
    /// No surface passes it, and the robot's sensors could look into it.
    Free,
    /// Not known, or out of the robot's world: not scored.
    Outside,
}

/// The truth about the cells of a map.
pub type TrueCells = Grid<TrueCell>;

impl TrueCells {
    /// Number of cells of a kind.
    #[must_use]
    pub fn number_of(&self, wanted: TrueCell) -> usize {
        self.iter().filter(|(_, cell)| **cell == wanted).count()
    }

    /// The truth as a map that is sure of its cells.
    #[must_use]
    pub fn as_map(&self) -> Map {
        self.map(Belief::UNKNOWN, |cell| match cell {
            TrueCell::Occupied => Belief::of_probability(1.0),
            TrueCell::Free => Belief::of_probability(0.0),
            TrueCell::Outside => Belief::UNKNOWN,
        })
    }
}
