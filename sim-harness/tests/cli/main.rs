//! The command line of `cargo ipf`.

#[path = "../common/mod.rs"]
mod common;

mod command_line;
mod console;
mod experiments;
mod literature;
mod map;
mod map_hostile;
mod no_steps;
mod options;
mod recorded_series;
