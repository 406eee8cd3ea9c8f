//! Servo scans with two numbers of particles, one pass and three, corrected and printed.

use std::fmt::Write;

use amiro_ipf::filter::ParameterError;

use super::{
    ExperimentCheck, ExperimentReport, MaximumRange, ServoScan, ServoScanFigures, ServoScanRun,
    ServoSweep,
};

/// Sweeps with fewer echoes are passed over.
const LEAST_ECHOES: usize = 11;

const PARTICLES: [usize; 2] = [10_000, 1_000];
const PASSES: [usize; 2] = [1, 3];

const TABLE_HEAD: &str = "particles  passes  form           high  within 5 cm  ends covered  \
                          free density    ring  outside";

/// The runs over the sweeps of a recording.
#[derive(Clone, Debug)]
pub struct ServoScanStudy {
    /// Table and checks.
    pub report: ExperimentReport,
    /// Particles of the sweep that is shown after all passes: a header, a row per particle.
    pub csv: String,
    /// The runs over the sweep that is shown, with the largest number of particles.
    pub shown: Vec<(MaximumRange, ServoScanRun)>,
    /// That sweep: one with echoes and with readings without, where there are such.
    pub sweep: ServoSweep,
}

impl ServoScanStudy {
    /// Runs the filter over all sweeps with more than 10 echoes; `None` without such.
    ///
    /// # Errors
    /// As [`ServoScan::run`].
    pub fn new(all: &[ServoSweep], seed: u64) -> Result<Option<Self>, ParameterError> {
        let used: Vec<&ServoSweep> = all
            .iter()
            .filter(|it| it.echoes() >= LEAST_ECHOES)
            .collect();
        let both = |sweep: &&&ServoSweep| sweep.echoes().min(sweep.readings.len() - sweep.echoes());
        let Some(sweep) = used.iter().max_by_key(both) else {
            return Ok(None);
        };
        let (count, found) = (used.len(), all.len());
        let mut study = Self {
            report: ExperimentReport::default(),
            csv: "particles,form,x_m,y_m,weight\n".to_owned(),
            shown: Vec::new(),
            sweep: (*sweep).clone(),
        };
        study.report.lines = vec![
            format!(
                "{count} of {found} sweeps have more than 10 echoes; seed {seed}; high particles \
                 and ring per sweep"
            ),
            TABLE_HEAD.to_owned(),
        ];
        let limit_m = used.iter().filter_map(|it| it.limit_m()).reduce(f64::max);
        let mut largest = Vec::new();
        for scan in scans(limit_m, seed) {
            let mut figures = ServoScanFigures::default();
            for sweep in &used {
                figures = figures.plus(&scan.run(sweep)?.figures);
            }
            study.report.lines.push(table_row(&scan, &figures, count));
            if scan.passes == PASSES[1] {
                let run = scan.run(sweep)?;
                write_rows(&mut study.csv, &scan, &run);
                if scan.particles == PARTICLES[0] {
                    largest.push(figures);
                    study.shown.push((scan.maximum, run));
                }
            }
        }
        study.report.checks = checks(&largest, limit_m.is_some());
        Ok(Some(study))
    }
}

fn scans(limit_m: Option<f64>, seed: u64) -> impl Iterator<Item = ServoScan> {
    PASSES.into_iter().flat_map(move |passes| {
        PARTICLES.into_iter().flat_map(move |particles| {
            MaximumRange::ALL.into_iter().map(move |maximum| ServoScan {
                particles,
                passes,
                maximum,
                limit_m,
                seed,
            })
        })
    })
}

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
    let (count, form) = (scan.particles, scan.maximum.name());
    for particle in &run.particles {
        let (place, weight) = (particle.place, particle.weight);
        // Writing to a text does not fail.
        let _ = writeln!(
            csv,
            "{count},{form},{:.4},{:.4},{weight:.4}",
            place.x, place.y
        );
    }
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
        let name = "near an end, corrected, 0.2 more than printed";
        let least = printed.near_share() + 0.2;
        checks.push(ExperimentCheck::at_least(name, near, least));
        let (ring, least) = (printed.ring as f64, 5.0 * corrected.ring as f64);
        let name = "particles in the ring, printed, 5 times corrected";
        checks.push(ExperimentCheck::at_least(name, ring, least));
    } else {
        let covered = corrected.covered_share();
        checks.push(ExperimentCheck::at_least("near an end", near, 0.90));
        checks.push(ExperimentCheck::at_least("ends covered", covered, 0.90));
    }
    checks
}
