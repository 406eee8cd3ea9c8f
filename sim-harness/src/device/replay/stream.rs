//! The recording that a replay writes: what went into the filter and what it answered.

use std::io;
use std::path::Path;

use amiro_ipf::link::TruthMessage;
use amiro_ipf::node::Input;

use super::ReplayPlan;
use crate::log::{Overview, RecordingWriter, StoredRecording};
use crate::output::{self, WriteError};
use crate::spool::Spool;

impl ReplayPlan<'_> {
    /// Writes the bytes of the link: a recording that replays itself.
    ///
    /// # Errors
    /// The file cannot be written, or the recording cannot be read again.
    pub fn save_stream(
        &self,
        path: &Path,
        recording: &mut StoredRecording,
        answered: Spool,
    ) -> Result<(), WriteError> {
        let overview = recording.overview().clone();
        output::write_with(path, |file| {
            let mut writer = RecordingWriter::new(file)?;
            if let Some(truth) = &overview.truth {
                if let Some(seed) = truth.seed {
                    writer.write_truth(&TruthMessage::Seed(seed))?;
                }
                if let Some(text) = &truth.scenario {
                    writer.write_scenario(text)?;
                }
            }
            for (text, seed) in faults_of_all(self, &overview) {
                writer.write_faults(&text, seed)?;
            }
            if overview.truth.is_some() {
                let mut poses = recording.true_poses().map_err(io::Error::other)?;
                for (stamp_us, pose) in poses.by_ref() {
                    writer.write_truth(&TruthMessage::Pose { stamp_us, pose })?;
                }
                poses.finish().map_err(io::Error::other)?;
            }
            writer.write_input(&Input::Configure(*self.config))?;
            let mut inputs = recording.inputs(|_| ()).map_err(io::Error::other)?;
            for input in self.inputs(&mut inputs).map_err(io::Error::other)? {
                writer.write_input(&input)?;
            }
            inputs.finish().map_err(io::Error::other)?;
            writer.write_frames_of(answered.read()?)?;
            writer.finish()?;
            Ok(())
        })
    }
}

/// What was broken when it was recorded, and what is broken now.
fn faults_of_all(plan: &ReplayPlan<'_>, overview: &Overview) -> Vec<(String, u64)> {
    let truth = overview.truth.as_ref();
    let mut all = truth.map_or_else(Vec::new, |truth| truth.faults.clone());
    if plan.faults.are_none() {
        return all;
    }
    match all.last_mut() {
        // Texts of one seed are one text.
        Some((text, seed)) if *seed == plan.seed_of_faults => {
            text.push_str(&format!(", {}", plan.faults));
        }
        _ => all.push((plan.faults.to_string(), plan.seed_of_faults)),
    }
    all
}
