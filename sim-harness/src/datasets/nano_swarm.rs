//! Scans of small drones with four time-of-flight sensors, as the repository
//! ETH-PBL/Nano_Swarm_Mapping records them.
//!
//! A drive is a folder of text files without a header, a row per scan. A scan is 15 frames
//! while the drone turns by 45 degrees; its key is `drone/scan`.
//!
//! | file | row |
//! |---|---|
//! | `scans.csv` | key, 1144 bytes in hexadecimal |
//! | `vicon_poses.csv`, if there is one | key, x \[m\], y \[m\], z \[m\], quaternion w, x, y, z |
//! | `poses.csv`, if there is one | key, x \[m\], y \[m\], heading \[rad\]; of several rows of a key the first is the odometry's, the last is matched |
//!
//! The bytes, little endian: 4 that are not used, then 15 frames of 76. A frame is 4 sensors
//! (front, back, left, right) with 8 int16 each, the distance along the sensor's axis in
//! millimetres, column 0 at the left, negative without a measurement; then three float32, the frame's
//! x, y \[m\] and heading \[rad\] in the body frame of the scan's pose.
//!
//! The range of a beam is d / cos(column). A rig of four cones in place of the four rows
//! gets the shortest range of each row: a wide sensor; a rig may have both, rows first. The drones of a recording are read
//! one after the other, with a reset of the odometry between them. The recording has no
//! time: a frame lasts 2/15 s, and nothing lies between two scans.

mod walls;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use walls::walls_of;

use super::error::shown;
use super::fields::{measured_m, numbers_of};
use super::lines::Lines;
use super::{Dataset, DatasetError, DriveFile, PoseSource, ReadRows, RefusedRow, UsualMapping};
use crate::drive::{Keyframes, RangeScan, Record, Return};
use crate::escape::escaped;
use crate::geometry::{Pose2, Vector};
use crate::rig::{Rig, SensorMount};
use crate::sensors::{RangeSensor, Sensor};
use crate::world::TrueWorld;

/// The format; see the module.
#[derive(Clone, Copy, Debug)]
pub struct NanoSwarm;

/// Sensors of a drone, and columns of a sensor.
const SENSORS: usize = 4;
const COLUMNS: usize = 8;

/// Frames of a scan, and bytes of a frame, of its ranges and before the first frame.
const FRAMES: usize = 15;
const FRAME_BYTES: usize = 76;
const RANGE_BYTES: usize = 2 * SENSORS * COLUMNS;
const HEAD_BYTES: usize = 4;
const SCAN_BYTES: usize = HEAD_BYTES + FRAMES * FRAME_BYTES;

/// Duration of a frame, microseconds: 15 in 2 s.
const FRAME_US: u64 = 133_333;

/// Most poses of a recording; rows beyond are refused.
const MAX_POSES: usize = 1 << 16;

/// Largest coordinate that is believed, metres, and largest heading, radians.
const MAX_M: f64 = 10_000.0;
const MAX_RAD: f64 = 1_000.0;

/// How far the square of a quaternion's norm may be from 1; a recorded one has 0.83.
const NORM_WITHIN: f64 = 0.5;

/// Drone and scan.
type ScanKey = (u16, u16);

