//! What of a recorded drive is mapped: the keyframes, and the mounts asked for.

use serde::Serialize;

use crate::datasets::{Dataset, DatasetError, DriveFile, RefusedRows};
use crate::drive::{Keyframes, RangeScan, Record, Return};
use crate::geometry::Vector;
use crate::mapping::{Map, Occupancy};
use crate::rig::Rig;

/// What of a recorded drive is mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveOptions {
    /// Poses that are mapped.
    pub keyframes: Keyframes,
    /// Which of the keyframes.
    pub share: KeyframeShare,
    /// Of each mount of the rig, whether its scans are mapped; mounts beyond are not.
    pub mounts: Vec<bool>,
}

impl DriveOptions {
    fn wants(&self, mount: usize) -> bool {
        self.mounts.get(mount).copied().unwrap_or(false)
    }
}

/// Which keyframes of a drive are mapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeyframeShare {
    /// All.
    #[default]
    All,
    /// The first, the third, and so on.
    Even,
    /// The second, the fourth, and so on.
    Odd,
}

impl KeyframeShare {
    /// Whether it has the keyframe of a number, from 0.
    const fn has(self, number: u64) -> bool {
        match self {
            Self::All => true,
            Self::Even => number.is_multiple_of(2),
            Self::Odd => !number.is_multiple_of(2),
        }
    }
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
    /// Length of the path through the poses, metres, without resets of the odometry.
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
    /// The places to which the robot did not drive from the place before, by index.
    pub jumps: Vec<usize>,
    /// Rows that were used.
    pub used_rows: u64,
    /// Rows that were refused.
    pub refused: RefusedRows,
    /// Names of the mounts that were asked for and have no scan in the recording.
    pub mounts_without_data: Vec<String>,
    /// What else the user should know, a line each.
    pub notes: Vec<String>,
}

/// Why no cell of a drive's map is known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NothingMapped {
    /// No mount that was asked for has a scan.
    #[error("the recording has no data for {0}")]
    NoScan(String),
    /// No return is a measurement.
    #[error("all {0} returns are invalid or too close")]
    Invalid(u64),
    /// The method takes no evidence from returns without an echo.
    #[error("all {0} returns are without an echo, of which the method maps nothing")]
    NoEcho(u64),
    /// The echoes lie where the map cannot reach, or weigh nothing.
    #[error("the method maps nothing of {0} returns with an echo")]
    Echoes(u64),
}

impl DriveSummary {
    /// Checks that there is a map to write.
    ///
    /// # Errors
    /// Why no cell is known.
    pub fn check(&self, map: &Map) -> Result<(), NothingMapped> {
        if map.count(Occupancy::Occupied) + map.count(Occupancy::Free) > 0 {
            return Ok(());
        }
        let figures = &self.figures;
        Err(match (figures.echoes, figures.no_echoes, figures.invalid) {
            (0, 0, 0) => NothingMapped::NoScan(self.mounts_without_data.join(", ")),
            (0, 0, invalid) => NothingMapped::Invalid(invalid),
            (0, no_echoes, _) => NothingMapped::NoEcho(no_echoes),
            (echoes, ..) => NothingMapped::Echoes(echoes),
        })
    }
}

/// Records of a dataset's keyframes: their poses, the scans of the mounts asked for, and
/// every reset of the odometry, behind which the next pose is a keyframe.
///
/// `on_bytes` is that of [`Dataset::read`]. Memory: one row of the recording, and a place
/// per keyframe.
///
/// # Errors
/// As [`Dataset::read`].
pub fn dataset_records(
    dataset: &dyn Dataset,
    drive: &DriveFile<'_>,
    options: &DriveOptions,
    on_bytes: &mut dyn FnMut(u64, Option<u64>),
    take: &mut dyn FnMut(&Record),
) -> Result<DriveSummary, DatasetError> {
    let mut selection = DriveSelection::new(drive.rig, options);
    let rows = dataset.read(drive, on_bytes, &mut |record| selection.take(record, take))?;
    let DriveSelection {
        mut figures,
        places,
        jumps,
        has_data,
        ..
    } = selection;
    figures.refused_rows = rows.refused.count;
    let mounts = drive.rig.mounts.iter().zip(has_data).enumerate();
    let silent = mounts.filter(|(index, (_, has_data))| !has_data && options.wants(*index));
    Ok(DriveSummary {
        figures,
        path: places,
        jumps,
        used_rows: rows.used,
        refused: rows.refused,
        notes: rows.notes,
        mounts_without_data: silent.map(|(_, (mount, _))| mount.name.clone()).collect(),
    })
}

