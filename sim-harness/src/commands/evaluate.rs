//! `cargo ipf evaluate`: every method on the same drives, and the claims about them.

use std::collections::BTreeSet;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::{Photometry, Sample};
use amiro_ipf::node::{Config, Input};
use clap::Args;
use sim_harness::evaluation::{Claim, Claims, Comparison, Over, Trial, Verdict, json};
use sim_harness::mapping::Method;
use sim_harness::world::{Odometry, Options, Physics, STANDARD, Scenario, simulate_with, standard};
use sim_harness::{RunError, check, console, output};

use super::evaluate_recorded::Recorded;
use super::footprint::FootprintSwitch;
use super::{Ending, Outcome, arguments, evaluate_report};

/// Least number of seeds that the thresholds are made for.
const ENOUGH_SEEDS: u64 = 10;
/// Greatest number of threads; more threads than processors are no gain.
const MAX_THREADS: i64 = 256;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub(super) struct Evaluate {
    /// Scenarios: names of the paper's or TOML files; all of the paper's by default.
    #[arg(long, value_name = "NAME|FILE", num_args = 1.., value_delimiter = ',')]
    scenario: Vec<String>,
    /// Methods, separated by commas.
    #[arg(
        long,
        value_name = "METHODS",
        value_delimiter = ',',
        default_value = "paper,plus,ism-standard,ism-tuned,ism-standard-dropped,\
                         ism-standard-object,ism-tuned-dropped,ism-tuned-object,all-free"
    )]
    methods: Vec<Method>,
    /// Seeds of noise and filters, the end excluded; 0 to 99 were for tuning.
    #[arg(
        long,
        value_name = "A..B",
        default_value = "100..120",
        value_parser = arguments::seeds,
        allow_hyphen_values = true
    )]
    seeds: Range<u64>,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    particles: u16,
    /// Rule of the signal: matched (the strongest return, by the filter's own law) or
    /// patch (the sum of all, by Lambert's law).
    #[arg(long, default_value_t, value_name = "PHYSICS")]
    physics: Physics,
    /// Odometry: truth, wheel-errors, or amiro (as on its bus, compared with exact poses
    /// and with no prediction).
    #[arg(long, default_value_t, value_name = "ODOMETRY")]
    odometry: Odometry,
    /// Gain of the law in filters and ISM, counts m^2.
    #[arg(long, value_name = "A", conflicts_with = "calibrate")]
    alpha: Option<f32>,
    /// Use the gain of a block's long side at 100 mm under the chosen physics.
    #[arg(long)]
    calibrate: bool,
    /// Whether cells whose centre has been under the robot's hull are free in every map;
    /// off in the paper.
    #[arg(
        long,
        value_enum,
        default_value_t = FootprintSwitch::Off,
        value_name = "on|off"
    )]
    footprint: FootprintSwitch,
    /// Threads; 0 for one per processor. The figures do not depend on it.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = clap::value_parser!(u16).range(0..=MAX_THREADS)
    )]
    threads: u16,
    /// File for the scores of every drive.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    json: Option<PathBuf>,
    /// End with exit code 1 if a claim or a threshold does not hold.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    recorded: Recorded,
}

