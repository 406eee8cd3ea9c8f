//! `cargo ipf experiments servo-scan`: the beam filter over a recorded servo sweep.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use sim_harness::datasets::{DriveFile, PoseSource, SharpIr};
use sim_harness::experiments::{
    ExperimentCheck, MaximumRange, ServoParticle, ServoScan, ServoScanFigures, ServoScanRun, Sweep,
    sweeps,
};
use sim_harness::report::{beside, servo_scan_picture};
use sim_harness::rig::Rig;
use sim_harness::{console, output};

use super::experiments::print_checks;
use super::{CommandResult, arguments};

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

/// Rows of a list with fewer echoes are passed over.
const LEAST_ECHOES: usize = 11;

const PARTICLES: [usize; 2] = [10_000, 1_000];
const PASSES: [usize; 2] = [1, 3];

impl ServoScanCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let rig = match &self.rig {
            Some(path) => Rig::load(path)?,
            None => Rig::parse("sharp_ir.toml", include_str!("../../../rigs/sharp_ir.toml"))?,
        };
        let files = ["particles.csv", "particles.png"].map(|name| self.out.join(name));
        output::check(&files, &[&self.drive])?;
        let drive = DriveFile {
            path: &self.drive,
            rig: &rig,
            poses: PoseSource::Odometry,
            calibration: None,
        };
        let (mut all, rows) = sweeps(&SharpIr, &drive)?;
        if rows.refused.count > 0 {
            console::warn_text(&rows.refused);
        }
        let found = all.len();
        all.retain(|sweep| sweep.echoes() >= LEAST_ECHOES);
        let limit_m = all.iter().filter_map(Sweep::limit_m).reduce(f64::max);
        // One with echoes and with readings without, where there are such.
        let both = |sweep: &&Sweep| sweep.echoes().min(sweep.readings.len() - sweep.echoes());
        let shown = all.iter().max_by_key(both);
        let shown = shown.ok_or("no sweep has more than 10 echoes")?;
        console::print(format_args!(
            "{} of {found} sweeps have more than 10 echoes; seed {}; high particles and ring \
             per sweep",
            all.len(),
            self.seed
        ));
        console::print(TABLE_HEAD);
        let mut checked = Vec::new();
        let mut csv = "particles,form,x_m,y_m,weight\n".to_owned();
        let mut pictures = Vec::new();
        for (passes, particles) in PASSES
            .map(|it| PARTICLES.map(|n| (it, n)))
            .into_iter()
            .flatten()
        {
            for maximum in MaximumRange::ALL {
                let scan = ServoScan {
                    particles,
                    passes,
                    maximum,
                    limit_m,
                    seed: self.seed,
                };
                let mut figures = ServoScanFigures::default();
                for sweep in &all {
                    figures = figures.plus(&scan.run(sweep)?.figures);
                }
                console::print(table_row(&scan, &figures, all.len()));
                if passes == PASSES[1] {
                    let run = scan.run(shown)?;
                    write_rows(&mut csv, &scan, &run);
                    if particles == PARTICLES[0] {
                        checked.push(figures);
                        pictures.push(picture(&scan, &run, shown));
                    }
                }
            }
        }
        output::create_folder(&self.out)?;
        output::write(&files[0], csv.as_bytes())?;
        beside(&pictures).save_png(&files[1])?;
        console::print(format_args!(
            "{}, {}: one sweep, {} passes",
            files[0].display(),
            files[1].display(),
            PASSES[1]
        ));
        Ok(print_checks(&checks(&checked, limit_m.is_some())))
    }
}

const TABLE_HEAD: &str = "particles  passes  form           high  within 5 cm  ends covered  \
                          free density    ring  outside";

fn table_row(scan: &ServoScan, figures: &ServoScanFigures, sweeps: usize) -> String {
    let mean = |count: usize| count as f64 / sweeps as f64;
    format!(
        "{:>9}  {:>6}  {:<9}  {:>8.1}  {:>11.3}  {:>12.3}  {:>12.4}  {:>6.1}  {:>7.1e}",
        scan.particles,
        scan.passes,
        scan.maximum.name(),
        mean(figures.high),
        figures.near_share(),
        figures.covered_share(),
        figures.free_density(),
        mean(figures.ring),
        figures.outside_change,
    )
}

fn write_rows(csv: &mut String, scan: &ServoScan, run: &ServoScanRun) {
    for particle in &run.particles {
        let (count, form, place) = (scan.particles, scan.maximum.name(), particle.place);
        let ServoParticle { weight, .. } = particle;
        // Writing to a text does not fail.
        let _ = writeln!(
            csv,
            "{count},{form},{:.4},{:.4},{weight:.4}",
            place.x, place.y
        );
    }
}

fn picture(scan: &ServoScan, run: &ServoScanRun, sweep: &Sweep) -> sim_harness::report::Picture {
    let mut classes: [Vec<(f64, f64)>; 3] = Default::default();
    for particle in &run.particles {
        let class = usize::from(!particle.is_low()) + usize::from(particle.is_high());
        classes[class].push((particle.place.x, particle.place.y));
    }
    let title = match scan.maximum {
        MaximumRange::Clears => "No echo clears (corrected)",
        MaximumRange::Obstacle => "No echo is an obstacle (printed)",
    };
    let ends = sweep.ends().map(|end| (end.x, end.y)).collect();
    servo_scan_picture(title, run.radius_m, classes, ends)
}

/// What the largest set shows after all passes, corrected and printed.
fn checks(figures: &[ServoScanFigures], has_limit: bool) -> Vec<ExperimentCheck> {
    let [corrected, printed] = figures else {
        return Vec::new();
    };
    let free = corrected.free_density();
    let mut checks = vec![
        ExperimentCheck::at_most("density in the free sector", free, 0.05),
        ExperimentCheck::at_most("change of weights outside", corrected.outside_change, 1e-6),
    ];
    let near = corrected.near_share();
    if has_limit {
        let printed_near = printed.near_share();
        checks.push(ExperimentCheck::at_least(
            "near an end, corrected",
            near,
            printed_near + 0.2,
        ));
        let (ring, least) = (printed.ring as f64, 5.0 * corrected.ring as f64);
        checks.push(ExperimentCheck::at_least("ring, printed", ring, least));
    } else {
        checks.push(ExperimentCheck::at_least("near an end", near, 0.90));
        checks.push(ExperimentCheck::at_least(
            "ends covered",
            corrected.covered_share(),
            0.90,
        ));
    }
    checks
}
