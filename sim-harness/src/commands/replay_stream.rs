//! The recording that a replay writes: what went into the filter and what it answered.

use std::error::Error;
use std::io;

use amiro_ipf::link::TruthMessage;
use amiro_ipf::node::{Config, Input};
use sim_harness::log::{Overview, RecordingWriter, StoredRecording};
use sim_harness::output;
use sim_harness::spool::Spool;

use super::replay::Replay;

/// Writes `stream.ipf`, the bytes of the link: a recording that replays itself.
pub(super) fn save(
    replay: &Replay,
    config: &Config,
    recording: &mut StoredRecording,
    answered: Spool,
) -> Result<(), Box<dyn Error>> {
    let overview = recording.overview().clone();
    output::write_with(&replay.out.join("stream.ipf"), |file| {
        let mut writer = RecordingWriter::new(file)?;
        if let Some(truth) = &overview.truth {
            if let Some(seed) = truth.seed {
                writer.write_truth(&TruthMessage::Seed(seed))?;
            }
            if let Some(text) = &truth.scenario {
                writer.write_scenario(text)?;
            }
        }
        for (text, seed) in faults_of_all(replay, &overview) {
            writer.write_faults(&text, seed)?;
        }
        if overview.truth.is_some() {
            let mut poses = recording.true_poses().map_err(io::Error::other)?;
            for (stamp_us, pose) in poses.by_ref() {
                writer.write_truth(&TruthMessage::Pose { stamp_us, pose })?;
            }
            poses.finish().map_err(io::Error::other)?;
        }
        writer.write_input(&Input::Configure(*config))?;
        let mut inputs = recording.inputs(|_| ()).map_err(io::Error::other)?;
        for input in replay.replayed(&mut inputs).map_err(io::Error::other)? {
            writer.write_input(&input)?;
        }
        inputs.finish().map_err(io::Error::other)?;
        writer.write_frames_of(answered.read()?)?;
        writer.finish()?;
        Ok(())
    })?;
    Ok(())
}

/// What was broken when it was recorded, and what is broken now.
fn faults_of_all(replay: &Replay, overview: &Overview) -> Vec<(String, u64)> {
    let truth = overview.truth.as_ref();
    let mut all = truth.map_or_else(Vec::new, |truth| truth.faults.clone());
    if replay.fault.are_none() {
        return all;
    }
    match all.last_mut() {
        // Texts of one seed are one text.
        Some((text, seed)) if *seed == replay.seed_of_faults => {
            text.push_str(&format!(", {}", replay.fault));
        }
        _ => all.push((replay.fault.to_string(), replay.seed_of_faults)),
    }
    all
}
