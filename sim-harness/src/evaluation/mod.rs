//! How good a map is: scores against a known world, and walls where the world is unknown.
//!
//! One map has [`Scores`], the maps of a drive have [`DriveScores`], a [`MethodComparison`]
//! of methods over scenarios and seeds has [`Trial`]s; [`Claim`]s are held against these.

mod assessment;
mod block_gain;
pub mod cell_truth;
mod chosen_scenarios;
mod claim;
mod claims;
mod comparison;
pub mod drive_maps;
mod drive_scores;
mod event_scores;
mod legs;
mod line;
mod mapped_sides;
mod mean_std;
mod metric;
mod nearest_segment;
mod node_run;
mod number;
mod odometry_loss;
mod openings;
mod record;
pub mod recorded;
mod robustness;
mod scores;
mod sensor_faults;
mod stamps;
mod surface_offset;
mod trials;
mod truth;
mod wall_rows;
mod walls;

pub use assessment::Assessment;
pub use block_gain::{BlockGainError, block_gain};
pub use chosen_scenarios::{ScenarioChoiceError, chosen_scenarios};
pub use claim::{Claim, ClaimVerdict, Over, Relation};
pub use claims::Claims;
pub use comparison::{ComparisonError, MethodComparison, Trial};
pub use drive_scores::{DriveJudge, DriveScores};
pub use event_scores::{event_scores, recorded_scenario};
pub use line::Line;
pub use mean_std::MeanStd;
pub use metric::Metric;
pub use node_run::{NodeRun, map};
pub use number::Number;
pub use odometry_loss::OdometryLoss;
pub use openings::OpeningScores;
pub use record::{ScoreRecord, TrialRecord, json, json_lines};
pub use robustness::{Mismatch, RobustnessRow, RobustnessTrials};
pub use scores::{SCORES_IN_WORDS, Scores};
pub use sensor_faults::{SensorBreak, SensorFaultRow, SensorFaultTrials};
pub use stamps::{StampRow, StampTrials};
pub use surface_offset::SurfaceOffset;
pub use trials::Trials;
pub use truth::Truth;
pub use wall_rows::{WallSideRow, WallSideSettings};
pub use walls::{MappedPath, WALL_COVERED_M, WallReport, WallSide};
