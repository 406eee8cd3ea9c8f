//! The figures by name.

use core::ops::Range;

use super::page_section::PageSection;
use super::{figure_1, figure_2, figure_4, figure_5, figure_8, figure_9, influence, walls};
use crate::RunError;
use crate::world::ScenarioError;

/// A figure that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaperFigure {
    /// Figure 1: the error contour of a reading.
    ErrorContour,
    /// Figure 2: the inverse sensor model.
    InverseSensor,
    /// Figure 4: two steps of the filter.
    TwoSteps,
    /// Figure 5: from particles to a map.
    Counting,
    /// Figure 8: overall errors.
    OverallErrors,
    /// Figure 9: maps.
    Maps,
    /// Not in the paper: the influence of particles, gate and noise.
    Influence,
    /// Not in the paper: maps of extended surfaces.
    Walls,
}

/// Why a figure could not be drawn; impossible with the files that ship.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A scenario of the program itself cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The filter refused its configuration.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl PaperFigure {
    /// All figures in the order of the page.
    pub const ALL: [Self; 8] = [
        Self::ErrorContour,
        Self::InverseSensor,
        Self::TwoSteps,
        Self::Counting,
        Self::OverallErrors,
        Self::Maps,
        Self::Influence,
        Self::Walls,
    ];

    /// The name on the command line, and the beginning of the names of the files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ErrorContour => "figure-1",
            Self::InverseSensor => "figure-2",
            Self::TwoSteps => "figure-4",
            Self::Counting => "figure-5",
            Self::OverallErrors => "figure-8",
            Self::Maps => "figure-9",
            Self::Influence => "influence",
            Self::Walls => "walls",
        }
    }

    /// Simulates what the figure needs, and draws it.
    ///
    /// A figure of one drive takes the first seed; figures of means take all seeds, the
    /// last figure at most four. The same seeds give the same bytes on every run and
    /// machine.
    ///
    /// # Errors
    /// None with the scenarios and parameters that ship.
    pub fn draw(self, seeds: &Range<u64>) -> Result<PageSection, FigureError> {
        match self {
            Self::ErrorContour => Ok(figure_1::draw()),
            Self::InverseSensor => Ok(figure_2::draw()),
            Self::TwoSteps => Ok(figure_4::draw(seeds.start)),
            Self::Counting => Ok(figure_5::draw(seeds.start)),
            Self::OverallErrors => figure_8::draw(seeds),
            Self::Maps => figure_9::draw(seeds.start),
            Self::Influence => influence::draw(seeds),
            Self::Walls => walls::draw(seeds.start),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_the_same_twice_and_their_files_have_names_of_their_own() {
        let mut files = std::collections::BTreeSet::new();
        for figure in &PaperFigure::ALL[..3] {
            let section = figure.draw(&(1..2)).unwrap();
            assert_eq!(section, figure.draw(&(1..2)).unwrap());
            assert_eq!(section.name, figure.name());
            for panel in section.panels() {
                assert!(panel.file.starts_with(figure.name()), "{}", panel.file);
                assert!(files.insert(panel.file.clone()), "{} twice", panel.file);
            }
        }
    }
}
