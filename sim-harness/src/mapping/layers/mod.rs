//! A layer of evidence per kind of sensor, and rules that fuse layers.
//!
//! Lee: each kind of sensor fills a grid of its own; the grids are fused cell by cell when
//! a map is made.

mod fusion;
mod layer;
mod mapper;

pub use fusion::{Fused, Fusion};
pub use layer::{LayerParameters, SensorLayer};
pub use mapper::LayerMapper;

#[cfg(test)]
mod tests;
