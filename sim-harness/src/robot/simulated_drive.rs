//! A drive that is simulated with faults, and its recording, which says them.

use std::io::{Error, Write};
use std::time::Duration;

use amiro_ipf::board::health::Health;
use amiro_ipf::filter::Profile;
use amiro_ipf::link::TruthMessage;
use amiro_ipf::node::Input;

use super::{Robot, drive};
use crate::device::FaultInjector;
use crate::faults::Faults;
use crate::log::RecordingWriter;
use crate::world::{OdometryModel, Options, Scenario, Simulation, simulate_with};

/// A simulated drive: the world, in what it differs from the model, and what breaks.
///
/// As soon as a part is named, if only with `ok`, a whole [`Robot`] drives: its senses
/// read their sensors over their buses, and its stamps count from when its power came up,
/// 0.4 s before it drives. Otherwise the inputs are those of [`simulate_with`]. Faults of
/// the line are those of the way from the robot to whoever records it.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedDrive<'a> {
    /// The world.
    pub scenario: &'a Scenario,
    /// The same as the text that is recorded.
    pub text: &'a str,
    /// Of the sensors' noise, the clocks, and the filter that replays it.
    pub seed: u64,
    /// In what the world differs from the model.
    pub options: Options,
    /// What breaks.
    pub faults: &'a Faults,
    /// Of what is random about that.
    pub seed_of_faults: u64,
}

/// Options that a whole robot does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} is not for drives with faults of parts, in which {1}")]
pub struct SimulationRefused(&'static str, &'static str);

impl SimulatedDrive<'_> {
    /// Drives; gives also how the parts were, eight times a second, if there were any.
    ///
    /// # Errors
    /// Options that a whole robot does not have: dropout, undated odometry.
    pub fn simulate(&self) -> Result<(Simulation, Vec<(u64, Health)>), SimulationRefused> {
        let options = &self.options;
        if self.faults.parts().is_empty() {
            let simulation = simulate_with(self.scenario, self.seed, options);
            return Ok((simulation, Vec::new()));
        }
        if options.dropout > 0.0 {
            let instead = "samples get lost by ring=intermittent:SHARE";
            return Err(SimulationRefused("dropout", instead));
        }
        if options.odometry == OdometryModel::AmiroUndated {
            let instead = "the robot dates its odometry itself";
            return Err(SimulationRefused("odometry amiro-undated", instead));
        }
        let faults = self.faults.active(self.seed_of_faults);
        let whole = drive(Robot::new(self.scenario, self.seed, options, faults));
        let simulation = Simulation {
            inputs: whole.inputs(),
            poses: whole.poses,
        };
        Ok((simulation, whole.healths))
    }

    /// Writes the recording: the truth, the faults and their seed, the configuration, and
    /// of the inputs what comes over the line.
    ///
    /// # Errors
    /// What `W` says.
    pub fn write<W: Write>(&self, simulation: &Simulation, write: W) -> Result<W, Error> {
        let mut config = self.scenario.config(Profile::Paper);
        config.seed = self.seed;
        let mut writer = RecordingWriter::new(write)?;
        writer.write_truth(&TruthMessage::Seed(self.seed))?;
        writer.write_scenario(&self.options.in_front_of(self.text))?;
        if !self.faults.are_none() {
            writer.write_faults(&self.faults.to_string(), self.seed_of_faults)?;
        }
        writer.write_input(&Input::Configure(config))?;
        let mut line = FaultInjector::new(self.faults, self.seed_of_faults);
        let mut first_us = None;
        let mut now = Duration::ZERO;
        let mut poses = simulation.poses.iter().peekable();
        for input in &simulation.inputs {
            if let Input::Proximity { stamp_us, .. } = *input {
                let first_us = *first_us.get_or_insert(stamp_us);
                now = Duration::from_micros(stamp_us.saturating_sub(first_us));
            }
            line.send(writer.frame_of(input)?, now);
            writer.write_frames(&line.receive(now))?;
            if let Input::Proximity {
                stamp_us: now_us, ..
            } = *input
            {
                while let Some(&(stamp_us, pose)) = poses.next_if(|(at_us, _)| *at_us <= now_us) {
                    writer.write_truth(&TruthMessage::Pose { stamp_us, pose })?;
                }
            }
        }
        line.flush(now);
        writer.write_frames(&line.receive(Duration::MAX))?;
        writer.finish()
    }
}
