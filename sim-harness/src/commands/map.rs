//! `cargo ipf map`: a recorded drive of any robot, mapped from its ranges.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use serde::Serialize;
use sim_harness::datasets::{DATASETS, PoseSource, recognise};
use sim_harness::drive::Keyframes;
use sim_harness::mapping::{MAX_CELLS, Mapper, Method, NoEcho, Occupancy, Setup};
use sim_harness::pipeline::{self, DriveFigures, DriveOptions};
use sim_harness::report::{MapPicture, MapServerPair};
use sim_harness::rig::Rig;
use sim_harness::{console, output};

use super::{Ending, Outcome};

/// The files of a mapped drive.
const FILES: [&str; 4] = ["map.png", "map.pgm", "map.yaml", "summary.json"];

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

/// `summary.json`: nothing in it depends on when or where it was made.
#[derive(Serialize)]
struct Summary<'a> {
    format: &'a str,
    rig: &'a str,
    method: &'a str,
    poses: &'a str,
    cell_m: f64,
    figures: &'a DriveFigures,
    cells_occupied: u64,
    cells_free: u64,
    cells_refused: u64,
}

impl MapCommand {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
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
        let outputs = FILES.map(|name| self.out.join(name));
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
        let count = |wanted| map.count(wanted) as u64;
        let summary = Summary {
            format: dataset.name(),
            rig: &rig.name,
            method: method.name,
            poses: if self.matched { "matched" } else { "odometry" },
            cell_m,
            figures: &run.figures,
            cells_occupied: count(Occupancy::Occupied),
            cells_free: count(Occupancy::Free),
            cells_refused: map.refused(),
        };
        let title = format!("{}, {}", rig.name, method.name);
        let picture = MapPicture {
            title: Some(&title),
            path: &run.path,
            robot_radius_m: Some(rig.radius_m),
            ..MapPicture::default()
        };
        picture.render(&map).save_png(&self.out.join("map.png"))?;
        MapServerPair::new(&map).save(&self.out)?;
        let json = format!("{}\n", serde_json::to_string_pretty(&summary)?);
        output::write(&self.out.join("summary.json"), json.as_bytes())?;
        if run.refused.count > 0 {
            console::warn_text(&run.refused);
        }
        report(&summary);
        Ok(Ending::Good)
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

fn report(summary: &Summary<'_>) {
    let figures = summary.figures;
    console::print(format_args!(
        "{} of {} poses over {:.1} m; {} returns with an echo, {} without, {} invalid",
        figures.keyframes,
        figures.poses,
        figures.path_m,
        figures.echoes,
        figures.no_echoes,
        figures.invalid
    ));
    console::print(format_args!(
        "{} occupied and {} free cells of {:.0} mm",
        summary.cells_occupied,
        summary.cells_free,
        1e3 * summary.cell_m
    ));
    if summary.cells_refused > 0 {
        console::print(format_args!(
            "THE MAP IS CUT: it holds at most {MAX_CELLS} cells, {} updates of cells were refused",
            summary.cells_refused
        ));
    }
}
