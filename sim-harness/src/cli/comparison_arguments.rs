//! What `evaluate` compares on what.

use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;
use clap::Args;
use sim_harness::RunError;
use sim_harness::evaluation::{ComparisonError, MethodComparison, block_gain, chosen_scenarios};
use sim_harness::mapping::Method;
use sim_harness::rig::Rig;
use sim_harness::world::{OdometryModel, Options, Physics};

use super::arguments;
use super::footprint::FootprintSwitch;

/// Greatest number of threads; more threads than processors are no gain.
const MAX_THREADS: i64 = 256;

/// Arguments that make up a comparison.
#[derive(Debug, Args)]
pub(super) struct ComparisonArguments {
    /// Scenarios: names of the paper's or TOML files; all of the paper's by default.
    #[arg(long, value_name = "NAME|FILE", num_args = 1.., value_delimiter = ',')]
    pub(super) scenario: Vec<String>,
    /// Methods, separated by commas; also ism, ism-decay and wall-map.
    #[arg(
        long,
        value_name = "METHODS",
        value_delimiter = ',',
        default_value = "paper,plus,ism-standard,ism-tuned,ism-standard-dropped,\
                         ism-standard-object,ism-tuned-dropped,ism-tuned-object,all-free"
    )]
    pub(super) methods: Vec<Method>,
    /// Seeds of noise and filters, the end excluded; 0 to 99 were for tuning.
    #[arg(
        long,
        value_name = "A..B",
        default_value = "100..120",
        value_parser = arguments::seeds,
        allow_hyphen_values = true
    )]
    pub(super) seeds: Range<u64>,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub(super) particles: u16,
    /// Rule of the signal: matched (the strongest return, by the filter's own law) or
    /// patch (the sum of all, by Lambert's law).
    #[arg(long, default_value_t, value_name = "PHYSICS")]
    physics: Physics,
    /// Odometry: truth, wheel-errors (with numbers as in `simulate`), or amiro (as on its
    /// bus, compared with exact poses and with no prediction).
    #[arg(long, default_value_t, value_name = "ODOMETRY")]
    pub(super) odometry: OdometryModel,
    /// Gain of the law in filters and ISM, counts m^2.
    #[arg(long, value_name = "A", conflicts_with = "calibrate")]
    alpha: Option<f32>,
    /// Alpha and gains of the sensors in filters and methods, as `calibrate --from-drive`
    /// writes them; --alpha and --calibrate win over its alpha.
    #[arg(long, value_name = "FILE")]
    pub(super) gains: Option<PathBuf>,
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
}

impl ComparisonArguments {
    /// The comparison, checked as far as it can be before the first drive.
    pub(super) fn comparison(&self) -> Result<MethodComparison, Box<dyn Error>> {
        let options = Options {
            physics: self.physics,
            odometry: self.odometry,
            ..Options::default()
        };
        options.validate().map_err(|error| format!("--{error}"))?;
        let scenarios = chosen_scenarios(&self.scenario)?;
        arguments::check_drives(scenarios.len(), &self.seeds)?;
        let amiro = Rig::from(&Config::amiro(Profile::Paper));
        for method in &self.methods {
            if let Err(missing) = method.sensors.mounts(&amiro, &amiro.mounts_named(&[])) {
                return Err(format!("--methods {method} {missing}: AMiRo has others").into());
            }
        }
        let calibration = arguments::calibration(self.gains.as_deref())?;
        let comparison = MethodComparison {
            scenarios,
            methods: arguments::distinct(&self.methods),
            seeds: self.seeds.clone(),
            particles_per_sensor: self.particles,
            options,
            alpha_counts_m2: self.alpha,
            calibration,
            footprint: self.footprint == FootprintSwitch::On,
            threads: usize::from(self.threads),
        };
        comparison.check().map_err(|error| with_option(&error))?;
        Ok(if self.calibrate {
            MethodComparison {
                alpha_counts_m2: Some(block_gain(&options)?),
                ..comparison
            }
        } else {
            comparison
        })
    }
}

/// The error with the option that it is about in place of the scenario, if there is one.
fn with_option(error: &ComparisonError) -> String {
    let ComparisonError::Run { scenario, source } = error else {
        return error.to_string();
    };
    let option = match source {
        RunError::Parameter(error) => arguments::option_of(error.parameter),
        RunError::TooManyParticles { .. } => Some("--particles"),
        RunError::Refused(_) => None,
    };
    format!("{}: {source}", option.unwrap_or(scenario))
}