/// How far the selection of a drive's records has come.
struct DriveSelection<'a> {
    rig: &'a Rig,
    options: &'a DriveOptions,
    keyframes: Keyframes,
    is_keyframe: bool,
    /// Keyframes so far, of whatever share.
    keyframes_so_far: u64,
    /// Whether the odometry was reset since the last keyframe.
    is_reset: bool,
    last: Option<Vector>,
    figures: DriveFigures,
    places: Vec<(f64, f64)>,
    jumps: Vec<usize>,
    /// Whether a mount of the rig has had a scan.
    has_data: Vec<bool>,
}

impl<'a> DriveSelection<'a> {
    fn new(rig: &'a Rig, options: &'a DriveOptions) -> Self {
        Self {
            rig,
            options,
            keyframes: options.keyframes,
            is_keyframe: false,
            keyframes_so_far: 0,
            is_reset: false,
            last: None,
            figures: DriveFigures::default(),
            places: Vec::new(),
            jumps: Vec::new(),
            has_data: vec![false; rig.mounts.len()],
        }
    }

    fn take(&mut self, record: &Record, take: &mut dyn FnMut(&Record)) {
        match record {
            Record::Pose {
                world_from_body, ..
            } => {
                let place = world_from_body.position;
                self.figures.poses += 1;
                self.figures.path_m += self.last.map_or(0.0, |last| (place - last).norm());
                self.last = Some(place);
                self.is_keyframe = self.keyframes.take(world_from_body) && self.next_is_wanted();
                if self.is_keyframe {
                    self.add_place(place);
                    take(record);
                }
            }
            Record::OdometryReset { .. } => {
                self.last = None;
                self.is_reset = true;
                self.is_keyframe = false;
                self.keyframes = self.options.keyframes;
                take(record);
            }
            Record::Scan(scan) => self.take_scan(scan, take),
            Record::Outcomes(_) if self.is_keyframe => take(record),
            Record::Outcomes(_) => {}
        }
    }

    /// Counts a keyframe; whether it is among those to be mapped.
    fn next_is_wanted(&mut self) -> bool {
        let number = self.keyframes_so_far;
        self.keyframes_so_far += 1;
        self.options.share.has(number)
    }

    fn add_place(&mut self, place: Vector) {
        if std::mem::take(&mut self.is_reset) && !self.places.is_empty() {
            self.jumps.push(self.places.len());
        }
        self.figures.keyframes += 1;
        self.places.push((place.x, place.y));
    }

    /// Hands on the part of a scan that is of mounts asked for, neighbours together.
    fn take_scan(&mut self, scan: &RangeScan, take: &mut dyn FnMut(&Record)) {
        let mut next = 0;
        let mut part: Option<RangeScan> = None;
        for index in scan.mounts.clone() {
            let Some(mount) = self.rig.mounts.get(index) else {
                break;
            };
            let first = next;
            next = (first + mount.sensor.model().returns()).min(scan.returns.len());
            if let Some(has_data) = self.has_data.get_mut(index) {
                *has_data = true;
            }
            if !self.is_keyframe {
                continue;
            }
            if !self.options.wants(index) {
                self.hand_on(part.take(), take);
                continue;
            }
            let part = part.get_or_insert_with(|| RangeScan {
                mounts: index..index,
                returns: Vec::new(),
                signals: Vec::new(),
                ..*scan
            });
            part.mounts.end = index + 1;
            let of_mount = first..next;
            let returns = scan.returns.get(of_mount.clone());
            part.returns.extend(returns.into_iter().flatten());
            let signals = scan.signals.get(of_mount);
            part.signals.extend(signals.into_iter().flatten());
        }
        self.hand_on(part, take);
    }

    fn hand_on(&mut self, scan: Option<RangeScan>, take: &mut dyn FnMut(&Record)) {
        if let Some(scan) = scan {
            self.figures.count(&scan.returns);
            take(&Record::Scan(scan));
        }
    }
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
