//! A drive through a mapping method: the one place where records become a map.
//!
//! Records come from one of three sources: a dataset ([`dataset_records`]), the inverse
//! particle filter over an AMiRo's inputs ([`filter_records`]), or the steps of an AMiRo
//! without a filter ([`step_records`]). [`run`] passes them through a mapper.

mod drive;

pub use drive::{
    DriveFigures, DriveOptions, DriveSummary, KeyframeShare, NothingMapped, dataset_records,
};

use amiro_ipf::node::{Config, Input};

use crate::drive::{FilterRecords, Record, StepRecords};
use crate::mapping::{FinishProgress, Mapper, Method};
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
    run_with_progress(source, mapper, watch, &mut |_| {})
}

/// As [`run`](self::run()); `progress` is called while the map is finished.
///
/// # Errors
/// As [`run`](self::run()).
pub fn run_with_progress<T, E>(
    source: impl FnOnce(&mut dyn FnMut(&Record)) -> Result<T, E>,
    mapper: &mut dyn Mapper,
    watch: &mut dyn FnMut(&Record, &dyn Mapper),
    progress: &mut dyn FnMut(FinishProgress),
) -> Result<T, E> {
    let result = source(&mut |record| {
        watch(record, mapper);
        mapper.take(record);
    })?;
    mapper.finish(progress);
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
    let mut records = FilterRecords::new(config);
    crate::run(config, inputs, |event| records.translate(event, take))
}

/// Records of the same steps without the filter: pose and scan of each.
///
/// The inputs pass through the step scheduler of the node ([`StepRecords`]); no particle
/// exists.
///
/// # Errors
/// A parameter of the configuration is outside its range.
pub fn step_records(
    config: &Config,
    inputs: &[Input],
    take: &mut dyn FnMut(&Record),
) -> Result<RunOutcome, RunError> {
    config.validate()?;
    let mut steps = StepRecords::new(*config);
    let mut outcome = RunOutcome::default();
    for (index, input) in inputs.iter().enumerate() {
        if let Err(fault) = steps.take(input, take) {
            outcome.refuse(index, fault);
        }
    }
    outcome.steps = steps.steps();
    Ok(outcome)
}
