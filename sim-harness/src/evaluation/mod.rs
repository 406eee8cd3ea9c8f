//! How good a map is: scores against a known world, and walls where the world is unknown.
//!
//! One map has [`Scores`], the maps of a drive have [`DriveScores`], a [`Comparison`]
//! of methods over scenarios and seeds has [`Trial`]s; [`Claim`]s are held against these.

mod bounds;
mod claim;
mod comparison;
mod drive_scores;
mod figure;
mod legs;
mod line;
mod mapped_sides;
mod measure;
mod nearest_segment;
mod openings;
mod paper_claims;
mod record;
pub mod recorded;
mod scores;
mod spread;
mod standard;
mod trials;
mod truth;
mod walls;

pub use bounds::{Bounds, PaperBounds, PlusBounds, thresholds};
pub use claim::{Claim, Over, Relation, Verdict};
pub use comparison::{Comparison, ComparisonError, Trial};
pub use drive_scores::{DriveJudge, DriveScores};
pub use figure::Figure;
pub use line::Line;
pub use measure::Measure;
pub use openings::OpeningScores;
pub use paper_claims::paper_claims;
pub use record::{Record, ScoreRecord, json};
pub use scores::{SCORES_IN_WORDS, Scores};
pub use spread::Spread;
pub use standard::{STANDARD, standard};
pub use trials::Trials;
pub use truth::Truth;
pub use walls::{Surroundings, WALL_COVERED_M, WallReport, WallSide};
