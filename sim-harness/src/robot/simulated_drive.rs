//! A drive that is simulated with faults, and its recording, which contains them.

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

/// A simulated drive: the world, its differences from the model, and the faults.
///
/// If the faults name a part, even with `ok`, a whole [`Robot`] drives: its acquisition
/// reads the sensors over their buses, and its stamps count from when its power came up,
/// 0.4 s before it drives. Otherwise the inputs are those of [`simulate_with`]. Faults of
/// the line apply between the robot and the recorder.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedDrive<'a> {
    /// The world.
    pub scenario: &'a Scenario,
    /// The same as the text that is recorded.
    pub text: &'a str,
    /// Seed of the sensors' noise, the clocks, and the filter that replays it.
    pub seed: u64,
    /// Differences of the world from the model.
    pub options: Options,
    /// The faults.
    pub faults: &'a Faults,
    /// Seed of their random part.
    pub seed_of_faults: u64,
}

/// Options that a whole robot does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} is not for drives with faults of parts, in which {1}")]
pub struct SimulationRefused(&'static str, &'static str);

impl SimulatedDrive<'_> {
    /// Simulates the drive; returns also the health of the parts, eight times per second,
    /// if there are any.
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
    /// the inputs that arrive over the line.
    ///
    /// # Errors
    /// The error of `W`.
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
