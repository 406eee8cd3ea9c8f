//! The table of mapping methods: one constant of [`Method`] per method.

mod filters;
mod inverse_models;
mod method;
mod particles;
mod sensor_choice;
mod setup;
mod wall_methods;

pub use method::{Method, UnknownMethod};
pub use sensor_choice::{MissingSensors, SensorChoice};
pub use setup::Setup;
