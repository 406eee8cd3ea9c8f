//! The laboratory around the filter: simulate, replay, map, score, draw.
//!
//! Everything here lives on a host and reads decoded events of the core's own types;
//! the filter itself is `amiro-ipf`, the same code that the board runs.
//!
//! A datum's way: a recording ([`log`]) or a simulated drive ([`world`]) gives inputs;
//! the node turns them into events ([`run`]) or a board does ([`device`]); a mapper
//! counts events into a grid ([`mapping`]); the grid is scored ([`evaluation`]), drawn
//! and written ([`report`], [`output`]). The law that all of it rests on is fitted to
//! measured counts ([`calibration`]). The `ipf` program's commands join these.
//!
//! Drives of other robots take another way: a rig file says which sensors sit where
//! ([`rig`]), a recording is read into records ([`datasets`], [`drive`]), and the pipeline
//! ([`pipeline`]) maps what the sensors see ([`sensors`], [`mapping`]).
//!
//! Below the readings lies the robot's wiring: [`bus`] has the parts of its two I2C
//! buses as they behave on the wire, faults included, for the drivers to run against.
//! A whole simulated robot ([`robot`]) drives through a world with them: its own senses
//! give the inputs. What breaks in it, on the line or in a recording is said in the words
//! of [`faults`]. Whatever the program prints goes through [`console`].

mod bounded;
pub mod bus;
pub mod calibration;
pub mod console;
pub mod datasets;
pub mod device;
pub mod drive;
mod escape;
pub mod evaluation;
pub mod faults;
mod filter_config;
pub mod geometry;
pub mod lattice;
pub mod log;
pub mod mapping;
pub mod output;
pub mod pipeline;
mod quantity;
pub mod report;
pub mod rig;
pub mod robot;
mod run;
mod run_record;
pub mod sensors;
pub mod spool;

mod ticks;
pub mod world;

pub use run::{CAPACITY, RunError, RunOutcome, check, check_capacity, run, run_streamed};
pub use run_record::{RunRecord, RunStatistics};
pub use ticks::{TICK_PERIOD_US, Ticked, with_ticks};
