//! `cargo ipf experiments`: experiments of the papers on mapping, computed again.

mod servo_scan;
mod sharing;

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use sim_harness::experiments::{
    ExperimentCheck, ExperimentError, ExperimentReport, corridor, odometry_lap, specular_room,
    two_sensors,
};
use sim_harness::report::roc_chart;
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};
use servo_scan::ServoScanCommand;
use sharing::SharingCommand;

/// Arguments of `experiments`.
#[derive(Debug, Args)]
pub(super) struct ExperimentsCommand {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// Run the beam filter over a recorded servo sweep (Kleppe and Skavhaug 2013).
    ServoScan(ServoScanCommand),
    /// Run the beam filter on recorded drones in a known room, alone and sharing.
    Sharing(SharingCommand),
    /// Simulate a room with specular walls (Carvalho and Ventura 2013).
    #[command(name = "001")]
    SpecularRoom(Seeds),
    /// Simulate a corridor and the box around the robot (Ivanjko, Petrovic and Macek 2003).
    #[command(name = "002")]
    Corridor(Seeds),
    /// Simulate hallways for a laser and sonars, a layer each (Lee).
    #[command(name = "004")]
    TwoSensors(Seeds),
    /// Simulate a lap with wrong wheels and a compass (Ivanjko, Petrovic and Macek 2003).
    Odometry(Seeds),
    /// All that are simulated.
    All(Seeds),
}

/// Seeds of a simulated experiment.
#[derive(Debug, Args)]
struct Seeds {
    /// Seeds from A up to B, without B; figures are means over them.
    #[arg(long, default_value = "100..105", value_name = "A..B", value_parser = arguments::seeds, allow_hyphen_values = true)]
    seeds: Range<u64>,
    /// Where a sheet of the first seed's maps goes, `001.png` and so on, and the receiver
    /// operating characteristics of 001, `001_roc.png`; none if not given.
    #[arg(long, value_name = "DIR", value_parser = arguments::path())]
    out: Option<PathBuf>,
}

/// A simulated experiment.
type Simulated = (
    &'static str,
    fn(&Range<u64>) -> Result<ExperimentReport, ExperimentError>,
);

const SPECULAR_ROOM: Simulated = ("001.png", specular_room);
const CORRIDOR: Simulated = ("002.png", corridor);
const TWO_SENSORS: Simulated = ("004.png", two_sensors);
const ODOMETRY_LAP: Simulated = ("odometry.png", odometry_lap);

impl ExperimentsCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        let (seeds, simulated): (_, &[Simulated]) = match self.experiment {
            Experiment::ServoScan(command) => return command.run(),
            Experiment::Sharing(command) => return command.run(),
            Experiment::SpecularRoom(seeds) => (seeds, &[SPECULAR_ROOM]),
            Experiment::Corridor(seeds) => (seeds, &[CORRIDOR]),
            Experiment::TwoSensors(seeds) => (seeds, &[TWO_SENSORS]),
            Experiment::Odometry(seeds) => (seeds, &[ODOMETRY_LAP]),
            Experiment::All(seeds) => {
                (seeds, &[SPECULAR_ROOM, CORRIDOR, TWO_SENSORS, ODOMETRY_LAP])
            }
        };
        if let Some(out) = &seeds.out {
            arguments::check_folder("--out", out)?;
        }
        let mut holds = true;
        for (name, experiment) in simulated {
            let report = experiment(&seeds.seeds)?;
            if let (Some(out), Some(sheet)) = (&seeds.out, report.sheet()) {
                output::create_folder(out)?;
                sheet.save_png(&out.join(name))?;
                if !report.curves.is_empty() {
                    let chart = roc_chart("Room with specular walls, first seed", &report.curves);
                    chart.save_png(&out.join("001_roc.png"))?;
                }
            }
            let status = print_report(&report);
            holds &= matches!(status, ExitStatus::Good);
            console::print("");
        }
        Ok(if holds {
            ExitStatus::Good
        } else {
            ExitStatus::Failed
        })
    }
}

/// Prints a table, what was to be shown, and whether it holds.
fn print_report(report: &ExperimentReport) -> ExitStatus {
    for line in &report.lines {
        console::print(line);
    }
    print_checks(&report.checks)
}

/// Prints what was to be shown and whether it holds.
fn print_checks(checks: &[ExperimentCheck]) -> ExitStatus {
    for check in checks {
        console::print(check);
    }
    if checks.iter().all(|check| check.holds) {
        ExitStatus::Good
    } else {
        ExitStatus::Failed
    }
}
