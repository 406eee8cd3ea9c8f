//! `cargo ipf simulate`: a scenario, driven and recorded.

use std::fs;
use std::path::PathBuf;

use amiro_ipf::filter::Profile;
use amiro_ipf::input::Input;
use amiro_ipf::wire::Truth;
use clap::Args;
use sim_harness::log::RecordingWriter;
use sim_harness::output;
use sim_harness::world::{Scenario, simulate};

use super::{Ending, Outcome};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub(super) struct Simulate {
    /// The scenario, a TOML file.
    scenario: PathBuf,
    /// Seed of the sensors' noise, and of the filter when the recording is replayed.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Where the recording goes.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

impl Simulate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let scenario = Scenario::load(&self.scenario)?;
        let text = fs::read_to_string(&self.scenario)?;
        let simulation = simulate(&scenario, self.seed);
        let mut config = scenario.config(Profile::Paper);
        config.seed = self.seed;
        output::write_with(&self.out, |file| {
            let mut writer = RecordingWriter::new(file)?;
            writer.write_truth(&Truth::Seed(self.seed))?;
            writer.write_scenario(&text)?;
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
        Ok(Ending::Good)
    }
}
