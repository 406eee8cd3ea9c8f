//! Indoor runs with eight sonars, a laser and odometry, as K.-C. Ma recorded them.
//!
//! A drive is a folder of text files without a header, values between blanks, one row
//! per instant, the same instants in each file:
//!
//! | file | row |
//! |---|---|
//! | `od.txt` or `poses.txt` | t \[ms\], x \[mm\], y \[mm\], heading \[0.1 degrees, counter-clockwise\] |
//! | `sonar.txt` or `measurement.txt` | t, then 8 ranges \[mm\]; 5110 is no echo |
//! | `laser.txt`, if there is one | t, then 361 ranges \[mm\]; 81910 is no echo |
//! | `matched_poses.csv`, if there is one | t \[s\] from the first row, x \[m\], y \[m\], heading \[rad\], under a header |
//!
//! The first names are those of the repository OccupancyGridMapping, the others those of
//! Udacity's course on mapping, which carries the first run under the MIT licence.

use std::path::{Path, PathBuf};

use super::error::shown;
use super::fields::{measured_m, numbers, ranges, same_stamp};
use super::lines::Lines;
use super::{Dataset, DatasetError, DriveFile, PoseSource, ReadRows, RefusedRow, UsualMapping};
use crate::drive::{Keyframes, RangeScan, Record, Return};
use crate::geometry::Pose2;
use crate::rig::{Rig, SensorMount};
use crate::sensors::Sensor;
use crate::world::TrueWorld;

/// The format; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Kcma;

/// Sonars of a row.
const SONARS: usize = 8;

/// Beams of a row.
const BEAMS: usize = 361;

/// What the sonar gives without an echo, millimetres.
const SONAR_NO_ECHO_MM: f64 = 5110.0;

/// What the laser gives without an echo, millimetres.
const LASER_NO_ECHO_MM: f64 = 81910.0;

/// Largest coordinate, metres, and stamp, milliseconds, that is believed.
const MAX_M: f64 = 10_000.0;
const MAX_MS: f64 = 1e12;

/// Half of the clock's resolution with which a matched pose may differ from its row, ms.
const MATCHED_WITHIN_MS: f64 = 1.0;

impl Dataset for Kcma {
    fn name(&self) -> &'static str {
        "kcma"
    }

    fn looks_for(&self) -> &'static str {
        "a folder with od.txt or poses.txt, and sonar.txt or measurement.txt"
    }

    /// Poses 0.10 m or 5 degrees apart: the sonars give a row some ten times per second.
    fn usual(&self) -> UsualMapping {
        UsualMapping {
            keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
            cell_mm: 100,
        }
    }

    fn usual_rig(&self) -> Option<&'static str> {
        Some(include_str!("../../../rigs/kcma.toml"))
    }

    /// The laser, if the drive has one.
    fn true_world(&self, path: &Path) -> Result<Option<TrueWorld>, DatasetError> {
        let has_laser = path.join("laser.txt").is_file();
        Ok(has_laser.then_some(TrueWorld::Scanner))
    }

    fn recognises(&self, path: &Path) -> bool {
        poses(path).is_some() && sonar(path).is_some()
    }

    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError> {
        let mut files = Files::open(drive)?;
        let mut rows = ReadRows::default();
        loop {
            match files.advance()? {
                Advance::Row => match files.row(drive.rig) {
                    Ok(row) => {
                        rows.used += 1;
                        row.hand_on(take);
                    }
                    Err(row) => rows.refused.add(row),
                },
                Advance::Unpaired(row) => rows.refused.add(row),
                Advance::End => break,
            }
            files.report(on_bytes);
        }
        if rows.used == 0 {
            return Err(DatasetError::NoRow {
                file: files.odometry.file().to_owned(),
                format: self.name(),
                rows: rows.refused,
            });
        }
        Ok(rows)
    }
}

fn existing(folder: &Path, names: [&str; 2]) -> Option<PathBuf> {
    let paths = names.map(|name| folder.join(name));
    paths.into_iter().find(|path| path.is_file())
}

fn poses(folder: &Path) -> Option<PathBuf> {
    existing(folder, ["od.txt", "poses.txt"])
}

