//! `cargo ipf map`: a recorded drive of any robot, mapped from its ranges.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use sim_harness::datasets::{DATASETS, PoseSource, recognise};
use sim_harness::drive::Keyframes;
use sim_harness::mapping::{Mapper, Method, NoEcho, Setup};
use sim_harness::pipeline::{self, DriveOptions};
use sim_harness::report::{DRIVE_FILES, DriveMapSummary};
use sim_harness::rig::Rig;
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, map_report};

/// Arguments of `map`.
#[derive(Debug, Args)]
pub(super) struct MapCommand {
    /// The recorded drive: a folder with `od.txt` and `sonar.txt`, perhaps `laser.txt`.
    drive: PathBuf,
    /// The robot: a rig file, as in `rigs/`.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// The method: `ism` or `ism-decay`.
    #[arg(long, default_value = "ism", value_name = "METHOD")]
    method: String,
    /// Only sensors whose names begin so, as in `sonar`; all of the rig if not given.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    sensors: Vec<String>,
    /// Use the poses that were matched to the recording, not those of the odometry.
    #[arg(long)]
    matched: bool,
    /// Count cells before the limit of a return without an echo as free.
    #[arg(long)]
    no_echo_is_free: bool,
    /// Side of a cell.
    #[arg(long, default_value_t = 100, value_name = "MM", value_parser = clap::value_parser!(u16).range(1..=1000))]
    cell_mm: u16,
    /// Map all poses, not only those 0.10 m or 5 degrees from the last one.
    #[arg(long)]
    all_poses: bool,
    /// Where map and summary go.
    #[arg(long, default_value = "out/map", value_name = "DIR")]
    out: PathBuf,
}

impl MapCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        let rig = Rig::load(&self.rig)?;
        let method = self.method()?;
        for name in &self.sensors {
            if !rig.mounts.iter().any(|mount| mount.name.starts_with(name)) {
                return Err(format!("--sensors {name}: rig {} has none", rig.name).into());
            }
        }
        let formats = DATASETS.map(|dataset| dataset.name()).join(", ");
        let dataset = recognise(&self.drive)
            .ok_or_else(|| format!("{}: of no known format ({formats})", self.drive.display()))?;
        let outputs = DRIVE_FILES.map(|name| self.out.join(name));
        output::check(&outputs, &[&self.rig, &self.drive])?;
        std::fs::create_dir_all(&self.out)
            .map_err(|error| format!("--out {}: {error}", self.out.display()))?;
        let cell_m = 1e-3 * f64::from(self.cell_mm);
        let mut mapper = method.mapper(&Setup {
            no_echo: self.no_echo_is_free.then_some(NoEcho::Free),
            ..Setup::new(&rig, cell_m)
        });
        let options = self.options();
        let run = pipeline::run(
            |take| pipeline::dataset_records(dataset, &self.drive, &rig, &options, take),
            &mut mapper,
            &mut |_, _| {},
        )?;

        let map = mapper.map();
        let poses = if self.matched { "matched" } else { "odometry" };
        let words = [dataset.name(), method.name, poses];
        let summary = DriveMapSummary::of(words, &rig, &run, &map);
        summary.save(&self.out, &map, &rig, &run)?;
        if run.refused.count > 0 {
            console::warn_text(&run.refused);
        }
        map_report::figures(&summary);
        Ok(ExitStatus::Good)
    }

    /// The method of this name, if records of ranges are enough for it.
    fn method(&self) -> Result<Method, String> {
        let is_of_ranges = |method: &Method| method.profile.is_none();
        let method = Method::from_str(&self.method).ok().filter(is_of_ranges);
        method.ok_or_else(|| {
            let known = Method::ALL.into_iter().filter(is_of_ranges);
            let known: Vec<_> = known.map(|method| method.name).collect();
            format!("--method {}: {} are known", self.method, known.join(", "))
        })
    }

    fn options(&self) -> DriveOptions {
        let (distance_m, turn_deg) = if self.all_poses {
            (0.0, 0.0)
        } else {
            (0.10, 5.0)
        };
        DriveOptions {
            poses: if self.matched {
                PoseSource::Matched
            } else {
                PoseSource::Odometry
            },
            keyframes: Keyframes::new(distance_m, f64::to_radians(turn_deg)),
            mounts: self.sensors.clone(),
        }
    }
}