impl Dataset for NanoSwarm {
    fn name(&self) -> &'static str {
        "nano_swarm"
    }

    fn looks_for(&self) -> &'static str {
        "a folder with scans.csv, and vicon_poses.csv or poses.csv"
    }

    /// Every frame, and cells of 50 mm.
    fn usual(&self) -> UsualMapping {
        UsualMapping {
            keyframes: Keyframes::new(0.0, 0.0),
            cell_mm: 50,
        }
    }

    fn usual_rig(&self) -> Option<&'static str> {
        Some(include_str!("../../../rigs/nano_swarm_both.toml"))
    }

    fn true_world(&self, path: &Path) -> Result<Option<TrueWorld>, DatasetError> {
        walls_of(path)
    }

    fn recognises(&self, path: &Path) -> bool {
        let has = |name| path.join(name).is_file();
        has("scans.csv") && (has("vicon_poses.csv") || has("poses.csv"))
    }

    /// Memory: a row, and the poses of all scans. Time: one pass per drone, and one before.
    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError> {
        check_rig(drive.rig)?;
        let mut rows = ReadRows::default();
        let poses = poses(drive, &mut rows)?;
        let path = drive.path.join("scans.csv");
        let drones = drones(&path, &poses, &mut rows)?;
        let passes = drones.len() as u64;
        let mut stamp_us = 0;
        for (pass, drone) in drones.into_iter().enumerate() {
            if pass > 0 {
                take(&Record::OdometryReset { stamp_us });
            }
            let mut lines = Lines::open(&path)?;
            while lines.advance()? {
                // A row that is refused was counted in the pass before.
                let Some(scan) = scan(&lines, &poses).ok().filter(|scan| scan.0.0 == drone) else {
                    continue;
                };
                rows.used += 1;
                for (world_from_body, ranges) in scan.1 {
                    hand_on(drive.rig, stamp_us, world_from_body, &ranges, take);
                    stamp_us += FRAME_US;
                }
                let (read, length) = lines.progress();
                let whole = |length: u64| length * passes;
                let before = length.map_or(0, |length| length * pass as u64);
                on_bytes(before + read, length.map(whole));
            }
        }
        if rows.used == 0 {
            return Err(DatasetError::NoRow {
                file: shown(&path),
                format: self.name(),
                rows: rows.refused,
            });
        }
        Ok(rows)
    }
}

/// The drones with a scan that can be used; counts the rows that cannot.
fn drones(
    path: &Path,
    poses: &BTreeMap<ScanKey, Pose2>,
    rows: &mut ReadRows,
) -> Result<BTreeSet<u16>, DatasetError> {
    let mut lines = Lines::open(path)?;
    let mut drones = BTreeSet::new();
    while lines.advance()? {
        match scan(&lines, poses) {
            Ok(((drone, _), _)) => {
                drones.insert(drone);
            }
            Err(row) => rows.refused.add(row),
        }
    }
    Ok(drones)
}

/// The poses of the scans by the source that is wanted.
fn poses(
    drive: &DriveFile<'_>,
    rows: &mut ReadRows,
) -> Result<BTreeMap<ScanKey, Pose2>, DatasetError> {
    let is_captured = drive.poses == PoseSource::MotionCapture;
    let path: PathBuf = drive.path.join(if is_captured {
        "vicon_poses.csv"
    } else {
        "poses.csv"
    });
    if !path.is_file() {
        return Err(DatasetError::NoPoses {
            file: shown(&path),
            wanted: drive.poses,
        });
    }
    let mut lines = Lines::open(&path)?;
    let mut poses = BTreeMap::new();
    while lines.advance()? {
        let pose = if is_captured {
            captured_pose(&lines)
        } else {
            planar_pose(&lines)
        };
        match pose {
            Ok((key, _)) if poses.len() >= MAX_POSES && !poses.contains_key(&key) => {
                rows.refused
                    .add(lines.refused(format!("more than {MAX_POSES} poses")));
            }
            Ok((key, pose)) if drive.poses == PoseSource::Matched => {
                poses.insert(key, pose);
            }
            Ok((key, pose)) => {
                poses.entry(key).or_insert(pose);
            }
            Err(row) => rows.refused.add(row),
        }
    }
    Ok(poses)
}

/// A row of `poses.csv`.
fn planar_pose(lines: &Lines) -> Result<(ScanKey, Pose2), RefusedRow> {
    let (key, rest) = keyed(lines)?;
    let [x_m, y_m, heading_rad] = numbers_of(lines, rest, ',')?;
    Ok((key, believed(lines, x_m, y_m, heading_rad)?))
}

