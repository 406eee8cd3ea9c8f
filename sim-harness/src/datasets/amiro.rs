//! Drives of the AMiRo: recordings of the link's frames (`.ipf`), and AMiRo's own text.
//!
//! The inputs of a recording pass through the step scheduler of the node, under the
//! configuration of the recording, or the default where it has none. Each step gives its
//! pose and one scan of all eight sensors: the records that the inverse sensor models of
//! a comparison get. What a board answered is not read; with a profile, the filter of the
//! host runs and its outcomes follow each scan.
//!
//! A step lies 10 mm behind the one before: every step is mapped unless the user asks
//! otherwise, and cells have 10 mm.

use std::path::Path;

use amiro_ipf::node::{Config, Input};

use super::error::shown;
use super::{
    Dataset, DatasetError, DriveFile, PoseSource, ReadRows, RefusedRow, RefusedRows, UsualMapping,
};
use crate::drive::{FilterRecords, InputCheck, Keyframes, Record, StepRecords, replayed_config};
use crate::log::{Format, Refusals, StoredRecording, head_of, is_of_an_amiro};
use crate::rig::Rig;
use crate::world::{Scenario, TrueWorld};
use crate::{RunOutcome, run_streamed};

/// The format; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Amiro;

/// Greatest distance of a mount of the rig from where the configuration has it, metres.
const SAME_PLACE_M: f64 = 1e-3;

/// Greatest angle between the axes of the two, degrees.
const SAME_AXIS_DEG: f64 = 1.0;

impl Dataset for Amiro {
    fn name(&self) -> &'static str {
        "amiro"
    }

    fn looks_for(&self) -> &'static str {
        "a file with frames of the link or AMiRo's text"
    }

    /// Every step, and cells of 10 mm.
    fn usual(&self) -> UsualMapping {
        UsualMapping {
            keyframes: Keyframes::new(0.0, 0.0),
            cell_mm: 10,
        }
    }

    fn usual_rig(&self) -> Option<&'static str> {
        Some(include_str!("../../../rigs/amiro.toml"))
    }

    /// The scenario of a simulated drive.
    fn true_world(&self, path: &Path) -> Result<Option<TrueWorld>, DatasetError> {
        let recording = StoredRecording::open(path, |_, _| {})?;
        let truth = recording.overview().truth.as_ref();
        let text = truth.and_then(|truth| truth.scenario.as_deref());
        let scenario = text.map(Scenario::parse).transpose();
        let scenario = scenario.map_err(|source| DatasetError::Scenario {
            file: shown(path),
            source,
        })?;
        Ok(scenario.map(|it| TrueWorld::Scenario(Box::new(it))))
    }

    fn recognises(&self, path: &Path) -> bool {
        path.is_file() && head_of(path).is_ok_and(|head| is_of_an_amiro(&head))
    }

    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError> {
        let file = shown(drive.path);
        if drive.poses != PoseSource::Odometry {
            let wanted = drive.poses;
            return Err(DatasetError::NoSuchPoses { file, wanted });
        }
        // Read twice: for its overview, then for its inputs.
        let mut recording = StoredRecording::open(drive.path, |bytes, length| {
            on_bytes(bytes, length.map(|length| 2 * length));
        })?;
        let overview = recording.overview();
        let mut config = replayed_config(overview.config.unwrap_or_default());
        if let Some(calibration) = &drive.calibration {
            calibration.apply(&mut config);
        }
        let mut notes = check_rig(drive.rig, &config)?;
        let refused = refused_rows(&file, &overview.refusals);
        let (format, inputs) = (overview.format, overview.inputs);
        let length = recording.length();
        let mut check = InputCheck::default();
        let mut rows = recording.inputs(|bytes| on_bytes(length + bytes, Some(2 * length)))?;
        let inputs_read = rows.by_ref().inspect(|input| check.take(input));
        let outcome = match drive.profile {
            Some(profile) => {
                config.parameters = profile.parameters();
                let mut records = FilterRecords::new(&config);
                let run = run_streamed(
                    &config,
                    inputs_read,
                    |event| records.translate(event, take),
                    |_, _| {},
                );
                run.map_err(|source| DatasetError::Run {
                    file: file.clone(),
                    source,
                })?
            }
            None => steps_of(config, inputs_read, take),
        };
        rows.finish()?;
        if let Some(reason) = check.finish(&config, outcome.steps.into(), outcome.faults()) {
            return Err(DatasetError::NoSteps { file, reason });
        }
        let refusal = |(fault, count)| format!("{count} inputs refused: {fault:?}, {fault}");
        notes.extend(outcome.faults().map(refusal));
        Ok(ReadRows {
            used: match format {
                // A row is a reading and a pose.
                Format::AmiroText => check.readings() as u64,
                Format::Stream => inputs,
            },
            refused,
            notes,
        })
    }
}

/// The records of the steps alone, without a filter.
fn steps_of(
    config: Config,
    inputs: impl Iterator<Item = Input>,
    take: &mut dyn FnMut(&Record),
) -> RunOutcome {
    let mut steps = StepRecords::new(config);
    let mut outcome = RunOutcome::default();
    for input in inputs {
        if let Err(fault) = steps.take(&input, take) {
            outcome.count(fault);
        }
    }
    outcome.steps = steps.steps();
    outcome
}

fn refused_rows(file: &str, refusals: &Refusals) -> RefusedRows {
    let first = refusals.first().iter().map(|refusal| RefusedRow {
        file: file.to_owned(),
        place: refusal.place,
        reason: refusal.text.clone(),
    });
    RefusedRows {
        count: refusals.count(),
        first: first.collect(),
    }
}

/// Eight infrared sensors where the configuration has them; a note for another law.
fn check_rig(rig: &Rig, config: &Config) -> Result<Vec<String>, DatasetError> {
    let recorded = Rig::from(config);
    let error = |needed: String| DatasetError::Rig {
        rig: rig.name.clone(),
        needed,
    };
    let count = recorded.mounts.len();
    let infrared = rig.mounts.iter().take(count);
    if infrared.filter(|mount| mount.sensor.is_infrared()).count() < count {
        let needed = format!("the recording needs {count} infrared sensors, in this order");
        return Err(error(needed));
    }
    let beyond: Vec<_> = rig.mounts.iter().skip(count).collect();
    if !beyond.is_empty() {
        let names: Vec<_> = beyond.iter().map(|mount| mount.name.as_str()).collect();
        return Err(error(format!(
            "the recording needs {count} infrared sensors, in this order, and has no data for {}",
            names.join(", ")
        )));
    }
    let mut has_same_law = true;
    for (mount, recorded) in rig.mounts.iter().zip(&recorded.mounts) {
        let (found, expected) = (&mount.body_from_sensor, &recorded.body_from_sensor);
        let off_m = (found.position - expected.position).norm();
        let off_deg = found.turn_to(expected).to_degrees();
        if off_m > SAME_PLACE_M || off_deg > SAME_AXIS_DEG {
            return Err(error(format!(
                "{} is {:.0} mm and {off_deg:.0} degrees from where the recording has it",
                mount.name,
                1e3 * off_m
            )));
        }
        has_same_law &= mount.sensor == recorded.sensor;
    }
    let note = "ranges are computed by the recording's law, footprints by the rig's, which differs";
    Ok((!has_same_law)
        .then(|| note.to_owned())
        .into_iter()
        .collect())
}
