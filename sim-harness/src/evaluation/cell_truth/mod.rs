//! Which cells are truly occupied or free, and how well a map of a recorded drive fits them.

mod cell_scores;
mod drive_survey;
mod from_scanner;
mod from_shapes;
mod roc;
mod scored_cells;
mod true_cells;
mod wall_cells;

pub use cell_scores::{CELL_SCORES_IN_WORDS, CellScores};
pub use drive_survey::{DriveSurvey, DriveTruth};
pub use from_scanner::ScannerTruth;
pub use from_shapes::truth_of_shapes;
pub use roc::receiver_operating_characteristic;
pub use scored_cells::ScoredCells;
pub use true_cells::{TrueCell, TrueCells};
