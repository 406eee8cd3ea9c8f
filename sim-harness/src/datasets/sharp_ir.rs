//! Sweeps of one infrared range sensor on a servo.
//!
//! The sensor stands and turns: each reading is a pose at the origin with the heading of
//! the servo, and one return of a scanner of one beam. Two kinds of file:
//!
//! | file | content |
//! |---|---|
//! | `test2d.csv` of the repository DIY-3D-Scanner | two lines of as many numbers: x, then y \[cm\], a reading per column, 100 ms apart |
//! | `data.txt` of the repository 3dscanner | a JSON list of rows of 60 distances \[cm\], 50 ms apart, one degree from one to the next; 114.4273 is no echo |
//!
//! A row of `data.txt` is one tilt of the sensor; tilts are not read. The servo sweeps from
//! 60 to 119 degrees and back, so in every second row the first distance is that at 119
//! degrees. Between two rows the odometry is reset: they are sweeps at different heights.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::error::shown;
use super::fields::measured_m;
use super::lines::Lines;
use super::number_rows::NumberRows;
use super::{Dataset, DatasetError, DriveFile, PoseSource, ReadRows, UsualMapping};
use crate::drive::{Keyframes, RangeScan, Record, Return};
use crate::geometry::Pose2;
use crate::rig::Rig;
use crate::sensors::{RangeSensor, Scanner, Sensor};

/// The format; see the module.
#[derive(Clone, Copy, Debug)]
pub struct SharpIr;

/// Distances of a row of the list, and the servo's angle at the first and per step, degrees.
const ROW: usize = 60;
const FIRST_DEG: f64 = 60.0;
const STEP_DEG: f64 = 1.0;

/// What the list has without an echo, and a distance that is no measurement, centimetres.
const NO_ECHO_CM: f64 = 114.4273;
const MAX_CM: f64 = 10_000.0;

/// Time from one reading to the next, microseconds.
const POINT_US: u64 = 100_000;
const ROW_READING_US: u64 = 50_000;

/// Bytes of a file that are looked at to recognise it: the points of a sweep fit.
const HEAD: u64 = 1 << 16;

/// What a file of the format holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SweepFile {
    /// Two lines: x and y.
    Points,
    /// A list of rows of distances.
    Rows,
}

impl Dataset for SharpIr {
    fn name(&self) -> &'static str {
        "sharp_ir"
    }

    fn looks_for(&self) -> &'static str {
        "a file with two lines of as many numbers, or with a JSON list of rows of distances"
    }

    /// Every reading, and cells of 10 mm.
    fn usual(&self) -> UsualMapping {
        UsualMapping {
            keyframes: Keyframes::new(0.0, 0.0),
            cell_mm: 10,
        }
    }

    fn usual_rig(&self) -> Option<&'static str> {
        Some(include_str!("../../../rigs/sharp_ir.toml"))
    }

    fn recognises(&self, path: &Path) -> bool {
        sweep_file(path).is_some()
    }

    /// Memory: a line, or a row of distances.
    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError> {
        let file = shown(drive.path);
        let scanner = scanner_of(drive.rig)?;
        if drive.poses != PoseSource::Odometry {
            let wanted = drive.poses;
            return Err(DatasetError::NoSuchPoses { file, wanted });
        }
        let mut sweep = SweepOutput {
            scanner,
            stamp_us: 0,
            take,
        };
        let rows = match sweep_file(drive.path) {
            Some(SweepFile::Points) => points(drive.path, on_bytes, &mut sweep)?,
            Some(SweepFile::Rows) => distances(drive.path, on_bytes, &mut sweep)?,
            None => ReadRows::default(),
        };
        if rows.used == 0 {
            return Err(DatasetError::NoRow {
                file,
                format: self.name(),
                rows: rows.refused,
            });
        }
        Ok(rows)
    }
}

fn sweep_file(path: &Path) -> Option<SweepFile> {
    let file = path.is_file().then(|| File::open(path).ok())??;
    let mut head = Vec::new();
    file.take(HEAD).read_to_end(&mut head).ok()?;
    let text = head.trim_ascii_start();
    if text
        .strip_prefix(b"[")
        .is_some_and(|rest| rest.trim_ascii_start().starts_with(b"["))
    {
        return Some(SweepFile::Rows);
    }
    let text = core::str::from_utf8(text).ok()?;
    let numbers = |line: &str| {
        let mut fields = line.split(',').map(str::trim);
        let count = fields.clone().count();
        fields
            .all(|field| field.parse::<f64>().is_ok())
            .then_some(count)
    };
    let counts: Option<Vec<usize>> = text.trim_ascii_end().lines().map(numbers).collect();
    let is_points = counts.is_some_and(|counts| matches!(counts[..], [x, y] if x == y && x > 1));
    is_points.then_some(SweepFile::Points)
}

/// Hands on readings with their stamps.
struct SweepOutput<'a> {
    scanner: &'a Scanner,
    stamp_us: u64,
    take: &'a mut dyn FnMut(&Record),
}

