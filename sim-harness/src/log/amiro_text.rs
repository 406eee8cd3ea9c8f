//! AMiRo's own text: eight readings and a pose per row, without stamps.
//!
//! A header, then rows of eleven integers between tabs: counts of the sensors 0 to 7
//! above their ground offset, x and y in micrometres, the heading in microradians,
//! 0 to 2 pi. The header's "ym" and "yrad" mean micro. 65535 is a full register.
//!
//! # Stamps
//!
//! The recorder wrote none. They are made from the travelled distance as if the robot had
//! driven at 80 mm/s throughout, its speed in the paper's drives, and at least 8 ms per
//! row: sufficient for distances, meaningless for times. A row's odometry and readings
//! carry the same stamp.
//!
//! # What is refused
//!
//! - A row that repeats the one before to the letter: the recorder was faster than
//!   the sensors, and a repeated reading would count twice.
//! - A last line without its end, even if it has eleven fields: the last number may
//!   have lost digits. A tab or carriage return after that number proves it whole.
//! - Numbers that no integer writer writes: "+1", "-0", "007", "1e3", "0x1F".
//! - Counts outside 0 to 65535, coordinates beyond 500 m, headings beyond 7 rad.
//! - A second header and everything after it: another recording, appended to this one.
//! - A whole drive whose numbers cannot be micrometres or microradians.

use std::fmt::Display;
use std::io::Read;
use std::ops::ControlFlow;

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::Input;

use super::amiro_header::{COLUMNS, check, fields};
use super::plausibility::{Claimed, RowCheck};
use super::rules::{Rules, Sender};
use super::source::{ByteSource, Piece};
use super::{LogError, Place, Problem, Reason};
use crate::escape::escaped;

/// Longest line; a longer one is skipped to its end.
const MOST_LINE: usize = 64 * 1024;
/// A full 16-bit register.
const FULL_REGISTER: u16 = u16::MAX;
/// 500 m in micrometres.
const MOST_COORDINATE: i64 = 500_000_000;
/// 7 rad in microradians: a turn and some rounding.
const MOST_HEADING: i64 = 7_000_000;
/// Least time between rows, microseconds.
const LEAST_ROW_US: u64 = 8_000;

/// The integers of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TextRow {
    counts: [u16; SENSORS],
    x_um: i64,
    y_um: i64,
    heading_urad: i64,
}

/// Why a line is no row.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Flaw {
    reason: Reason,
    text: String,
}

impl Flaw {
    fn new(reason: Reason, text: impl Display) -> Self {
        let text = text.to_string();
        Self { reason, text }
    }
}

/// The last row that was used: its line, its stamp, its content.
#[derive(Clone, Copy, Debug)]
struct Used {
    line: u64,
    stamp_us: u64,
    row: TextRow,
}

/// State of the reader of AMiRo's text.
#[derive(Debug, Default)]
pub(super) struct TextLines {
    bytes: Vec<u8>,
    /// Number of the last line.
    line: u64,
    has_header: bool,
    used: Option<Used>,
}

impl TextLines {
    /// Reads the next line; breaks at the end of the source or of its run.
    ///
    /// # Errors
    /// A source that cannot be read, that does not begin with the header, or that shows
    /// none in its first MiB.
    pub(super) fn read_one<R: Read>(
        &mut self,
        source: &mut ByteSource<R>,
        rules: &mut Rules,
    ) -> Result<ControlFlow<()>, LogError> {
        let Some(piece) = source.read_piece(b'\n', MOST_LINE, &mut self.bytes)? else {
            return Ok(ControlFlow::Break(()));
        };
        self.line += 1;
        let place = Place::Line(self.line);
        let text = match text_of(&self.bytes, piece, self.line) {
            Ok(text) => text,
            Err(flaw) => {
                rules.refuse(place, flaw.reason, flaw.text);
                return Ok(ControlFlow::Continue(()));
            }
        };
        if !self.has_header {
            check(text, source.head()).map_err(|problem| source.error(Some(place), problem))?;
            self.has_header = true;
            source.trust();
            return Ok(ControlFlow::Continue(()));
        }
        let (row, is_joined) = split_at_header(text);
        let is_ended = piece.is_ended && !is_joined;
        let taken = match row.map(|row| parse(row, is_ended)) {
            Some(Ok(row)) => take(rules, &mut self.used, self.line, row),
            Some(Err(flaw)) => {
                rules.refuse(place, flaw.reason, flaw.text);
                ControlFlow::Continue(())
            }
            None => ControlFlow::Continue(()),
        };
        if is_joined {
            let text = "a second header: what follows is another run";
            rules.refuse(place, Reason::SecondRun, text);
            return Ok(ControlFlow::Break(()));
        }
        Ok(taken)
    }
}

