//! Simulated worlds: scenario files, drives through them, and what the sensors read there.

mod amiro_odometry;
mod bounded;
mod drift;
mod drive;
mod dropout;
mod eye;
mod feasibility;
mod leg;
mod odometry;
mod opening;
mod optics;
mod option_words;
mod options;
mod scenario;
mod sensing;
mod shape;
mod simulate;
mod wheel_errors;

pub use crate::geometry::{Rectangle, Turn, Vector};
pub use amiro_odometry::{FRAME_PERIOD_US, UPDATE_PERIOD_US};
pub use drift::Drift;
pub use drive::{Drive, SAMPLE_PERIOD_US};
pub use dropout::Dropout;
pub use eye::{Eye, first_surface};
pub use feasibility::Allowance;
pub use leg::{Leg, TURN_DEG_PER_S};
pub use odometry::Odometry;
pub use opening::Opening;
pub use optics::Physics;
pub use options::{Options, OptionsError};
pub use scenario::{Scenario, ScenarioError};
pub use sensing::Sensing;
pub use shape::Shape;
pub use simulate::{Simulation, simulate, simulate_with};
pub use wheel_errors::{WheelErrors, WheelWalk};
