//! The laboratory around the filter: simulate, replay, map, score, draw.
//!
//! Everything here lives on a host and reads decoded events of the core's own types;
//! the filter itself is `amiro-ipf`, the same code that the board runs.

pub mod evaluation;
pub mod mapping;
mod run;
pub mod world;

pub use run::{CAPACITY, RunError, RunOutcome, run};
