//! The command line of `cargo ipf`.

mod command_line;
mod console;
mod map;
mod no_steps;
mod options;
mod recorded_series;
