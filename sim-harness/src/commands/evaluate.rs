//! `cargo ipf evaluate`: every method on the same drives, and what holds of the claims.

use std::collections::BTreeSet;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::slice;
use std::time::Instant;

use amiro_ipf::config::Config;
use amiro_ipf::filter::Profile;
use amiro_ipf::input::Input;
use amiro_ipf::sensor::{Photometry, Sample};
use clap::Args;
use sim_harness::console;
use sim_harness::evaluation::recorded::recorded_walls;
use sim_harness::evaluation::{
    Claim, Comparison, Over, STANDARD, Trial, Verdict, json, paper_claims, standard, thresholds,
};
use sim_harness::mapping::Method;
use sim_harness::output;
use sim_harness::robot::{SensorFaultTrials, StampTrials};
use sim_harness::world::{Odometry, Options, Physics, Scenario, simulate_with};
use sim_harness::{RunError, check};

use super::footprint::FootprintSwitch;
use super::{Ending, Outcome, arguments};
use super::{evaluate_report, evaluate_robot};

/// Fewest seeds that the thresholds are made for.
const ENOUGH_SEEDS: u64 = 10;
/// Most threads: a process may have some thousands, and more than processors are no gain.
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
                         ism-standard-object,ism-tuned-dropped,ism-tuned-object,\
                         all-free",
        conflicts_with_all = ["recordings", "sensor_faults", "stamps"]
    )]
    methods: Vec<Method>,
    /// Seeds of noise and filters, the end excluded; 0 to 99 were for tuning.
    #[arg(
        long,
        value_name = "A..B",
        default_value = "100..120",
        value_parser = arguments::seeds,
        allow_hyphen_values = true,
        conflicts_with = "recordings"
    )]
    seeds: Range<u64>,
    /// Particles for each sensor in use.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        conflicts_with_all = ["recordings", "stamps"]
    )]
    particles: u16,
    /// How returns make a signal: matched (the strongest one, by the filter's own law)
    /// or patch (all that is seen, by Lambert's law).
    #[arg(
        long,
        default_value_t,
        value_name = "PHYSICS",
        conflicts_with_all = ["recordings", "sensor_faults", "stamps"]
    )]
    physics: Physics,
    /// What the robot is told of its motion: truth, wheel-errors, or amiro (as on its
    /// bus, held against exact poses and against no prediction).
    #[arg(
        long,
        default_value_t,
        value_name = "ODOMETRY",
        conflicts_with_all = ["recordings", "sensor_faults", "stamps"]
    )]
    odometry: Odometry,
    /// Gain that filters and ISM believe in, counts m^2.
    #[arg(
        long,
        value_name = "A",
        conflicts_with_all = ["calibrate", "recordings", "sensor_faults", "stamps"]
    )]
    alpha: Option<f32>,
    /// Believe in the gain of a block's long side at 100 mm under the chosen physics.
    #[arg(long, conflicts_with_all = ["recordings", "sensor_faults", "stamps"])]
    calibrate: bool,
    /// Whether cells of every map whose centre has been under the robot's hull are free;
    /// not so in the paper.
    #[arg(
        long,
        value_enum,
        default_value_t = FootprintSwitch::Off,
        value_name = "on|off",
        conflicts_with_all = ["recordings", "sensor_faults", "stamps"]
    )]
    footprint: FootprintSwitch,
    /// Threads; 0 for one per processor. The figures do not depend on it.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = clap::value_parser!(u16).range(0..=MAX_THREADS),
        conflicts_with_all = ["recordings", "sensor_faults", "stamps"]
    )]
    threads: u16,
    /// Judge recorded drives along walls of known place instead: the folder of the
    /// AMiRo's stepped series.
    #[arg(long, value_name = "DIR", value_parser = arguments::path(), conflicts_with_all = ["scenario", "check"])]
    recordings: Option<PathBuf>,
    /// Judge what a broken sensor costs a simulated robot instead: in the scenarios of
    /// several sensors, exit code 1 if too much.
    #[arg(long, conflicts_with_all = ["recordings", "check", "json", "stamps"])]
    sensor_faults: bool,
    /// When the sensor breaks, as a share of the drive's time; the middle of the mazes'
    /// drives lies in a turn in place.
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.5,
        value_parser = arguments::share,
        requires = "sensor_faults",
        conflicts_with_all = ["recordings", "stamps"]
    )]
    breaks_at: f64,
    /// Print what it costs a simulated robot that its odometry's frames do not say when
    /// their pose was reckoned, in the scenarios of several sensors.
    #[arg(long, conflicts_with_all = ["recordings", "check", "json"])]
    stamps: bool,
    /// Where the figures of every drive go.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    json: Option<PathBuf>,
    /// End with exit code 1 if a claim or a threshold does not hold.
    #[arg(long)]
    check: bool,
}

