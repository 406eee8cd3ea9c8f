//! How good a map is: scores against a known world, and walls where the world is unknown.
//!
//! One map has [`Scores`], the maps of a drive have [`DriveScores`].

mod drive_scores;
mod figure;
mod legs;
mod line;
mod openings;
mod scores;
mod truth;
mod walls;

pub use drive_scores::DriveScores;
pub use figure::Figure;
pub use line::Line;
pub use openings::OpeningScores;
pub use scores::Scores;
pub use truth::Truth;
pub use walls::{WALL_COVERED_M, WallReport, WallSide};
