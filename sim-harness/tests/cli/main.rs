//! The command line of `cargo ipf`.

mod command_line;
mod console;
mod map;
mod options;
