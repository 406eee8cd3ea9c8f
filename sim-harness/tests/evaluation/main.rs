//! Simulated worlds, calibration, scores and comparisons of methods.

#[path = "../common/mod.rs"]
mod common;

mod calibration;
mod evaluation;
mod sensor_gains;
mod worlds;