impl SweepOutput<'_> {
    fn reading(&mut self, bearing_rad: f64, measured: Return, period_us: u64) {
        let (stamp_us, world_from_body) = (self.stamp_us, Pose2::new(0.0, 0.0, bearing_rad));
        (self.take)(&Record::Pose {
            stamp_us,
            world_from_body,
        });
        (self.take)(&Record::Scan(RangeScan {
            stamp_us,
            world_from_body,
            mounts: 0..1,
            returns: vec![measured],
            signals: Vec::new(),
        }));
        self.stamp_us += period_us;
    }

    fn measured(&self, range_cm: f64) -> Return {
        measured_m(1e-2 * range_cm, self.scanner.range_m, self.scanner.sigma_m)
    }
}

/// The two lines of points; a reading is refused for its number in either line.
fn points(
    path: &Path,
    on_bytes: &mut dyn FnMut(u64, Option<u64>),
    sweep: &mut SweepOutput<'_>,
) -> Result<ReadRows, DatasetError> {
    let mut rows = ReadRows::default();
    let mut lines = [Lines::open(path)?, Lines::open(path)?];
    let [first, second] = &mut lines;
    first.advance()?;
    second.advance()?;
    second.advance()?;
    let (x_cm, y_cm) = match (first.text(), second.text()) {
        (Ok(x_cm), Ok(y_cm)) => (x_cm, y_cm),
        (x_cm, y_cm) => {
            for row in [x_cm.err(), y_cm.err()].into_iter().flatten() {
                rows.refused.add(row);
            }
            return Ok(rows);
        }
    };
    let number = |field: &str| {
        let value = field.trim().parse().ok();
        value.filter(|value: &f64| value.abs() <= MAX_CM)
    };
    for (index, (x, y)) in x_cm.split(',').zip(y_cm.split(',')).enumerate() {
        let place = index + 1;
        match (number(x), number(y)) {
            (Some(x), Some(y)) if y >= 0.0 => {
                rows.used += 1;
                let measured = sweep.measured((x * x + y * y).sqrt());
                sweep.reading(libm::atan2(y, x), measured, POINT_US);
            }
            (Some(_), Some(_)) => rows
                .refused
                .add(second.refused(format!("value {place} is behind the sensor"))),
            (None, _) => rows
                .refused
                .add(first.refused(format!("value {place} is no distance"))),
            (_, None) => rows
                .refused
                .add(second.refused(format!("value {place} is no distance"))),
        }
    }
    let (read, length) = second.progress();
    on_bytes(read, length);
    Ok(rows)
}

/// The rows of the list, every second one from its end.
fn distances(
    path: &Path,
    on_bytes: &mut dyn FnMut(u64, Option<u64>),
    sweep: &mut SweepOutput<'_>,
) -> Result<ReadRows, DatasetError> {
    let mut rows = ReadRows::default();
    let mut list = NumberRows::open(path, ROW)?;
    let is_distance = |value: &f64| (0.0..=MAX_CM).contains(value);
    for number in 0_u64.. {
        let row = match list.advance()? {
            None => break,
            Some(Err(row)) => {
                rows.refused.add(row);
                continue;
            }
            Some(Ok(row)) if !row.iter().all(is_distance) => {
                let reason = format!("a distance is not 0 to {MAX_CM} cm");
                rows.refused.add(list.refused(reason));
                continue;
            }
            Some(Ok(row)) => row,
        };
        if rows.used > 0 {
            (sweep.take)(&Record::OdometryReset {
                stamp_us: sweep.stamp_us,
            });
        }
        rows.used += 1;
        for (index, range_cm) in row.into_iter().enumerate() {
            let steps = if number % 2 == 0 {
                index
            } else {
                ROW - 1 - index
            };
            let bearing_rad = (FIRST_DEG + STEP_DEG * steps as f64).to_radians();
            let measured = if range_cm >= NO_ECHO_CM {
                Return::NoEcho {
                    limit_m: (1e-2 * NO_ECHO_CM).min(sweep.scanner.range_m[1]),
                    sigma_m: sweep.scanner.sigma_m,
                }
            } else {
                sweep.measured(range_cm)
            };
            sweep.reading(bearing_rad, measured, ROW_READING_US);
        }
        let (read, length) = list.progress();
        on_bytes(read, length);
    }
    Ok(rows)
}

/// One scanner of one beam.
fn scanner_of(rig: &Rig) -> Result<&Scanner, DatasetError> {
    match &rig.mounts[..] {
        [mount] => match &mount.sensor {
            Sensor::Scanner(scanner) if scanner.returns() == 1 => Ok(scanner),
            _ => Err(refused_rig(rig)),
        },
        _ => Err(refused_rig(rig)),
    }
}

fn refused_rig(rig: &Rig) -> DatasetError {
    DatasetError::Rig {
        rig: rig.name.clone(),
        needed: "the recording needs one scanner of one beam, and no other sensor".to_owned(),
    }
}
