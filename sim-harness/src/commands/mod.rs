//! The commands of the program, one a file.

mod ailments;
mod calibrate;
mod demo;
mod evaluate;
mod evaluate_report;
mod evaluate_robot;
mod figures;
mod footprint;
mod image;
mod offsets;
mod record;
mod replay;
mod report;
mod settings;
mod simulate;
mod standstill;
mod target;

use std::error::Error;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use sim_harness::link::{LinkError, RecordError};

/// The laboratory of the inverse particle filter.
#[derive(Debug, Parser)]
#[command(name = "ipf", bin_name = "cargo ipf", version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate the drive past a block, map it with both profiles, print the scores.
    Demo(demo::Demo),
    /// Draw the paper's figures from simulated drives, and a page that shows them.
    Figures(figures::Figures),
    /// Run a recorded drive through the filter, on this host or on a board, and map it.
    Replay(replay::Replay),
    /// Record a robot that reads its own sensors and odometry.
    Record(record::Record),
    /// Have a robot measure its sensors' offsets, with nothing near it.
    Offsets(offsets::Offsets),
    /// Drive a simulated robot through a scenario and write the recording.
    Simulate(simulate::Simulate),
    /// Compare the filters with the inverse sensor model over scenarios and seeds.
    Evaluate(evaluate::Evaluate),
    /// Fit the sensors' law to a table of range, angle and counts.
    Calibrate(calibrate::Calibrate),
    /// Build the flash image, check it and print its sizes.
    Image(image::Image),
}

/// How a command ended.
enum Ending {
    /// As asked.
    Good,
    /// What was to be shown does not hold: exit 1.
    Failed,
    /// Input was refused that should not have been: exit 2.
    Refused,
}

/// What a command gives back; an error is printed, exit 2, or 3 for a board that speaks
/// another version of the protocol.
type Outcome = Result<Ending, Box<dyn Error>>;

/// Runs the command line.
pub(crate) fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Demo(demo) => demo.run(),
        Command::Figures(figures) => figures.run(),
        Command::Replay(replay) => replay.run(),
        Command::Record(record) => record.run(),
        Command::Offsets(offsets) => offsets.run(),
        Command::Simulate(simulate) => simulate.run(),
        Command::Evaluate(evaluate) => evaluate.run(),
        Command::Calibrate(calibrate) => calibrate.run(),
        Command::Image(image) => image.run(),
    };
    match outcome {
        Ok(Ending::Good) => ExitCode::SUCCESS,
        Ok(Ending::Failed) => ExitCode::from(1),
        Ok(Ending::Refused) => ExitCode::from(2),
        Err(error) => {
            eprintln!("ipf: {error}");
            // A board of another version is no mistake of the caller's.
            let is_version = matches!(link_error(&*error), Some(LinkError::Version { .. }));
            ExitCode::from(if is_version { 3 } else { 2 })
        }
    }
}

/// What is wrong with the link, whoever found it.
fn link_error<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a LinkError> {
    match error.downcast_ref() {
        Some(RecordError::Link(error)) => Some(error),
        _ => error.downcast_ref(),
    }
}
