//! A drive through a mapping method: the one place where records become a map.
//!
//! Records come from one of three sources: a dataset ([`dataset_records`]), the inverse
//! particle filter over an AMiRo's inputs ([`filter_records`]), or the steps of an AMiRo
//! without a filter ([`step_records`]). [`run`] passes them through a mapper.

use std::path::Path;

use amiro_ipf::node::{Config, Input, Scheduled, StepScheduler};
use serde::Serialize;

use crate::datasets::{Dataset, DatasetError, PoseSource, RefusedRows};
use crate::drive::{FilterRecords, Keyframes, RangeScan, Record, Return, scan_records};
use crate::geometry::Vector;
use crate::mapping::{Mapper, Method};
use crate::rig::Rig;
use crate::{RunError, RunOutcome};

/// Passes all records of a source through a mapper, then finishes the map.
///
/// `watch` sees each record and the map as it was before that record.
///
/// # Errors
/// Those of the source; the map then holds the records before the error.
pub fn run<T, E>(
    source: impl FnOnce(&mut dyn FnMut(&Record)) -> Result<T, E>,
    mapper: &mut dyn Mapper,
    watch: &mut dyn FnMut(&Record, &dyn Mapper),
) -> Result<T, E> {
    let result = source(&mut |record| {
        watch(record, mapper);
        mapper.take(record);
    })?;
    mapper.finish();
    Ok(result)
}

/// Records of an AMiRo's drive as a method needs them: those of the filter, or of its
/// steps alone.
///
/// The configuration is that of the method's profile.
///
/// # Errors
/// As [`run`](crate::run()).
pub fn records(
    method: &Method,
    config: &Config,
    inputs: &[Input],
    take: &mut dyn FnMut(&Record),
) -> Result<RunOutcome, RunError> {
    match method.profile {
        Some(_) => filter_records(config, inputs, take),
        None => step_records(config, inputs, take),
    }
}

/// Records of the inverse particle filter over a drive's inputs: for each step its pose,
/// its scan and the outcomes of its particles.
///
/// # Errors
/// As [`run`](crate::run()).
pub fn filter_records(
    config: &Config,
    inputs: &[Input],
    take: &mut dyn FnMut(&Record),
) -> Result<RunOutcome, RunError> {
    let mut records = FilterRecords::new(config.photometry);
    crate::run(config, inputs, |event| records.translate(event, take))
}

/// Records of the same steps without the filter: pose and scan of each.
///
/// The inputs pass through the [`StepScheduler`] of the node; no particle exists.
///
/// # Errors
/// A parameter of the configuration is outside its range.
pub fn step_records(
    config: &Config,
    inputs: &[Input],
    take: &mut dyn FnMut(&Record),
) -> Result<RunOutcome, RunError> {
    config.validate()?;
    let mut scheduler = StepScheduler::default();
    let mut outcome = RunOutcome::default();
    for (index, input) in inputs.iter().enumerate() {
        match scheduler.take(config, input) {
            Ok(Scheduled::Nothing) => {}
            Ok(Scheduled::OdometryReset { stamp_us }) => take(&Record::OdometryReset { stamp_us }),
            Ok(Scheduled::Step(step)) => {
                outcome.steps += 1;
                let photometry = &config.photometry;
                scan_records(photometry, step.stamp_us, step.pose, &step.samples)
                    .iter()
                    .for_each(&mut *take);
            }
            Err(fault) => outcome.refuse(index, fault),
        }
    }
    Ok(outcome)
}

/// What of a recorded drive is mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveOptions {
    /// Which poses of the recording are used.
    pub poses: PoseSource,
    /// Poses that are mapped.
    pub keyframes: Keyframes,
    /// Only mounts whose names begin with one of these; empty for all.
    pub mounts: Vec<String>,
}

/// A recorded drive in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DriveFigures {
    /// Poses of the recording.
    pub poses: u64,
    /// Poses that were mapped.
    pub keyframes: u64,
    /// Returns of the keyframes with an echo.
    pub echoes: u64,
    /// Returns of the keyframes without one.
    pub no_echoes: u64,
    /// Returns of the keyframes that are no measurement, or too close for one.
    pub invalid: u64,
    /// Length of the path through the poses, metres.
    pub path_m: f64,
    /// Rows of the recording that were refused.
    pub refused_rows: u64,
}

/// What was read of a recorded drive.
#[derive(Clone, Debug)]
pub struct DriveSummary {
    /// The drive in numbers.
    pub figures: DriveFigures,
    /// The robot's places at the keyframes, metres.
    pub path: Vec<(f64, f64)>,
    /// Rows that were refused.
    pub refused: RefusedRows,
}

/// Records of a dataset's keyframes: their poses, and the scans of the mounts asked for.
///
/// Memory: one row of the recording, and a place per keyframe.
///
/// # Errors
/// As [`Dataset::read`].
pub fn dataset_records(
    dataset: &dyn Dataset,
    path: &Path,
    rig: &Rig,
    options: &DriveOptions,
    take: &mut dyn FnMut(&Record),
) -> Result<DriveSummary, DatasetError> {
    let mut keyframes = options.keyframes;
    let mut figures = DriveFigures::default();
    let mut places: Vec<(f64, f64)> = Vec::new();
    let mut last: Option<Vector> = None;
    let mut is_keyframe = false;
    let refused = dataset.read(path, rig, options.poses, &mut |record| {
        match record {
            Record::Pose {
                world_from_body, ..
            } => {
                let place = world_from_body.position;
                figures.poses += 1;
                figures.path_m += last.map_or(0.0, |last| (place - last).norm());
                last = Some(place);
                is_keyframe = keyframes.take(world_from_body);
                if is_keyframe {
                    figures.keyframes += 1;
                    places.push((place.x, place.y));
                }
            }
            Record::Scan(scan) if is_keyframe && is_wanted(rig, scan, &options.mounts) => {
                figures.count(&scan.returns);
            }
            Record::Scan(_) => return,
            Record::OdometryReset { .. } | Record::Outcomes(_) => {}
        }
        if is_keyframe {
            take(record);
        }
    })?;
    figures.refused_rows = refused.count;
    Ok(DriveSummary {
        figures,
        path: places,
        refused,
    })
}

/// Whether a scan is of mounts that are to be mapped: its first mount decides.
fn is_wanted(rig: &Rig, scan: &RangeScan, names: &[String]) -> bool {
    let first = rig.mounts.get(scan.mounts.start);
    names.is_empty()
        || first.is_some_and(|mount| names.iter().any(|name| mount.name.starts_with(name)))
}

impl DriveFigures {
    fn count(&mut self, returns: &[Return]) {
        for measured in returns {
            *match measured {
                Return::Echo { .. } => &mut self.echoes,
                Return::NoEcho { .. } => &mut self.no_echoes,
                Return::TooClose | Return::Invalid => &mut self.invalid,
            } += 1;
        }
    }
}
