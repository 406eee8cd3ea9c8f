//! A recorded drive through a mapping method, in one pass and bounded memory.

use std::path::Path;

use serde::Serialize;

use crate::datasets::{Dataset, DatasetError, PoseSource, RefusedRows};
use crate::drive::{Keyframes, Record, Return, Scan};
use crate::mapping::RangeInverseSensorMapper;
use crate::rig::Rig;

/// What of a drive is mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveOptions {
    /// Which poses of the recording are believed.
    pub poses: PoseSource,
    /// Poses that are mapped.
    pub keyframes: Keyframes,
    /// Only mounts whose names begin with one of these; empty for all.
    pub mounts: Vec<String>,
}

/// A drive in figures.
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

/// What came of a drive.
#[derive(Clone, Debug)]
pub struct DriveRun {
    /// The drive in figures.
    pub figures: DriveFigures,
    /// The robot's places at the keyframes, metres.
    pub path: Vec<(f64, f64)>,
    /// What was refused.
    pub refused: RefusedRows,
}

/// Reads a drive and maps its keyframes.
///
/// Memory: the map, one row of the recording, and a place per keyframe.
///
/// # Errors
/// As [`Dataset::read`].
pub fn run(
    dataset: &dyn Dataset,
    path: &Path,
    rig: &Rig,
    options: &DriveOptions,
    mapper: &mut RangeInverseSensorMapper,
) -> Result<DriveRun, DatasetError> {
    let mut keyframes = options.keyframes;
    let mut figures = DriveFigures::default();
    let mut way: Vec<(f64, f64)> = Vec::new();
    let mut last = None;
    let mut is_keyframe = false;
    let refused = dataset.read(path, rig, options.poses, &mut |record| match record {
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
                way.push((place.x, place.y));
            }
        }
        Record::Scan(scan) if is_keyframe && is_wanted(rig, scan, &options.mounts) => {
            figures.count(&scan.returns);
            mapper.take(rig, scan);
        }
        Record::Scan(_) => {}
    })?;
    figures.refused_rows = refused.count;
    Ok(DriveRun {
        figures,
        path: way,
        refused,
    })
}

/// Whether a scan is of mounts that are to be mapped: its first mount decides.
fn is_wanted(rig: &Rig, scan: &Scan, names: &[String]) -> bool {
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
