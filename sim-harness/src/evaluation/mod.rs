//! How good a map is: scores against a known world, and walls where the world is unknown.
//!
//! One map has [`Scores`], the maps of a drive have [`DriveScores`], a [`Comparison`]
//! of methods over scenarios and seeds has [`Trial`]s.

mod comparison;
mod drive_scores;
mod figure;
mod legs;
mod line;
mod method;
mod openings;
mod record;
mod scores;
mod standard;
mod truth;
mod walls;

pub use comparison::{Comparison, ComparisonError, Trial};
pub use drive_scores::DriveScores;
pub use figure::Figure;
pub use line::Line;
pub use method::{Method, UnknownMethod};
pub use openings::OpeningScores;
pub use record::{Record, json};
pub use scores::Scores;
pub use standard::{STANDARD, standard};
pub use truth::Truth;
pub use walls::{WALL_COVERED_M, WallReport, WallSide};
