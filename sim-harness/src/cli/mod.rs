//! The commands of the program, one a file.

mod arguments;
mod calibrate;
mod calibrate_drives;
mod cell_limit;
mod comparison_arguments;
mod connect;
mod demo;
mod differences;
mod evaluate;
mod evaluate_pairs;
mod evaluate_recorded;
mod evaluate_report;
mod evaluate_tables;
mod exit_code;
mod experiments;
mod figures;
mod footprint;
mod image;
mod keyframe_arguments;
mod map;
mod map_arguments;
mod map_drives;
mod map_report;
mod odometry;
mod offsets;
mod overrides;
mod progress;
mod record;
mod record_log;
mod replay;
mod replay_files;
mod replay_report;
mod replay_target;
mod simulate;
mod simulate_report;

use std::error::Error;
use std::process::ExitCode;

use clap::{ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use sim_harness::console;

/// The laboratory of the inverse particle filter.
#[derive(Debug, Parser)]
#[command(name = "ipf", bin_name = "cargo ipf", version, about, after_help = exit_code::EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    command: IpfCommand,
}

#[derive(Debug, Subcommand)]
enum IpfCommand {
    /// Simulate the drive past a block, map it with both profiles, print the scores.
    Demo(demo::Demo),
    /// Draw the paper's figures from simulated drives, and a page that shows them.
    Figures(figures::Figures),
    /// Run a recorded drive through the filter, on this host or on a board, and map it.
    Replay(replay::Replay),
    /// Map a recorded drive: an AMiRo's, or any robot's with sonars or a laser.
    Map(map_arguments::MapCommand),
    /// Record a robot that reads its own sensors and odometry.
    Record(record::RecordCommand),
    /// Have a robot measure its sensors' offsets, with nothing near it.
    Offsets(offsets::OffsetsCommand),
    /// Drive a simulated robot through a scenario and write the recording.
    Simulate(simulate::Simulate),
    /// Compare the filters with the inverse sensor model over scenarios and seeds.
    Evaluate(evaluate::Evaluate),
    /// Fit the sensors' law to a table of range, angle and counts, or their gains to drives.
    Calibrate(calibrate::Calibrate),
    /// Compare the end errors of odometry: raw, calibrated, and filtered with a compass.
    Odometry(odometry::OdometryCommand),
    /// Compute experiments of the papers on mapping again, and check what they report.
    Experiments(experiments::ExperimentsCommand),
    /// Build the flash image, check it and print its sizes.
    Image(image::ImageCommand),
}

/// How a command ended.
enum ExitStatus {
    /// As asked.
    Good,
    /// What was to be shown does not hold: exit 1.
    Failed,
    /// A replay is equal, but particle messages of the recording were lost: exit 4.
    ParticlesLost,
    /// Input was refused that should not have been: exit 2.
    Refused,
}

/// What a command gives back; [`exit_code`] has the codes of all of them.
type CommandResult = Result<ExitStatus, Box<dyn Error>>;

/// Runs the command line.
pub(crate) fn main() -> ExitCode {
    exit_code::of(match parse() {
        Ok(arguments) => arguments.command.run(),
        Err(error) => Ok(print_of_parser(&error)),
    })
}

/// Reads the arguments; an option takes a negative number as its value, so that what is
/// wrong with it is its range.
fn parse() -> Result<Arguments, clap::Error> {
    let mut command = Arguments::command().mut_subcommands(|command| {
        command.mut_args(|argument| {
            let is_option = !argument.is_positional();
            let takes = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
            argument.allow_negative_numbers(is_option && takes)
        })
    });
    let mut matches = command.try_get_matches_from_mut(std::env::args_os())?;
    let read = Arguments::from_arg_matches_mut(&mut matches);
    read.map_err(|error| error.format(&mut command))
}

/// Prints the help or version that was asked for, or what is wrong with the arguments.
fn print_of_parser(error: &clap::Error) -> ExitStatus {
    let text = error.render().to_string();
    let text = text.strip_suffix('\n').unwrap_or(&text);
    if error.use_stderr() {
        console::warn_text(text);
        ExitStatus::Refused
    } else {
        console::print_text(text);
        ExitStatus::Good
    }
}

impl IpfCommand {
    fn run(self) -> CommandResult {
        match self {
            Self::Demo(demo) => demo.run(),
            Self::Figures(figures) => figures.run(),
            Self::Replay(replay) => replay.run(),
            Self::Map(map) => map.run(),
            Self::Record(record) => record.run(),
            Self::Offsets(offsets) => offsets.run(),
            Self::Simulate(simulate) => simulate.run(),
            Self::Evaluate(evaluate) => evaluate.run(),
            Self::Calibrate(calibrate) => calibrate.run(),
            Self::Odometry(odometry) => odometry.run(),
            Self::Experiments(experiments) => experiments.run(),
            Self::Image(image) => image.run(),
        }
    }
}