/// A row of `vicon_poses.csv`; the heading is the direction of the body's x axis in the plane.
fn captured_pose(lines: &Lines) -> Result<(ScanKey, Pose2), RefusedRow> {
    let (key, rest) = keyed(lines)?;
    let [x_m, y_m, _, w, x, y, z] = numbers_of(lines, rest, ',')?;
    let norm = w * w + x * x + y * y + z * z;
    if (norm - 1.0).abs() > NORM_WITHIN {
        return Err(lines.refused("the norm of the quaternion is not 1".to_owned()));
    }
    // The ratio does not depend on the norm.
    let heading_rad = libm::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
    Ok((key, believed(lines, x_m, y_m, heading_rad)?))
}

fn believed(lines: &Lines, x_m: f64, y_m: f64, heading_rad: f64) -> Result<Pose2, RefusedRow> {
    // NaN is within no bound.
    if x_m.abs() <= MAX_M && y_m.abs() <= MAX_M && heading_rad.abs() <= MAX_RAD {
        return Ok(Pose2::new(x_m, y_m, heading_rad));
    }
    Err(lines.refused(format!(
        "a pose that is not finite, or beyond {MAX_M} m or {MAX_RAD} rad"
    )))
}

/// The key of a row, and what follows it.
fn keyed(lines: &Lines) -> Result<(ScanKey, &str), RefusedRow> {
    let text = lines.text()?;
    let (key, rest) = text.split_once(',').unwrap_or((text, ""));
    let numbers = key.split_once('/').and_then(|(drone, scan)| {
        let drone = drone.trim().parse().ok()?;
        Some((drone, scan.trim().parse().ok()?))
    });
    let shown = || escaped(key.get(..16).unwrap_or(key)).to_string();
    let key = numbers.ok_or_else(|| lines.refused(format!("'{}' is no drone/scan", shown())))?;
    Ok((key, rest))
}

/// Pose and distances of a frame, millimetres.
type FrameRow = (Pose2, [i16; SENSORS * COLUMNS]);

/// The scan of a row of `scans.csv`.
fn scan(
    lines: &Lines,
    poses: &BTreeMap<ScanKey, Pose2>,
) -> Result<(ScanKey, Vec<FrameRow>), RefusedRow> {
    let (key, digits) = keyed(lines)?;
    let bytes = bytes_of(digits).ok_or_else(|| {
        let found = digits.len() / 2;
        lines.refused(if found == SCAN_BYTES && digits.len() % 2 == 0 {
            "no hexadecimal digits".to_owned()
        } else {
            format!("{found} bytes where {SCAN_BYTES} are expected")
        })
    })?;
    let world_from_scan = poses
        .get(&key)
        .ok_or_else(|| lines.refused(format!("no pose for {}/{}", key.0, key.1)))?;
    let frames = bytes[HEAD_BYTES..].chunks_exact(FRAME_BYTES).enumerate();
    let frames = frames.map(|(number, bytes)| {
        let (ranges, pose) = bytes.split_at(RANGE_BYTES);
        let mut millimetres = [0; SENSORS * COLUMNS];
        for (value, bytes) in millimetres.iter_mut().zip(ranges.chunks_exact(2)) {
            *value = i16::from_le_bytes([bytes[0], bytes[1]]);
        }
        let mut values = pose.chunks_exact(4).map(|bytes| {
            let value = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            f64::from(value)
        });
        let [x, y, turn] = [(); 3].map(|()| values.next().unwrap_or(f64::NAN));
        if !(x.abs() <= MAX_M && y.abs() <= MAX_M && turn.abs() <= MAX_RAD) {
            return Err(lines.refused(format!(
                "the pose of frame {number} is not finite or absurd"
            )));
        }
        let place = world_from_scan.place(Vector::new(x, y));
        let heading_rad = world_from_scan.heading_rad() + turn;
        Ok((Pose2::new(place.x, place.y, heading_rad), millimetres))
    });
    Ok((key, frames.collect::<Result<_, _>>()?))
}