/// A guess at the meaning of the first rows of a source without usable rows, such as
/// decimal fractions of larger units.
pub(super) fn unit_check(head: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(head);
    let mut check = RowCheck::default();
    text.lines()
        .filter_map(claimed)
        .for_each(|row| check.take(row));
    check.finish(false)
}

/// The pose of a line of eleven numbers, whether integers or not.
fn claimed(line: &str) -> Option<Claimed> {
    let numbers: Option<Vec<f64>> = fields(line)
        .map(|field| field.trim().parse().ok().filter(|n: &f64| n.is_finite()))
        .collect();
    match numbers?.as_slice() {
        [_, _, _, _, _, _, _, _, x, y, heading] => Some(Claimed {
            x_m: x * 1e-6,
            y_m: y * 1e-6,
            heading_rad: heading * 1e-6,
        }),
        _ => None,
    }
}

/// A line's text, without what encodings and editors put around it.
fn text_of(bytes: &[u8], piece: Piece, line: u64) -> Result<&str, Flaw> {
    if piece.is_too_long {
        return Err(Flaw::new(
            Reason::LongLine,
            "longer than 64 KiB: skipped to its end",
        ));
    }
    if bytes.contains(&0) {
        return Err(Flaw::new(Reason::ZeroByte, "holds a zero byte"));
    }
    let text = str::from_utf8(bytes).map_err(|error| Flaw::new(Reason::NotUtf8, error))?;
    let text = match line {
        1 => text.strip_prefix('\u{feff}').unwrap_or(text),
        _ => text,
    };
    if text.trim().is_empty() {
        return Err(Flaw::new(Reason::EmptyLine, "is empty"));
    }
    Ok(text)
}

/// A line's row, if it has one, and whether the header of another recording begins here:
/// on a line of its own, or behind a last row without a line end.
fn split_at_header(text: &str) -> (Option<&str>, bool) {
    let Some(place) = text.to_ascii_lowercase().find("prv") else {
        return (Some(text), false);
    };
    let (row, header) = text.split_at(place);
    if let Err(Problem::NoHeader { .. }) = check(header, header.as_bytes()) {
        return (Some(text), false);
    }
    // In other units it is the header of another recording all the same.
    let row = row.trim_end_matches('\u{feff}');
    ((!row.trim().is_empty()).then_some(row), true)
}

/// The row that a line's text is.
fn parse(text: &str, is_ended: bool) -> Result<TextRow, Flaw> {
    let is_whole = is_ended || text.ends_with(['\t', '\r']);
    let mut numbers = [""; COLUMNS.len()];
    let mut found = 0;
    for field in fields(text) {
        if let Some(number) = numbers.get_mut(found) {
            *number = field.trim();
        }
        found += 1;
    }
    if found != COLUMNS.len() {
        let cut = if is_ended { "" } else { ", cut at the end" };
        return Err(Flaw::new(
            Reason::FieldCount,
            format_args!("{found} of {} fields{cut}", COLUMNS.len()),
        ));
    }
    if !is_whole {
        return Err(Flaw::new(
            Reason::Cut,
            "no line end: the last number may be cut",
        ));
    }
    let [readings @ .., x, y, heading] = numbers;
    let mut counts = [0; SENSORS];
    for ((count, text), column) in counts.iter_mut().zip(readings).zip(COLUMNS) {
        let number = integer(column, text, 0, i64::from(u16::MAX))?;
        *count = u16::try_from(number).unwrap_or(FULL_REGISTER);
    }
    Ok(TextRow {
        counts,
        x_um: integer("X", x, -MOST_COORDINATE, MOST_COORDINATE)?,
        y_um: integer("Y", y, -MOST_COORDINATE, MOST_COORDINATE)?,
        heading_urad: integer("Theta", heading, -MOST_HEADING, MOST_HEADING)?,
    })
}

/// A plain decimal integer between two bounds, both legal.
fn integer(column: &str, text: &str, least: i64, most: i64) -> Result<i64, Flaw> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_plain = !digits.is_empty()
        && digits.bytes().all(|byte| byte.is_ascii_digit())
        && (text == "0" || !digits.starts_with('0'));
    if !is_plain {
        return Err(Flaw::new(
            Reason::NotAnInteger,
            format_args!("{column} is '{}', not an integer", escaped(text)),
        ));
    }
    // Plain digits fail to parse only when they are too many.
    match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(Flaw::new(
            Reason::OutOfRange,
            format_args!("{column} is {}, outside {least} to {most}", escaped(text)),
        )),
    }
}

