//! Logs of the robot server Player, version 1, as the data sets of Radish have them.
//!
//! A drive is one text file, a row per message, values between blanks; rows that begin with
//! `#` are comments. Each row begins with
//!
//! | value | meaning |
//! |---|---|
//! | time | when the row was written, s |
//! | host, port | where the server ran |
//! | interface | `position`, `sonar` or `laser`; others are passed over and counted |
//! | index | number of the device; devices but the first are passed over and counted |
//! | data time | when the device measured, s |
//!
//! and goes on, metres and radians, counter-clockwise, with
//!
//! | interface | values |
//! |---|---|
//! | `position` | x, y, heading; three speeds; stall |
//! | `sonar` | number of sonars, their x, y, heading on the robot; number of ranges, the ranges |
//! | `laser` | bearing of the first beam, of the last one, step, number of beams; range and intensity of each |
//!
//! Devices measure at rates of their own. A scan has the pose between those of the position
//! rows around it. The rig's cones are the sonars and must be where the log has them; a
//! scanner behind them is the laser, of which the log has bearings and no place.

mod pose_track;
mod row;

use std::collections::BTreeMap;
use std::path::Path;

use pose_track::PoseTrack;
use row::{PlayerRow, PlayerValues, is_player_row, player_row};

use super::error::shown;
use super::fields::measured_m;
use super::lines::Lines;
use super::{Dataset, DatasetError, DriveFile, PoseSource, ReadRows, UsualMapping};
use crate::drive::{Keyframes, Record, Return};
use crate::geometry::Pose2;
use crate::rig::Rig;
use crate::sensors::{RangeSensor, Sensor};

/// The format; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Player;

/// Rows that are looked at to recognise a file.
const HEAD_ROWS: usize = 50;

/// How far a sonar, and the bearing of a beam, may be from where the rig has it: the log has
/// three decimals of a metre and four of a radian.
const SAME_PLACE_M: f64 = 2e-3;
const SAME_AXIS_RAD: f64 = 2e-3;

/// The bearings of the last beam may differ by more: the step is rounded.
const SAME_LAST_RAD: f64 = 0.02;

/// Most interfaces that are counted by name.
const MOST_NAMES: usize = 32;

impl Dataset for Player {
    fn name(&self) -> &'static str {
        "player"
    }

    fn looks_for(&self) -> &'static str {
        "a text file with rows of the server Player 1"
    }

    /// Poses 0.10 m or 5 degrees apart, as for other sonars.
    fn usual(&self) -> UsualMapping {
        UsualMapping {
            keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
            cell_mm: 100,
        }
    }

    /// A robot with sonars and a laser; rows of what a log lacks are not missed.
    fn usual_rig(&self) -> Option<&'static str> {
        Some(include_str!("../../../rigs/pioneer2dx_laser.toml"))
    }

    fn recognises(&self, path: &Path) -> bool {
        let mut lines = match Lines::open(path) {
            Ok(lines) if path.is_file() => lines,
            _ => return false,
        };
        for _ in 0..HEAD_ROWS {
            if !lines.advance().unwrap_or(false) {
                return false;
            }
            match lines.text() {
                Ok(text) if is_comment(text) => {}
                text => return text.is_ok_and(is_player_row),
            }
        }
        false
    }

    /// Memory: a row, and the scans since the last position row, at most 256.
    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError> {
        let mounts = PlayerMounts::of(drive.rig)?;
        if drive.poses != PoseSource::Odometry {
            let (file, wanted) = (shown(drive.path), drive.poses);
            return Err(DatasetError::NoSuchPoses { file, wanted });
        }
        let mut lines = Lines::open(drive.path)?;
        let mut reading = PlayerReading::new(drive.rig, mounts);
        while lines.advance()? {
            reading.take(&lines, take);
            let (read, length) = lines.progress();
            on_bytes(read, length);
        }
        reading.track.finish(&mut reading.rows, take);
        if reading.rows.used == 0 {
            return Err(DatasetError::NoRow {
                file: shown(drive.path),
                format: self.name(),
                rows: reading.rows.refused,
            });
        }
        Ok(reading.with_notes())
    }
}

fn is_comment(text: &str) -> bool {
    text.trim_start().starts_with('#') || text.trim().is_empty()
}

/// The mounts of a rig as the log has them.
#[derive(Clone, Copy, Debug)]
struct PlayerMounts {
    /// Cones, the first mounts.
    sonars: usize,
    has_laser: bool,
}

impl PlayerMounts {
    /// Cones, and behind them at most one scanner.
    fn of(rig: &Rig) -> Result<Self, DatasetError> {
        let is_cone = |sensor: &Sensor| matches!(sensor, Sensor::Cone(_));
        let sonars = rig.mounts.iter().take_while(|it| is_cone(&it.sensor));
        let sonars = sonars.count();
        let has_laser = match rig.mounts.get(sonars..).unwrap_or_default() {
            [] => false,
            [last] if matches!(last.sensor, Sensor::Scanner(_)) => true,
            _ => {
                return Err(DatasetError::Rig {
                    rig: rig.name.clone(),
                    needed: "the recording needs cones, or one scanner, or cones and behind them \
                             one scanner"
                        .to_owned(),
                });
            }
        };
        Ok(Self { sonars, has_laser })
    }
}