/// The bytes of a scan; `None` for another number of digits, and for what is no digit.
fn bytes_of(digits: &str) -> Option<Vec<u8>> {
    let digits = digits.as_bytes();
    if digits.len() != 2 * SCAN_BYTES {
        return None;
    }
    let value = |digit: u8| char::from(digit).to_digit(16);
    let bytes = digits.chunks_exact(2).map(|pair| {
        // Two digits are below 256.
        Some((16 * value(pair[0])? + value(pair[1])?) as u8)
    });
    bytes.collect()
}

fn hand_on(
    rig: &Rig,
    stamp_us: u64,
    world_from_body: Pose2,
    millimetres: &[i16; SENSORS * COLUMNS],
    take: &mut dyn FnMut(&Record),
) {
    take(&Record::Pose {
        stamp_us,
        world_from_body,
    });
    // The cones of a rig with both follow its rows.
    let rows = millimetres.chunks_exact(COLUMNS).cycle();
    let rows = rig.mounts.iter().zip(rows);
    let mut returns = Vec::with_capacity(rig.mounts.len() * COLUMNS);
    for (mount, row) in rows {
        match &mount.sensor {
            Sensor::Scanner(scanner) => returns.extend(row.iter().enumerate().map(|(k, mm)| {
                let bearing_rad = scanner.bearing_rad(k);
                measured(beam_m(*mm, bearing_rad), scanner.range_m, scanner.sigma_m)
            })),
            Sensor::Cone(cone) => {
                let ranges = row.iter().enumerate();
                let ranges = ranges.filter_map(|(k, mm)| beam_m(*mm, bearing_rad(k)));
                let nearest = ranges.reduce(f64::min);
                returns.push(measured(nearest, cone.range_m, cone.sigma_m));
            }
            Sensor::Infrared(_) => {}
        }
    }
    take(&Record::Scan(RangeScan {
        stamp_us,
        world_from_body,
        mounts: 0..rig.mounts.len(),
        returns,
        signals: Vec::new(),
    }));
}

/// Bearing of a column off its sensor's axis, radians: 8 columns in 45 degrees.
fn bearing_rad(column: usize) -> f64 {
    f64::to_radians((3.5 - column as f64) * 45.0 / 8.0)
}

/// Range along a beam, metres, of a distance along the sensor's axis; `None` without one.
fn beam_m(mm: i16, bearing_rad: f64) -> Option<f64> {
    (mm >= 0).then(|| 1e-3 * f64::from(mm) / libm::cos(bearing_rad))
}

fn measured(range_m: Option<f64>, limits_m: [f64; 2], sigma_m: f64) -> Return {
    range_m.map_or(Return::Invalid, |range_m| {
        measured_m(range_m, limits_m, sigma_m)
    })
}

/// Four scanners of 8 columns, or four cones.
fn check_rig(rig: &Rig) -> Result<(), DatasetError> {
    let is_row = |mount: &SensorMount| match &mount.sensor {
        Sensor::Scanner(scanner) => {
            // The range along a beam is d / cos(bearing).
            let bearing_deg = |k: f64| (scanner.first_rad + k * scanner.step_rad).to_degrees();
            scanner.returns() == COLUMNS
                && [0.0, 7.0]
                    .iter()
                    .all(|k| (bearing_deg(*k) - bearing_rad(*k as usize).to_degrees()).abs() <= 1.0)
        }
        _ => false,
    };
    let is_cone = |mount: &SensorMount| matches!(mount.sensor, Sensor::Cone(_));
    let (first, rest) = rig.mounts.split_at(rig.mounts.len().min(SENSORS));
    let has_rows = first.iter().all(is_row);
    let has_cones = |mounts: &[SensorMount]| mounts.iter().all(is_cone);
    if first.len() == SENSORS
        && match rest.len() {
            0 => has_rows || has_cones(first),
            SENSORS => has_rows && has_cones(rest),
            _ => false,
        }
    {
        return Ok(());
    }
    Err(DatasetError::Rig {
        rig: rig.name.clone(),
        needed: format!(
            "the recording needs {SENSORS} scanners of {COLUMNS} beams from 19.7 to -19.7 degrees, \
             or {SENSORS} cones, or both, in the order front, back, left, right"
        ),
    })
}
