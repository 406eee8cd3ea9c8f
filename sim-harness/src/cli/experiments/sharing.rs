//! `cargo ipf experiments sharing`: the beam filter on recorded drones in a known room.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use sim_harness::console;
use sim_harness::datasets::{DriveFile, PoseSource};
use sim_harness::experiments::{ExperimentCheck, Flight, FlightFigures, FlightForm, RUNS};
use sim_harness::rig::Rig;

use super::print_checks;
use crate::cli::{CommandResult, arguments};

/// Arguments of `experiments sharing`.
#[derive(Debug, Args)]
pub(super) struct SharingCommand {
    /// The recordings nano_swarm: a folder with `exp1`, `exp2` and the walls.
    drive: PathBuf,
    /// The drones: `rigs/nano_swarm.toml`.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Seeds of the filter from A up to B, without B; figures are means over them.
    #[arg(long, default_value = "100..103", value_name = "A..B", value_parser = arguments::seeds, allow_hyphen_values = true)]
    seeds: Range<u64>,
}

impl SharingCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        let rig = Rig::load(&self.rig)?;
        let mut flights = Vec::new();
        for run in RUNS {
            let drive = DriveFile {
                path: &self.drive.join(run.folder),
                rig: &rig,
                poses: PoseSource::MotionCapture,
                calibration: None,
                profile: None,
            };
            flights.push((run, Flight::read(&drive)?));
        }
        console::print(
            "                          nearest obstacle, cm          particles   walls found",
        );
        console::print(
            "form           drones     median     90 %  blind scans  at a wall   in sight  all",
        );
        let mut alone = Vec::new();
        let (mut four, mut shared) = (Vec::new(), Vec::new());
        for form in FlightForm::ALL {
            let sum = |only_shared: bool, is_shared: bool| {
                let flights = flights
                    .iter()
                    .filter(|(run, _)| run.is_shared || !only_shared);
                self.flown(flights.map(|(_, flight)| flight), form, is_shared)
            };
            for (name, figures, row) in [
                ("all", sum(false, false)?, &mut alone),
                ("four", sum(true, false)?, &mut four),
                ("sharing", sum(true, true)?, &mut shared),
            ] {
                console::print(format_args!(
                    "{:<13}  {name:<9}  {:>6.2}  {:>7.2}  {:>5} of {:<4}  {:>8.3}  {:>8.3}  {:.3}",
                    form.name(),
                    figures.nearest_error_cm(0.5),
                    figures.nearest_error_cm(0.9),
                    figures.blind,
                    figures.scans,
                    figures.precision(),
                    figures.recall(),
                    figures.recall_of_all(),
                ));
                row.push(figures);
            }
        }
        console::print(format_args!(
            "{} scans with sharing, {} particles taken over per scan",
            shared[0].scans,
            shared[0].imported / shared[0].scans.max(1) as u64
        ));
        Ok(print_checks(&checks(&alone[0], &four[0], &shared[0])))
    }

    fn flown<'a>(
        &self,
        flights: impl Iterator<Item = &'a Flight>,
        form: FlightForm,
        is_shared: bool,
    ) -> Result<FlightFigures, Box<dyn std::error::Error>> {
        let mut sum = FlightFigures::default();
        for flight in flights {
            for seed in self.seeds.clone() {
                sum = sum.plus(&flight.fly(form, is_shared, seed)?);
            }
        }
        Ok(sum)
    }
}

fn checks(
    alone: &FlightFigures,
    four: &FlightFigures,
    shared: &FlightFigures,
) -> Vec<ExperimentCheck> {
    let gain = shared.recall_of_all() - four.recall_of_all();
    let (median_cm, most_cm) = (alone.nearest_error_cm(0.5), alone.nearest_error_cm(0.9));
    vec![
        ExperimentCheck::at_most("nearest obstacle, median, cm", median_cm, 2.5),
        ExperimentCheck::at_most("nearest obstacle, 90 %, cm", most_cm, 7.0),
        ExperimentCheck::at_least("walls found", alone.recall(), 0.70),
        ExperimentCheck::at_least("walls found more by sharing", gain, 0.08),
        ExperimentCheck::at_least("particles at a wall, sharing", shared.precision(), 0.88),
    ]
}
