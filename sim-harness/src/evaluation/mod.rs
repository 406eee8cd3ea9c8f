//! How good a map is: scores against a known world, and walls where the world is unknown.

mod legs;
mod line;
pub mod recorded;
mod scores;
mod truth;
mod walls;

pub use line::Line;
pub use scores::Scores;
pub use truth::Truth;
pub use walls::{WALL_COVERED_M, WallReport, WallSide};
