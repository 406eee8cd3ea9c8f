//! Worlds: scenario files, simulated drives through them and the sensors' readings there,
//! and what is known of the world around a recorded drive.

mod amiro_odometry;
mod bounded;
mod drift;
mod drive;
mod dropout;
mod feasibility;
mod leg;
mod odometry;
mod opening;
mod optics;
mod option_words;
mod options;
mod scenario;
mod scenario_error;
mod scenario_file;
mod scenario_limits;
mod sensing;
mod sensor_pose;
mod shape;
mod simulate;
mod standard;
mod true_world;
mod wheel_errors;

pub use crate::geometry::{Rectangle, Turn, Vector};
pub use amiro_odometry::{FRAME_PERIOD_US, UPDATE_PERIOD_US};
pub(crate) use bounded::{Bounded, Coordinate, Reflectivity};
pub use drift::Drift;
pub use drive::{Drive, SAMPLE_PERIOD_US};
pub use dropout::Dropout;
pub use feasibility::Allowance;
pub use leg::{Leg, TURN_DEG_PER_S};
pub use odometry::OdometryModel;
pub use opening::Opening;
pub use optics::Physics;
#[cfg(test)]
pub(crate) use optics::signal_of;
pub use options::{Options, OptionsError};
pub use scenario::Scenario;
pub use scenario_error::ScenarioError;
pub use sensing::Sensing;
pub use sensor_pose::{SensorPose, first_surface};
pub use shape::Shape;
pub(crate) use shape::{BoxTable, CylinderTable};
pub use simulate::{Simulation, simulate, simulate_with};
pub use standard::{STANDARD, standard, standard_scenarios};
pub use true_world::{TrueWorld, WallFileError};
pub use wheel_errors::{WheelErrors, WheelWalk};