fn sonar(folder: &Path) -> Option<PathBuf> {
    existing(folder, ["sonar.txt", "measurement.txt"])
}

/// The files of a drive, each at the same row.
struct Files {
    odometry: Lines,
    sonar: Lines,
    laser: Option<Lines>,
    matched: Option<Lines>,
    first_ms: Option<f64>,
    last_ms: f64,
}

/// Where the files of a drive have come to.
enum Advance {
    /// Each has a row.
    Row,
    /// A file has a row, and another one has ended.
    Unpaired(RefusedRow),
    /// All have ended.
    End,
}

/// One instant.
struct Row {
    stamp_us: u64,
    world_from_body: Pose2,
    sonar: Vec<Return>,
    laser: Vec<Return>,
}

impl Row {
    fn hand_on(self, take: &mut dyn FnMut(&Record)) {
        let Self {
            stamp_us,
            world_from_body,
            sonar,
            laser,
        } = self;
        take(&Record::Pose {
            stamp_us,
            world_from_body,
        });
        let mut scan = |mounts, returns| {
            take(&Record::Scan(RangeScan {
                stamp_us,
                world_from_body,
                mounts,
                returns,
                signals: Vec::new(),
            }));
        };
        scan(0..SONARS, sonar);
        if !laser.is_empty() {
            scan(SONARS..SONARS + 1, laser);
        }
    }
}

