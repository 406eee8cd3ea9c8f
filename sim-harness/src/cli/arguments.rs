//! Values of the command line that several commands take.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use sim_harness::calibration::GainFile;
use sim_harness::drive::RingCalibration;
use sim_harness::mapping::Method;
use sim_harness::output;

/// Most drives, so that a typing error ends at once and not tomorrow.
pub(super) const MAX_DRIVES: u64 = 100_000;

/// A path to write to. `-` is refused: it stands for standard output elsewhere, and here
/// it would be a file of that name.
pub(super) fn path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        if path.as_os_str() == "-" {
            return Err("standard output is not written to; ./- is a file of that name");
        }
        Ok(path)
    })
}

/// Alpha and gains of the file of `--gains`, if one was given.
pub(super) fn calibration(gains: Option<&Path>) -> Result<Option<RingCalibration>, String> {
    let file = gains.map(GainFile::load).transpose();
    let file = file.map_err(|error| format!("--gains: {error}"))?;
    Ok(file.map(|file| file.calibration()))
}

/// A seed of random numbers.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    let refused = |_| format!("a whole number from 0 to {} is expected", u64::MAX);
    text.parse().map_err(refused)
}

/// Seeds from `A..B`, B excluded.
pub(super) fn seeds(text: &str) -> Result<Range<u64>, String> {
    let bounds = text.split_once("..");
    let number = |text: &str| text.parse::<u64>().ok();
    match bounds.and_then(|(first, end)| Some(number(first)?..number(end)?)) {
        Some(seeds) if seeds.is_empty() => Err("A..B is without B: A must be below B".to_owned()),
        Some(seeds) => check_drives(1, &seeds).map(|()| seeds),
        None => Err(format!(
            "two whole numbers A..B from 0 to {} are expected, A below B, such as 100..110",
            u64::MAX
        )),
    }
}

/// The methods in their order, each once.
pub(super) fn distinct(methods: &[Method]) -> Vec<Method> {
    let mut distinct = Vec::new();
    for method in methods {
        if !distinct.contains(method) {
            distinct.push(*method);
        }
    }
    distinct
}

/// Checks how many drives there are of so many scenarios and these seeds.
///
/// # Errors
/// More than [`MAX_DRIVES`].
pub(super) fn check_drives(scenarios: usize, seeds: &Range<u64>) -> Result<(), String> {
    let count = seeds.end.saturating_sub(seeds.start);
    if count.saturating_mul(scenarios as u64) > MAX_DRIVES {
        return Err(format!("{count} seeds: at most {MAX_DRIVES} drives in all"));
    }
    Ok(())
}

/// Checks, before the work, that the file of an option can be written.
pub(super) fn check_file(option: &str, path: &Path) -> Result<(), String> {
    output::check_file(path).map_err(|error| format!("{option}: {error}"))
}

/// Checks, before the work, that files can be written to the folder of an option.
pub(super) fn check_folder(option: &str, path: &Path) -> Result<(), String> {
    output::check_folder(path).map_err(|error| format!("{option}: {error}"))
}

/// The option that sets a parameter of a configuration, if there is one.
pub(super) fn option_of(parameter: &str) -> Option<&'static str> {
    match parameter {
        "particles_per_sensor" => Some("--particles"),
        "sensors" => Some("--mask"),
        "alpha_counts_m2" => Some("--alpha"),
        "x_max_m" => Some("--x-max"),
        _ => None,
    }
}
