//! The table of mapping methods: one constant of [`Method`] per method.

mod evidence_methods;
mod filters;
mod inverse_models;
mod layer_methods;
mod likelihood_methods;
mod method;
mod near_methods;
mod particles;
mod sensor_choice;
mod setup;
mod wall_methods;

pub use method::{Method, UnknownMethod};
pub use sensor_choice::{MissingSensors, SensorChoice};
pub use setup::Setup;