impl Evaluate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let out = self.json.as_deref();
        if let Some(outcome) = self.recorded.run(&self.methods, self.particles, out) {
            return outcome;
        }
        if let Some(json) = out {
            arguments::check_file("--json", json)?;
            let scenarios: Vec<_> = self.scenario.iter().map(Path::new).collect();
            output::check(&[json.to_owned()], &scenarios)?;
        }
        let begun = Instant::now();
        let comparison = self.comparison()?;
        let trials = comparison.run()?;
        let claims = Claims::built_in()?;
        let paper = verdicts(&claims.paper, &trials);
        let thresholds = claims.thresholds.iter();
        let thresholds = verdicts(thresholds.filter(|claim| self.applies(claim)), &trials);
        if let Some(path) = &self.json {
            output::write(path, json(&trials)?.as_bytes())?;
        }
        evaluate_report::world(&comparison);
        evaluate_report::tables(&comparison, &trials);
        evaluate_report::paired(&comparison, &trials);
        evaluate_report::verdicts("Claims of the paper", &paper);
        evaluate_report::verdicts("Thresholds", &thresholds);
        if self.seeds.end - self.seeds.start < ENOUGH_SEEDS {
            console::print(format_args!(
                "Thresholds are made for means over {ENOUGH_SEEDS} seeds or more."
            ));
        }
        evaluate_report::not_reproduced(&trials);
        let loss_at_most = claims.odometry_loss_at_most;
        let is_odometry_good = self.judge_odometry(&comparison, &trials, loss_at_most)?;
        console::print(format_args!(
            "{} drives, {} maps, {:.1} s",
            comparison.scenarios.len() as u64 * (self.seeds.end - self.seeds.start),
            trials.len(),
            begun.elapsed().as_secs_f64()
        ));
        if !self.check {
            return Ok(Ending::Good);
        }
        let mut judged = paper.iter().chain(&thresholds).peekable();
        if judged.peek().is_none() {
            return Err("--check, but no claim is about these scenarios and methods".into());
        }
        Ok(if judged.all(Verdict::holds) && is_odometry_good {
            Ending::Good
        } else {
            Ending::Failed
        })
    }

    /// Whether a threshold is for the world that was asked for: ratios between methods
    /// are for every world, the others for the matched sensor and exact poses.
    fn applies(&self, threshold: &Claim) -> bool {
        let is_reference = self.physics == Physics::Matched && self.odometry == Odometry::Truth;
        is_reference || matches!(threshold.over, Over::MeanShareOf(_))
    }

    /// The AMiRo's odometry against exact poses and against no prediction, where it was
    /// asked for; whether it costs little enough.
    fn judge_odometry(
        &self,
        comparison: &Comparison,
        trials: &[Trial],
        loss_at_most: f64,
    ) -> Result<bool, Box<dyn Error>> {
        if self.odometry != Odometry::Amiro {
            return Ok(true);
        }
        let with = |odometry| {
            let mut other = comparison.clone();
            other.options.odometry = odometry;
            other.run()
        };
        let exact = with(Odometry::Truth)?;
        let undated = with(Odometry::AmiroUndated)?;
        Ok(evaluate_report::odometry(
            comparison,
            [&exact, trials, &undated],
            loss_at_most,
        ))
    }

    fn comparison(&self) -> Result<Comparison, Box<dyn Error>> {
        let options = Options {
            physics: self.physics,
            odometry: self.odometry,
            ..Options::default()
        };
        options.validate().map_err(|error| format!("--{error}"))?;
        let scenarios = self.scenarios()?;
        arguments::check_drives(scenarios.len(), &self.seeds)?;
        self.check_configs(&scenarios, self.alpha)?;
        Ok(Comparison {
            scenarios,
            methods: arguments::distinct(&self.methods),
            seeds: self.seeds.clone(),
            particles_per_sensor: self.particles,
            options,
            alpha_counts_m2: if self.calibrate {
                Some(gain_of_a_block(&options)?)
            } else {
                self.alpha
            },
            footprint: self.footprint == FootprintSwitch::On,
            threads: usize::from(self.threads),
        })
    }

    /// Checks the configuration of every filter before the first drive.
    fn check_configs(&self, scenarios: &[Scenario], alpha: Option<f32>) -> Result<(), String> {
        for scenario in scenarios {
            let mut config = Config {
                particles_per_sensor: self.particles,
                ..scenario.config(Profile::Paper)
            };
            if let Some(alpha) = alpha {
                config.photometry.alpha_counts_m2 = alpha;
            }
            check(&config).map_err(|error| {
                let option = match &error {
                    RunError::Parameter(error) => arguments::option_of(error.parameter),
                    RunError::TooManyParticles { .. } => Some("--particles"),
                    RunError::Refused(_) => None,
                };
                format!("{}: {error}", option.unwrap_or(&scenario.name))
            })?;
        }
        Ok(())
    }

    fn scenarios(&self) -> Result<Vec<Scenario>, Box<dyn Error>> {
        let all = STANDARD.map(|(name, _)| name.to_owned());
        let wanted = if self.scenario.is_empty() {
            all.as_slice()
        } else {
            &self.scenario
        };
        let mut scenarios = Vec::new();
        let mut names = BTreeSet::new();
        for wanted in wanted {
            let scenario = scenario(wanted)?;
            if !names.insert(scenario.name.clone()) {
                return Err(format!("two scenarios are named {}", scenario.name).into());
            }
            scenarios.push(scenario);
        }
        Ok(scenarios)
    }
}

/// The gain of a calibration on a block's long side: the gain with which a point at
/// 100 mm straight ahead of one sensor has the block's signal.
fn gain_of_a_block(options: &Options) -> Result<f32, Box<dyn Error>> {
    const RANGE_M: f32 = 0.1;
    let scenario = Scenario::parse(include_str!("calibration.toml"))?;
    let quiet = Options {
        noise_factor: 0.0,
        odometry: Odometry::Truth,
        ..*options
    };
    let readings = simulate_with(&scenario, 0, &quiet).inputs;
    let counts = readings.iter().find_map(|input| match input {
        Input::Proximity {
            samples: [Sample::Counts(counts), ..],
            ..
        } => Some(*counts as f32),
        _ => None,
    });
    let counts = counts.ok_or("the calibration has no reading")?;
    Ok((counts - Photometry::VCNL4020.beta_counts) * RANGE_M * RANGE_M)
}

/// A scenario of the paper by its name, or another from its file.
fn scenario(wanted: &str) -> Result<Scenario, Box<dyn Error>> {
    if let Some(known) = standard(wanted) {
        return Ok(known?);
    }
    let scenario = Scenario::load(Path::new(wanted))?;
    // Claims are found by name: another world must not be judged by those of the paper.
    if let Some(known) = standard(&scenario.name)
        && known? != scenario
    {
        let name = &scenario.name;
        return Err(format!("{wanted}: named {name}, but not the paper's; rename it").into());
    }
    Ok(scenario)
}

fn verdicts<'c>(claims: impl IntoIterator<Item = &'c Claim>, trials: &[Trial]) -> Vec<Verdict> {
    let claims = claims.into_iter();
    claims.filter_map(|claim| claim.judge(trials)).collect()
}