impl Evaluate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        if let Some(json) = &self.json {
            arguments::check_file("--json", json)?;
            let scenarios: Vec<_> = self.scenario.iter().map(Path::new).collect();
            output::check(slice::from_ref(json), &scenarios)?;
        }
        if let Some(folder) = &self.recordings {
            return self.judge_recordings(folder);
        }
        if self.sensor_faults || self.stamps {
            return self.judge_robot();
        }
        let begun = Instant::now();
        let comparison = self.comparison()?;
        let trials = comparison.run()?;
        let claims = verdicts(&paper_claims(), &trials);
        let bounds = verdicts(&self.bounds(), &trials);
        if let Some(path) = &self.json {
            output::write(path, json(&trials)?.as_bytes())?;
        }
        evaluate_report::world(&comparison);
        evaluate_report::tables(&comparison, &trials);
        evaluate_report::paired(&comparison, &trials);
        evaluate_report::verdicts("Claims of the paper", &claims);
        evaluate_report::verdicts("Thresholds", &bounds);
        if self.seeds.end - self.seeds.start < ENOUGH_SEEDS {
            console::print(format_args!(
                "Thresholds are made for means over {ENOUGH_SEEDS} seeds or more."
            ));
        }
        evaluate_report::not_reproduced(&trials);
        let is_odometry_good = self.judge_odometry(&comparison, &trials)?;
        console::print(format_args!(
            "{} drives, {} maps, {:.1} s",
            comparison.scenarios.len() as u64 * (self.seeds.end - self.seeds.start),
            trials.len(),
            begun.elapsed().as_secs_f64()
        ));
        if !self.check {
            return Ok(Ending::Good);
        }
        let mut judged = claims.iter().chain(&bounds).peekable();
        if judged.peek().is_none() {
            return Err("--check, but no claim is about these scenarios and methods".into());
        }
        Ok(if judged.all(Verdict::holds) && is_odometry_good {
            Ending::Good
        } else {
            Ending::Failed
        })
    }

    /// The stepped series beside walls whose place is known.
    fn judge_recordings(&self, folder: &Path) -> Outcome {
        let report = recorded_walls(folder)?;
        if let Some(path) = &self.json {
            let mut json = serde_json::to_string_pretty(&report)?;
            json.push('\n');
            output::write(path, json.as_bytes())?;
        }
        console::print_text(report);
        Ok(Ending::Good)
    }

    /// A simulated robot, by the seeds that were asked for.
    fn judge_robot(&self) -> Outcome {
        let mut scenarios = self.scenarios()?;
        let has_one_sensor = |scenario: &Scenario| scenario.ring().1.len() < 2;
        if let Some(scenario) = scenarios.iter().find(|scenario| has_one_sensor(scenario))
            && !self.scenario.is_empty()
        {
            let name = &scenario.name;
            return Err(format!("--scenario {name}: of a robot with one sensor").into());
        }
        scenarios.retain(|scenario| !has_one_sensor(scenario));
        arguments::check_drives(scenarios.len(), &self.seeds)?;
        self.check_configs(&scenarios, None)?;
        let seeds = self.seeds.clone();
        if self.stamps {
            return evaluate_robot::stamps(&StampTrials { scenarios, seeds });
        }
        evaluate_robot::sensor_faults(&SensorFaultTrials {
            scenarios,
            seeds,
            breaks_at: self.breaks_at,
            particles_per_sensor: self.particles,
        })
    }

    /// The thresholds that can be asked for: absolute ones hold for the matched sensor
    /// and exact poses, ratios between methods for every world.
    fn bounds(&self) -> Vec<Claim> {
        let is_reference = self.physics == Physics::Matched && self.odometry == Odometry::Truth;
        let is_ratio = |claim: &Claim| matches!(claim.over, Over::MeanShareOf(_));
        let all = thresholds().into_iter();
        all.filter(|claim| is_reference || is_ratio(claim))
            .collect()
    }

    /// The AMiRo's odometry against exact poses and against no prediction, where it was
    /// asked for; whether it costs little enough.
    fn judge_odometry(
        &self,
        comparison: &Comparison,
        trials: &[Trial],
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
        ))
    }

    fn comparison(&self) -> Result<Comparison, Box<dyn Error>> {
        let mut methods = Vec::new();
        for method in &self.methods {
            if !methods.contains(method) {
                methods.push(*method);
            }
        }
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
            methods,
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

    /// Checks, before the first drive, what every filter will be configured with.
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

/// What a calibration on a block's long side would give: its signal without noise at
/// 100 mm straight ahead of one sensor, as the gain that puts a point there.
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
    // The claims go by names: another world must not be judged by the paper's.
    if let Some(known) = standard(&scenario.name)
        && known? != scenario
    {
        let name = &scenario.name;
        return Err(format!("{wanted}: named {name}, but not the paper's; rename it").into());
    }
    Ok(scenario)
}

fn verdicts(claims: &[Claim], trials: &[Trial]) -> Vec<Verdict> {
    claims
        .iter()
        .filter_map(|claim| claim.judge(trials))
        .collect()
}
