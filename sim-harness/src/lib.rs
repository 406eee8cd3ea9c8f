//! The laboratory around the filter: simulate, replay, map, score, draw.
//!
//! Everything here runs on a host and reads decoded events of the core's own types; the
//! filter itself is `amiro-ipf`, the same code that the board runs.
//!
//! The data flow: a recording ([`log`]) or a simulated drive ([`world`]) gives inputs;
//! the node turns them into events ([`run`]) or a board does ([`device`]); a mapper
//! counts events into a grid ([`mapping`]); the grid is scored ([`evaluation`]), drawn
//! and written ([`report`], [`output`]). The photometric law is fitted to measured counts
//! ([`calibration`]). The commands of the `ipf` program combine these.
//!
//! Drives of other robots have another path: a rig file lists the sensors
//! and their poses ([`rig`]), a recording is read into records ([`datasets`], [`drive`]),
//! and the pipeline ([`pipeline`]) maps the sensors' returns ([`sensors`], [`mapping`]).
//! The experiments of the papers on mapping are computed again in [`experiments`].
//!
//! [`bus`] models the parts of the robot's two I2C buses as they behave on the wire, faults
//! included; the drivers run against them. A whole simulated robot ([`robot`]) drives
//! through a world with these parts, and its own acquisition gives the inputs. [`faults`]
//! has the words for faults of the robot, of the line and of recorded inputs. All output of
//! the program goes through [`console`].

mod bounded;
pub mod bus;
pub mod calibration;
pub mod console;
pub mod datasets;
pub mod device;
pub mod drive;
mod escape;
pub mod evaluation;
pub mod experiments;
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
