//! The maps of recorded drives along walls of known place: AMiRo's stepped series.
//!
//! `cargo run --release -p sim-harness --example recorded_walls -- FOLDER [JSON]` prints a
//! report, and writes its numbers to a JSON file if one is named.

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use sim_harness::evaluation::recorded::recorded_walls;
use sim_harness::{console, output};

/// Judges the maps of recorded drives along walls of known place.
#[derive(Debug, Parser)]
struct Arguments {
    /// The folder of the series.
    folder: PathBuf,
    /// Where the numbers go.
    json: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let report = recorded_walls(&arguments.folder)?;
    if let Some(path) = &arguments.json {
        let json = serde_json::to_string_pretty(&report)?;
        output::write(path, format!("{json}\n").as_bytes())?;
    }
    console::print_text(report);
    Ok(())
}
