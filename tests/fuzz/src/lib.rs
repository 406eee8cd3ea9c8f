//! What must hold whatever comes in; a check panics where it does not.
//!
//! Each module is one fuzz target: `check` takes any bytes. The tests of `sim-harness/tests/hostile`
//! include the same modules, so that a machine without a nightly compiler runs them too.

pub mod framing;
pub mod recordings;
pub mod scenarios;
pub mod seeds;
pub mod senses;
pub mod terminal;
pub mod wire;
pub mod words;
