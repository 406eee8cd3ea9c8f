//! A drive as records, for any robot: poses, scans and outcomes in SI units.

mod filter_records;
mod keyframes;
mod known_walls;
mod no_steps;
mod record;
mod replayed_config;
mod ring_calibration;
mod step_records;

pub use filter_records::FilterRecords;
pub(crate) use filter_records::scan_records;
pub use keyframes::Keyframes;
pub use known_walls::{KnownWall, KnownWalls, WallFate, WallState, WallStep};
pub use no_steps::{InputCheck, NoSteps};
pub use record::{PointOutcome, RangeScan, Record, Return};
pub use replayed_config::replayed_config;
pub use ring_calibration::RingCalibration;
pub use step_records::StepRecords;
