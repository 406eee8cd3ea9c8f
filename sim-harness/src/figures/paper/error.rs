//! Why a figure could not be drawn.

use crate::RunError;
use crate::world::ScenarioError;

/// Why a figure could not be drawn; none of these happens with the files that ship.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A scenario of the program's own is none.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The filter refused its configuration.
    #[error(transparent)]
    Run(#[from] RunError),
}
