//! `cargo ipf experiments servo-scan`: the beam filter over a recorded servo sweep.

use std::path::PathBuf;

use clap::Args;
use sim_harness::datasets::{DriveFile, PoseSource, SharpIr};
use sim_harness::experiments::{MaximumRange, ServoScanRun, ServoScanStudy, ServoSweep, sweeps};
use sim_harness::report::{Picture, beside, servo_scan_picture};
use sim_harness::rig::Rig;
use sim_harness::{console, output};

use super::print_report;
use crate::cli::{CommandResult, arguments};

/// Arguments of `experiments servo-scan`.
#[derive(Debug, Args)]
pub(super) struct ServoScanCommand {
    /// The sweep: `test2d.csv` of DIY-3D-Scanner, or `data.txt` of 3dscanner.
    drive: PathBuf,
    /// The sensor: a rig with one scanner of one beam; `rigs/sharp_ir.toml` if not given.
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// Seed of the filter.
    #[arg(long, default_value_t = 100, value_parser = arguments::seed)]
    seed: u64,
    /// Where `particles.csv` and `particles.png` go.
    #[arg(long, default_value = "out/servo-scan", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
}

impl ServoScanCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let rig = match &self.rig {
            Some(path) => Rig::load(path)?,
            None => Rig::parse(
                "sharp_ir.toml",
                include_str!("../../../../rigs/sharp_ir.toml"),
            )?,
        };
        let files = ["particles.csv", "particles.png"].map(|name| self.out.join(name));
        let inputs = [&self.drive].into_iter().chain(&self.rig);
        output::check(&files, &inputs.map(PathBuf::as_path).collect::<Vec<_>>())?;
        let drive = DriveFile {
            path: &self.drive,
            rig: &rig,
            poses: PoseSource::Odometry,
            calibration: None,
            profile: None,
        };
        let (all, rows) = sweeps(&SharpIr, &drive)?;
        if rows.refused.count > 0 {
            console::warn_text(&rows.refused);
        }
        let study = ServoScanStudy::new(&all, self.seed)?;
        let study = study.ok_or("no sweep has more than 10 echoes")?;
        let pictures = study.shown.iter();
        let pictures: Vec<Picture> = pictures
            .map(|(maximum, run)| picture(*maximum, run, &study.sweep))
            .collect();
        output::create_folder(&self.out)?;
        output::write(&files[0], study.csv.as_bytes())?;
        beside(&pictures).save_png(&files[1])?;
        let status = print_report(&study.report);
        let [csv, png] = files.map(|file| file.display().to_string());
        console::print(format_args!("One sweep after all passes: {csv}, {png}"));
        Ok(status)
    }
}

fn picture(maximum: MaximumRange, run: &ServoScanRun, sweep: &ServoSweep) -> Picture {
    let mut classes: [Vec<(f64, f64)>; 3] = Default::default();
    for particle in &run.particles {
        let class = usize::from(!particle.is_low()) + usize::from(particle.is_high());
        classes[class].push((particle.place.x, particle.place.y));
    }
    let title = match maximum {
        MaximumRange::Clears => "No echo clears (corrected)",
        MaximumRange::Obstacle => "No echo is an obstacle (printed)",
    };
    let ends = sweep.ends().map(|end| (end.x, end.y)).collect();
    servo_scan_picture(title, run.radius_m, classes, ends)
}
