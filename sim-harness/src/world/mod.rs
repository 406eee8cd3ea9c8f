//! Simulated worlds: scenario files, drives through them, and what the sensors read there.

mod bounded;
mod drive;
mod eye;
mod leg;
mod opening;
mod optics;
mod scenario;
mod sensing;
mod shape;
mod simulate;
mod vector;

pub use drive::{Drive, SAMPLE_PERIOD_US};
pub use eye::{Eye, first_surface};
pub use leg::{Leg, TURN_DEG_PER_S};
pub use opening::{Opening, Rectangle};
pub use scenario::{Scenario, ScenarioError};
pub use sensing::Sensing;
pub use shape::Shape;
pub use simulate::{Simulation, simulate};
pub use vector::{Turn, Vector};
