//! `cargo ipf simulate`: a scenario, driven and recorded.

use std::fs;
use std::path::PathBuf;

use amiro_ipf::filter::Profile;
use amiro_ipf::input::Input;
use amiro_ipf::wire::Truth;
use clap::Args;
use sim_harness::log::RecordingWriter;
use sim_harness::output;
use sim_harness::world::{
    Drift, Odometry, Options, OptionsError, Physics, Scenario, simulate_with,
};

use super::{Ending, Outcome};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub(super) struct Simulate {
    /// The scenario, a TOML file. A first line of options in it, as recordings have it,
    /// does not count: the flags do.
    scenario: PathBuf,
    /// Seed of the sensors' noise, and of the filter when the recording is replayed.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Where the recording goes.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    differences: Differences,
}

/// In what the world differs from the filter's model; recorded with the scenario.
#[derive(Debug, Args)]
struct Differences {
    /// How returns make a signal: matched (the strongest one) or patch (all that is seen).
    #[arg(long, default_value_t, value_name = "PHYSICS")]
    physics: Physics,
    /// Sensor noise, times the model's.
    #[arg(long, default_value_t = 1.0, value_name = "F")]
    noise: f64,
    /// Offset of the sensors, counts: 10 all along, 0..10 growing over the drive.
    #[arg(long, default_value_t = Drift::NONE, value_name = "COUNTS", allow_hyphen_values = true)]
    drift: Drift,
    /// Reflectivity of everything, times the scenario's.
    #[arg(long, default_value_t = 1.0, value_name = "F")]
    reflectivity: f64,
    /// Probability that a sample is missing.
    #[arg(long, default_value_t = 0.0, value_name = "P")]
    dropout: f64,
    /// Shape of the world's lobe; default: the model's.
    #[arg(long, value_name = "XI")]
    xi: Option<f64>,
    /// Dependence of the world's gain on the signal, m^2; default: the model's.
    #[arg(long, value_name = "M2", allow_hyphen_values = true)]
    delta: Option<f64>,
    /// What the robot is told: truth, wheel-errors (1 %, 2 degrees a root metre),
    /// wheel-errors:PERCENT:DEGREES, amiro (as on its bus), or amiro-undated (as amiro,
    /// each pose taken for current).
    #[arg(long, default_value_t, value_name = "ODOMETRY")]
    odometry: Odometry,
}

impl Differences {
    fn options(&self) -> Result<Options, OptionsError> {
        let options = Options {
            physics: self.physics,
            noise_factor: self.noise,
            drift: self.drift,
            reflectivity_factor: self.reflectivity,
            dropout: self.dropout,
            xi: self.xi,
            delta_m2: self.delta,
            odometry: self.odometry,
        };
        options.validate()?;
        Ok(options)
    }
}

impl Simulate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let scenario = Scenario::load(&self.scenario)?;
        let text = fs::read_to_string(&self.scenario)?;
        let options = self.differences.options()?;
        let simulation = simulate_with(&scenario, self.seed, &options);
        let mut config = scenario.config(Profile::Paper);
        config.seed = self.seed;
        output::write_with(&self.out, |file| {
            let mut writer = RecordingWriter::new(file)?;
            writer.write_truth(&Truth::Seed(self.seed))?;
            writer.write_scenario(&options.in_front_of(&text))?;
            writer.write_input(&Input::Configure(config))?;
            let mut poses = simulation.poses.iter();
            for input in &simulation.inputs {
                writer.write_input(input)?;
                if let (Input::Proximity { .. }, Some(&(stamp_us, pose))) = (input, poses.next()) {
                    writer.write_truth(&Truth::Pose { stamp_us, pose })?;
                }
            }
            writer.finish()?;
            Ok(())
        })?;
        println!(
            "{}: {} samples of {:.1} s, {}",
            self.out.display(),
            simulation.poses.len(),
            scenario.duration_s(),
            scenario.name
        );
        if options != Options::default() {
            println!("simulated with: {options}");
        }
        Ok(Ending::Good)
    }
}
