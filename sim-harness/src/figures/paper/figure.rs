//! The figures by name.

use core::ops::Range;

use super::plate::Plate;
use super::{FigureError, figure_9};

/// A figure that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Figure 9: maps.
    Maps,
}

impl Figure {
    /// All figures in the order of the page.
    pub const ALL: [Self; 1] = [Self::Maps];

    /// The name that asks for the figure, and that its files begin with.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Maps => "figure-9",
        }
    }

    /// Simulates what the figure needs, and draws it.
    ///
    /// A figure of one drive takes the first seed; figures with a spread take all.
    /// The same seeds give the same bytes on every run and machine.
    ///
    /// # Errors
    /// None with the scenarios and parameters that ship.
    pub fn draw(self, seeds: &Range<u64>) -> Result<Plate, FigureError> {
        match self {
            Self::Maps => figure_9::draw(seeds.start),
        }
    }
}
