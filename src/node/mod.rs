//! The portable program: inputs in, events out.
//!
//! [`Node::handle`] takes an [`Input`] and emits the [`Event`]s that follow from it. A
//! host, the flash image and a replay run the same node; they differ in where inputs
//! come from and where events go. The node reads no clock and no pin: every input has
//! its stamp.

mod batch;
mod config;
mod event;

mod handle;
mod input;
mod input_error;
pub mod odometry;
mod sample_window;
pub mod seed;
mod status;
mod step;
mod step_scheduler;
mod step_trigger;
#[cfg(test)]
mod tests;
mod walls;

pub use config::{Config, SampleSelection, Source, StepRule};
pub use event::{BATCH, Event, ParticleEvent, Particles, StepBegun, StepDone};
pub use handle::Node;
pub use input::Input;
pub use input_error::InputError;
pub use odometry::Odometry;
pub use sample_window::{MAX_SAMPLE_AGE_US, SampleWindow, WINDOW};
pub use seed::SeedSource;
pub use status::{NodeStatus, Obstacle};
pub use step_scheduler::{Scheduled, StepInput, StepScheduler};
pub use step_trigger::StepTrigger;
pub use walls::{TrackedWall, Walls};