/// Makes a row's two inputs, unless it is the row before again.
fn take(rules: &mut Rules, used: &mut Option<Used>, line: u64, row: TextRow) -> ControlFlow<()> {
    let place = Place::Line(line);
    let stamp_us = match used {
        Some(last) if last.row == row => {
            let text = format_args!("repeats line {}", last.line);
            rules.refuse(place, Reason::Repeated, text);
            return ControlFlow::Continue(());
        }
        Some(last) => last
            .stamp_us
            .saturating_add(row.microseconds_from(&last.row)),
        None => 0,
    };
    *used = Some(Used {
        line,
        stamp_us,
        row,
    });
    let pose = row.pose();
    rules.take_input(place, Sender::Host, Input::Odometry { stamp_us, pose })?;
    let samples = row.samples();
    rules.take_input(place, Sender::Host, Input::Proximity { stamp_us, samples })
}

impl TextRow {
    /// Time for the way from another row at 80 mm/s, which is 12.5 us per micrometre.
    ///
    /// In integers throughout: at most 1.4e9 um, squared and times 12.5^2 in 128 bits.
    fn microseconds_from(&self, before: &Self) -> u64 {
        let x_um = u128::from(self.x_um.abs_diff(before.x_um));
        let y_um = u128::from(self.y_um.abs_diff(before.y_um));
        let microseconds = ((x_um * x_um + y_um * y_um) * 625 / 4).isqrt();
        u64::try_from(microseconds)
            .unwrap_or(u64::MAX)
            .max(LEAST_ROW_US)
    }

    fn pose(&self) -> Pose {
        let millionths = |number: i64| (number as f64 * 1e-6) as f32;
        Pose::new(
            millionths(self.x_um),
            millionths(self.y_um),
            millionths(self.heading_urad),
        )
    }

    fn samples(&self) -> [Sample; SENSORS] {
        self.counts.map(|counts| match counts {
            FULL_REGISTER => Sample::Saturated,
            counts => Sample::Counts(i32::from(counts)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    const ROW: &str = "0\t1\t2\t3\t4\t5\t6\t65535\t-1500000\t250000\t3141593";

    #[test]
    fn row_is_micrometres_and_microradians() {
        let row = parse(ROW, true).unwrap();
        let error = row.pose().motion_to(&Pose::new(-1.5, 0.25, PI));
        assert!(error.displacement.norm() < 1e-6 && error.turn.radians().abs() < 1e-6);
        assert_eq!(row.samples()[6], Sample::Counts(6));
        assert_eq!(row.samples()[7], Sample::Saturated);
    }

    #[test]
    fn eighty_millimetres_take_a_second_and_standing_eight_milliseconds() {
        let start = parse(ROW, true).unwrap();
        let end = TextRow {
            x_um: start.x_um + 48_000,
            y_um: start.y_um - 64_000,
            ..start
        };
        assert_eq!(end.microseconds_from(&start), 1_000_000);
        assert_eq!(start.microseconds_from(&end), 1_000_000);
        assert_eq!(start.microseconds_from(&start), 8_000);
        let corner = |sign: i64| TextRow {
            counts: [0; SENSORS],
            x_um: sign * MOST_COORDINATE,
            y_um: sign * MOST_COORDINATE,
            heading_urad: 0,
        };
        // The diagonal of a square kilometre, 1414.2 m.
        assert_eq!(corner(1).microseconds_from(&corner(-1)), 17_677_669_529);
    }

    #[test]
    fn last_line_needs_proof_that_it_is_whole() {
        assert_eq!(parse(ROW, false).unwrap_err().reason, Reason::Cut);
        for end in ["\t", "\r", "\t\r"] {
            assert!(parse(&format!("{ROW}{end}"), false).is_ok(), "{end:?}");
        }
        let cut = parse("1\t2\t", false).unwrap_err();
        assert_eq!(cut.text, "2 of 11 fields, cut at the end");
    }

    #[test]
    fn only_what_an_integer_writer_writes_is_an_integer() {
        for text in ["0", "7", "-7", "70", "9223372036854775807"] {
            assert_eq!(
                integer("X", text, i64::MIN, i64::MAX).map(|n| n.to_string()),
                Ok(text.to_owned())
            );
        }
        for text in ["", "-", "+1", "-0", "007", "1.0", "1 2", "--1", "\u{0663}"] {
            let flaw = integer("X", text, i64::MIN, i64::MAX).unwrap_err();
            assert_eq!(flaw.reason, Reason::NotAnInteger, "{text:?}");
        }
        let flaw = integer("X", "9223372036854775808", i64::MIN, i64::MAX).unwrap_err();
        assert_eq!(flaw.reason, Reason::OutOfRange);
    }
}
