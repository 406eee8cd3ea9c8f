//! The command line of `cargo ipf`.

mod command_line;
mod console;
mod options;
mod recorded_series;