/// How far the reading of a log has come.
struct PlayerReading<'a> {
    rig: &'a Rig,
    mounts: PlayerMounts,
    track: PoseTrack,
    rows: ReadRows,
    /// Rows that were passed over, by interface.
    others: BTreeMap<String, u64>,
}

impl<'a> PlayerReading<'a> {
    fn new(rig: &'a Rig, mounts: PlayerMounts) -> Self {
        Self {
            rig,
            mounts,
            track: PoseTrack::default(),
            rows: ReadRows::default(),
            others: BTreeMap::new(),
        }
    }

    fn take(&mut self, lines: &Lines, take: &mut dyn FnMut(&Record)) {
        match lines.text() {
            Ok(text) if is_comment(text) => return,
            _ => {}
        }
        let row = match player_row(lines) {
            Ok(Some(row)) => row,
            Ok(None) => return self.pass_over(lines),
            Err(row) => return self.rows.refused.add(row),
        };
        let PlayerRow { time_s, values } = row;
        let (mounts, returns) = match values {
            PlayerValues::Position(pose) => {
                match self.track.pose(time_s, pose, &mut self.rows, take) {
                    Ok(()) => self.rows.used += 1,
                    Err(reason) => self.rows.refused.add(lines.refused(reason)),
                }
                return;
            }
            PlayerValues::Sonar { .. } if self.mounts.sonars == 0 => return self.pass_over(lines),
            PlayerValues::Laser { .. } if !self.mounts.has_laser => return self.pass_over(lines),
            PlayerValues::Sonar { poses, ranges_m } => {
                (0..self.mounts.sonars, self.sonars(&poses, &ranges_m))
            }
            PlayerValues::Laser { bearings, ranges_m } => {
                let mount = self.mounts.sonars;
                (mount..mount + 1, self.beams(bearings, &ranges_m))
            }
        };
        match returns {
            Ok(returns) => {
                let row = lines.refused(String::new());
                self.track
                    .scan(time_s, mounts, returns, row, &mut self.rows);
            }
            Err(reason) => self.rows.refused.add(lines.refused(reason)),
        }
    }

    /// The returns of the sonars, if they are those of the rig.
    fn sonars(&self, poses: &[Pose2], ranges_m: &[f64]) -> Result<Vec<Return>, String> {
        let mounts = self.rig.mounts.iter().take(self.mounts.sonars);
        let (expected, found) = (self.mounts.sonars, poses.len());
        if found != expected || ranges_m.len() != expected {
            let ranges = ranges_m.len();
            return Err(format!(
                "{ranges} ranges of {found} sonars where the rig has {expected}"
            ));
        }
        let mut returns = Vec::with_capacity(expected);
        for ((mount, logged), range_m) in mounts.zip(poses).zip(ranges_m) {
            let at = mount.body_from_sensor;
            let is_there = (at.position - logged.position).norm() <= SAME_PLACE_M
                && at.turn_to(logged) <= SAME_AXIS_RAD;
            if !is_there {
                return Err(format!("{} is elsewhere on the rig", mount.name));
            }
            if let Sensor::Cone(cone) = &mount.sensor {
                returns.push(measured_m(*range_m, cone.range_m, cone.sigma_m));
            }
        }
        Ok(returns)
    }

    /// The returns of the laser, if its beams are those of the rig.
    fn beams(&self, bearings: [f64; 2], ranges_m: &[f64]) -> Result<Vec<Return>, String> {
        let mount = self.rig.mounts.get(self.mounts.sonars);
        let Some(Sensor::Scanner(scanner)) = mount.map(|mount| &mount.sensor) else {
            return Ok(Vec::new());
        };
        let (expected, found) = (scanner.returns(), ranges_m.len());
        if found != expected {
            return Err(format!("{found} beams where the rig has {expected}"));
        }
        let last_rad = scanner.first_rad + (expected as f64 - 1.0) * scanner.step_rad;
        let [first, last] = bearings;
        if (first - scanner.first_rad).abs() > SAME_AXIS_RAD
            || (last - last_rad).abs() > SAME_LAST_RAD
        {
            return Err(format!(
                "beams from {first} to {last} rad where the rig has {} to {last_rad}",
                scanner.first_rad
            ));
        }
        let returns = ranges_m.iter();
        Ok(returns
            .map(|range_m| measured_m(*range_m, scanner.range_m, scanner.sigma_m))
            .collect())
    }

    fn pass_over(&mut self, lines: &Lines) {
        let text = lines.text().unwrap_or_default();
        let mut fields = text.split_ascii_whitespace().skip(3);
        let name = fields.next().unwrap_or_default();
        let index = fields.next().unwrap_or_default();
        let name = format!("{name} {index}");
        if self.others.len() < MOST_NAMES || self.others.contains_key(&name) {
            *self.others.entry(name).or_default() += 1;
        }
    }

    fn with_notes(mut self) -> ReadRows {
        let passed_over = |(name, count): (&String, &u64)| {
            let name = crate::escape::escaped(name);
            format!("{count} rows of {name} passed over")
        };
        let notes = self.others.iter().map(passed_over);
        self.rows.notes.extend(notes);
        self.rows
    }
}
