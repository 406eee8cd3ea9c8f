//! One row of a log of Player.

use super::super::RefusedRow;
use super::super::fields::number;
use super::super::lines::Lines;
use crate::geometry::Pose2;

/// Most sonars of a row and most beams.
const MOST_SONARS: usize = 64;
const MOST_BEAMS: usize = 4096;

/// Largest coordinate, metres, angle, radians, and range, metres, that is believed.
const MAX_M: f64 = 10_000.0;
const MAX_RAD: f64 = 1_000.0;

/// Latest stamp that is believed, seconds.
const MAX_S: f64 = 1e10;

/// Values before those of the interface.
const HEAD: usize = 6;

/// A row that is read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlayerRow {
    /// When the device measured, seconds.
    pub(super) time_s: f64,
    /// What it measured.
    pub(super) values: PlayerValues,
}

/// What a device measured.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PlayerValues {
    /// Pose by the odometry.
    Position(Pose2),
    /// Poses of the sonars on the robot, and their ranges, metres.
    Sonar {
        poses: Vec<Pose2>,
        ranges_m: Vec<f64>,
    },
    /// Bearings of the first and last beam, radians, and ranges, metres.
    Laser {
        bearings: [f64; 2],
        ranges_m: Vec<f64>,
    },
}

/// Whether a text begins as a row of version 1 does: the sixth value is a time with
/// decimals, where later versions have a number for the kind of message.
pub(super) fn is_player_row(text: &str) -> bool {
    let fields: Vec<&str> = text.split_ascii_whitespace().take(HEAD + 1).collect();
    let [time, _, port, interface, index, data_time, _] = fields[..] else {
        return false;
    };
    let is_time = |field: &str| field.contains('.') && field.parse::<f64>().is_ok();
    let is_name = !interface.is_empty()
        && interface
            .bytes()
            .all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit());
    is_time(time)
        && port.parse::<u16>().is_ok()
        && is_name
        && !interface.as_bytes()[0].is_ascii_digit()
        && index.parse::<u16>().is_ok()
        && is_time(data_time)
}

/// The row that was read last; `None` for an interface or device that is passed over.
pub(super) fn player_row(lines: &Lines) -> Result<Option<PlayerRow>, RefusedRow> {
    let text = lines.text()?;
    if !is_player_row(text) {
        return Err(lines.refused("no row of Player 1".to_owned()));
    }
    let mut fields = text.split_ascii_whitespace();
    let interface = fields.nth(3).unwrap_or_default();
    let index: u16 = fields.next().and_then(|it| it.parse().ok()).unwrap_or(0);
    if index != 0 {
        return Ok(None);
    }
    let mut values = Values { lines, fields };
    let time_s = values.within(0.0, MAX_S, "stamp")?;
    let values = match interface {
        "position" => values.position()?,
        "sonar" => values.sonar()?,
        "laser" => values.laser()?,
        _ => return Ok(None),
    };
    Ok(Some(PlayerRow { time_s, values }))
}

/// The values of a row that are not read yet.
struct Values<'a> {
    lines: &'a Lines,
    fields: core::str::SplitAsciiWhitespace<'a>,
}

impl Values<'_> {
    fn next(&mut self) -> Result<f64, RefusedRow> {
        match self.fields.next() {
            Some(field) => number(self.lines, field),
            None => Err(self.lines.refused("the row ends too early".to_owned())),
        }
    }

    fn within(&mut self, low: f64, high: f64, name: &str) -> Result<f64, RefusedRow> {
        let value = self.next()?;
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(self
            .lines
            .refused(format!("{name} {value} is not {low} to {high}")))
    }

    fn pose(&mut self) -> Result<Pose2, RefusedRow> {
        let x_m = self.within(-MAX_M, MAX_M, "coordinate")?;
        let y_m = self.within(-MAX_M, MAX_M, "coordinate")?;
        Ok(Pose2::new(x_m, y_m, self.angle()?))
    }

    fn angle(&mut self) -> Result<f64, RefusedRow> {
        self.within(-MAX_RAD, MAX_RAD, "angle")
    }

    fn count(&mut self, most: usize) -> Result<usize, RefusedRow> {
        let count = self.within(0.0, most as f64, "number")?;
        if count.fract() > 0.0 {
            return Err(self.lines.refused(format!("{count} is no whole number")));
        }
        // Not negative, whole, and at most `most`.
        Ok(count as usize)
    }

    fn ends(&mut self) -> Result<(), RefusedRow> {
        match self.fields.next() {
            None => Ok(()),
            Some(_) => Err(self.lines.refused("the row has more values".to_owned())),
        }
    }

    fn position(mut self) -> Result<PlayerValues, RefusedRow> {
        let pose = self.pose()?;
        // Three speeds and stall.
        for _ in 0..4 {
            self.next()?;
        }
        self.ends()?;
        Ok(PlayerValues::Position(pose))
    }

    fn sonar(mut self) -> Result<PlayerValues, RefusedRow> {
        let sonars = self.count(MOST_SONARS)?;
        let mut poses = Vec::with_capacity(sonars);
        for _ in 0..sonars {
            poses.push(self.pose()?);
        }
        let count = self.count(MOST_SONARS)?;
        let mut ranges_m = Vec::with_capacity(count);
        for _ in 0..count {
            ranges_m.push(self.within(0.0, MAX_M, "range")?);
        }
        self.ends()?;
        Ok(PlayerValues::Sonar { poses, ranges_m })
    }

    fn laser(mut self) -> Result<PlayerValues, RefusedRow> {
        let bearings = [self.angle()?, self.angle()?];
        // The step, which follows from bearings and number.
        self.angle()?;
        let count = self.count(MOST_BEAMS)?;
        let mut ranges_m = Vec::with_capacity(count);
        for _ in 0..count {
            ranges_m.push(self.within(0.0, MAX_M, "range")?);
            // The intensity.
            self.next()?;
        }
        self.ends()?;
        Ok(PlayerValues::Laser { bearings, ranges_m })
    }
}