impl Files {
    fn open(drive: &DriveFile<'_>) -> Result<Self, DatasetError> {
        let folder = drive.path;
        let missing = |names: &str| DatasetError::Read {
            file: shown(folder),
            source: std::io::Error::other(format!("{names} is missing")),
        };
        let laser = Some(folder.join("laser.txt")).filter(|path| path.is_file());
        check_rig(drive.rig, laser.is_some())?;
        let wanted = drive.poses;
        if wanted == PoseSource::MotionCapture {
            let file = shown(folder);
            return Err(DatasetError::NoSuchPoses { file, wanted });
        }
        let mut matched = None;
        if wanted == PoseSource::Matched {
            let path = folder.join("matched_poses.csv");
            if !path.is_file() {
                let file = shown(&path);
                return Err(DatasetError::NoPoses { file, wanted });
            }
            let mut lines = Lines::open(&path)?;
            // The header.
            lines.advance()?;
            matched = Some(lines);
        }
        let poses = poses(folder).ok_or_else(|| missing("od.txt or poses.txt"))?;
        let sonar = sonar(folder).ok_or_else(|| missing("sonar.txt or measurement.txt"))?;
        Ok(Self {
            odometry: Lines::open(&poses)?,
            sonar: Lines::open(&sonar)?,
            laser: laser.as_deref().map(Lines::open).transpose()?,
            matched,
            first_ms: None,
            last_ms: f64::NEG_INFINITY,
        })
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Lines> {
        let optional = [&mut self.laser, &mut self.matched].into_iter().flatten();
        [&mut self.odometry, &mut self.sonar]
            .into_iter()
            .chain(optional)
    }

    /// Goes to the next row in each file. A row of one file is refused where another file
    /// has ended.
    fn advance(&mut self) -> Result<Advance, DatasetError> {
        let mut ended = None;
        for lines in self.all() {
            if !lines.advance()? {
                ended.get_or_insert_with(|| lines.file().to_owned());
            }
        }
        let Some(ended) = ended else {
            return Ok(Advance::Row);
        };
        let row = self.all().find(|lines| lines.has_line());
        Ok(row.map_or(Advance::End, |lines| {
            let row = lines.text().map(|_| ());
            let unpaired = || lines.refused(format!("{ended} has ended"));
            Advance::Unpaired(row.err().unwrap_or_else(unpaired))
        }))
    }

    /// Reports the bytes read of all files together.
    fn report(&mut self, on_bytes: &mut dyn FnMut(u64, Option<u64>)) {
        let (mut read, mut length) = (0, Some(0));
        for lines in self.all() {
            let (of_file, its_length) = lines.progress();
            read += of_file;
            length = length.zip(its_length).map(|(sum, length)| sum + length);
        }
        on_bytes(read, length);
    }

    /// The row that was read last.
    fn row(&mut self, rig: &Rig) -> Result<Row, RefusedRow> {
        let [stamp_ms, x_mm, y_mm, tenths] = numbers(&self.odometry, ' ')?;
        if !(stamp_ms >= self.last_ms && stamp_ms.abs() <= MAX_MS) {
            return Err(self
                .odometry
                .refused(format!("stamp {stamp_ms} ms is out of order")));
        }
        let first_ms = *self.first_ms.get_or_insert(stamp_ms);
        let mut world_from_body =
            Pose2::new(1e-3 * x_mm, 1e-3 * y_mm, f64::to_radians(0.1 * tenths));
        if let Some(lines) = &self.matched {
            let [stamp_s, x_m, y_m, heading_rad] = numbers(lines, ',')?;
            same_stamp(lines, 1e3 * stamp_s, stamp_ms - first_ms, MATCHED_WITHIN_MS)?;
            world_from_body = Pose2::new(x_m, y_m, heading_rad);
        }
        let place = world_from_body.position;
        if !(world_from_body.is_finite() && place.x.abs() <= MAX_M && place.y.abs() <= MAX_M) {
            return Err(self
                .odometry
                .refused(format!("the robot is beyond {MAX_M} m")));
        }
        let sonar = ranges(&self.sonar, stamp_ms, SONARS, |index, mm| {
            measured(&rig.mounts[index].sensor, mm, SONAR_NO_ECHO_MM)
        })?;
        let laser = match &self.laser {
            None => Vec::new(),
            Some(lines) => ranges(lines, stamp_ms, BEAMS, |_, mm| {
                measured(&rig.mounts[SONARS].sensor, mm, LASER_NO_ECHO_MM)
            })?,
        };
        self.last_ms = stamp_ms;
        Ok(Row {
            // Not negative and below 1e15.
            stamp_us: (1e3 * (stamp_ms - first_ms)) as u64,
            world_from_body,
            sonar,
            laser,
        })
    }
}

/// Eight cones, and behind them nothing or a scanner of 361 beams, which is needed where
/// there is a laser.
fn check_rig(rig: &Rig, has_laser: bool) -> Result<(), DatasetError> {
    let (sonars, rest) = rig.mounts.split_at(rig.mounts.len().min(SONARS));
    let are_cones = sonars.len() == SONARS
        && sonars
            .iter()
            .all(|mount| matches!(mount.sensor, Sensor::Cone(_)));
    let is_scanner = |mount: &SensorMount| mount.sensor.model().returns() == BEAMS;
    let scanners = usize::from(rest.first().is_some_and(is_scanner));
    let needed = if !are_cones || (has_laser && scanners == 0) {
        String::new()
    } else if rest.len() > scanners {
        let names = rest.iter().skip(scanners);
        let names: Vec<_> = names.map(|mount| mount.name.as_str()).collect();
        format!(", and has no data for {}", names.join(", "))
    } else {
        return Ok(());
    };
    Err(DatasetError::Rig {
        rig: rig.name.clone(),
        needed: format!(
            "the recording needs {SONARS} cones{}, in this order{needed}",
            if has_laser {
                " and a scanner of 361 beams"
            } else {
                ""
            }
        ),
    })
}

/// What a range in millimetres means to a sensor; `None` if it is no range.
fn measured(sensor: &Sensor, mm: f64, no_echo_mm: f64) -> Option<Return> {
    let (range_m, sigma_m) = match sensor {
        Sensor::Cone(cone) => (cone.range_m, cone.sigma_m),
        Sensor::Scanner(scanner) => (scanner.range_m, scanner.sigma_m),
        Sensor::Infrared(_) => return None,
    };
    if mm < 0.0 || mm > no_echo_mm {
        return None;
    }
    if mm >= no_echo_mm {
        return Some(Return::NoEcho {
            limit_m: range_m[1],
            sigma_m,
        });
    }
    Some(measured_m(1e-3 * mm, range_m, sigma_m))
}
