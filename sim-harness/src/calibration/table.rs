//! Measured counts: rows of range, angle, counts and weight from a text with commas.
//!
//! The first line that is neither empty nor a `#` comment names the columns, in any
//! order: `range_m`, `range_cm` or `range_mm`, `angle_deg` or `angle_rad`, `counts`,
//! and if wanted `weight` (1 without). Other columns are passed over.

use std::fs;
use std::path::Path;

use crate::escape::lines_escaped;

/// Longest file, bytes.
const MAX_BYTES: u64 = 16 << 20;
/// Largest range, metres.
const MAX_RANGE_M: f64 = 2.0;
/// Largest counts: the 16-bit register, and as much below.
const MAX_COUNTS: f64 = 65_535.0;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Distance of the surface from the sensor, metres (x).
    pub range_m: f64,
    /// Bearing of the surface off the sensor's axis, radians (theta).
    pub angle_rad: f64,
    /// Counts, raw or above an offset: beta takes up the difference (s).
    pub counts: f64,
    /// How many measurements of the common noise this one is worth.
    pub weight: f64,
}

/// Measurements that a law can be fitted to; each is finite and within range.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    rows: Vec<Measurement>,
}

/// Why a table was refused, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}{}",
    line.map(|line| format!("line {line}: ")).unwrap_or_default(),
    lines_escaped(&problem.to_string())
)]
pub struct TableError {
    /// The line, from 1; `None` for the text as a whole.
    pub line: Option<usize>,
    /// The reason.
    pub problem: TableProblem,
}

/// What is wrong with a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableProblem {
    /// The file could not be read.
    #[error("cannot read: {0}")]
    Read(String),
    /// No header, or one that lacks a column or names it twice.
    #[error("the header {0}")]
    Header(String),
    /// A row lacks a column's value.
    #[error("no {0}")]
    NoValue(&'static str),
    /// A value is no number, or outside what a sensor can have measured.
    #[error("{column} is '{value}', not {wanted}")]
    Value {
        /// The column.
        column: &'static str,
        /// What stands there.
        value: String,
        /// What may stand there.
        wanted: &'static str,
    },
    /// No row at all.
    #[error("no measurements")]
    Empty,
}

impl TableProblem {
    fn at(self, line: usize) -> TableError {
        TableError {
            line: Some(line),
            problem: self,
        }
    }

    fn anywhere(self) -> TableError {
        TableError {
            line: None,
            problem: self,
        }
    }
}

/// A column that was found: its place, its name, its unit in SI.
#[derive(Clone, Copy, Debug)]
struct Column {
    place: usize,
    name: &'static str,
    unit: f64,
}

/// Where a row's values stand.
#[derive(Clone, Copy, Debug)]
struct Columns {
    range: Column,
    angle: Column,
    counts: Column,
    weight: Option<Column>,
}

impl Table {
    /// Reads a table from a file.
    ///
    /// # Errors
    /// As for [`parse`](Self::parse), or the file could not be read.
    pub fn load(path: &Path) -> Result<Self, TableError> {
        let read = |said: String| TableProblem::Read(said).anywhere();
        let size = fs::metadata(path)
            .map_err(|error| read(error.to_string()))?
            .len();
        if size > MAX_BYTES {
            return Err(read(format!("{size} bytes, at most {MAX_BYTES}")));
        }
        let bytes = fs::read(path).map_err(|error| read(error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|error| read(error.to_string()))?;
        Self::parse(&text)
    }

    /// Reads a table from its text.
    ///
    /// # Errors
    /// The first line that is wrong: one bad measurement spoils a fit, so none is
    /// passed over.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = (1..)
            .zip(text.lines())
            .map(|(line, text)| (line, text.split('#').next().unwrap_or_default().trim()))
            .filter(|(_, text)| !text.is_empty());
        let Some((line, header)) = lines.next() else {
            return Err(TableProblem::Empty.anywhere());
        };
        let columns = Columns::named_by(header).map_err(|problem| problem.at(line))?;
        let rows: Result<Vec<_>, _> = lines
            .map(|(line, text)| columns.row(text).map_err(|problem| problem.at(line)))
            .collect();
        let rows = rows?;
        if rows.is_empty() {
            return Err(TableProblem::Empty.anywhere());
        }
        Ok(Self { rows })
    }

    /// The measurements, in the order of the text; at least one.
    #[must_use]
    pub fn rows(&self) -> &[Measurement] {
        &self.rows
    }
}

impl Columns {
    fn named_by(header: &str) -> Result<Self, TableProblem> {
        let names: Vec<String> = header.split(',').map(unquoted).collect();
        let among = |wanted: &[(&'static str, f64)]| {
            let mut found = None;
            for (place, name) in names.iter().enumerate() {
                let known = wanted.iter().find(|(known, _)| known == name);
                let Some(&(name, unit)) = known else {
                    continue;
                };
                if found.replace(Column { place, name, unit }).is_some() {
                    return Err(TableProblem::Header(format!("names {name} a second time")));
                }
            }
            Ok(found)
        };
        let needed = |wanted: &[(&'static str, f64)]| {
            let missing = || {
                let names: Vec<_> = wanted.iter().map(|(name, _)| *name).collect();
                TableProblem::Header(format!("'{header}' names no {}", names.join(" or ")))
            };
            among(wanted)?.ok_or_else(missing)
        };
        Ok(Self {
            range: needed(&[("range_m", 1.0), ("range_cm", 0.01), ("range_mm", 0.001)])?,
            angle: needed(&[
                ("angle_deg", core::f64::consts::PI / 180.0),
                ("angle_rad", 1.0),
            ])?,
            counts: needed(&[("counts", 1.0)])?,
            weight: among(&[("weight", 1.0)])?,
        })
    }

    fn row(&self, text: &str) -> Result<Measurement, TableProblem> {
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let value = |column: Column, wanted, is_legal: &dyn Fn(f64) -> bool| {
            let field = fields
                .get(column.place)
                .filter(|field| !field.is_empty())
                .ok_or(TableProblem::NoValue(column.name))?;
            let number = field.parse().ok().map(|number: f64| number * column.unit);
            number
                .filter(|number| is_legal(*number))
                .ok_or_else(|| TableProblem::Value {
                    column: column.name,
                    value: (*field).to_owned(),
                    wanted,
                })
        };
        let is_range = |metres| metres > 0.0 && metres <= MAX_RANGE_M;
        // Rounding may put 90 degrees above a right angle.
        let is_angle = |radians: f64| radians.abs() < core::f64::consts::FRAC_PI_2 + 1e-9;
        let is_count = |counts: f64| counts.abs() <= MAX_COUNTS;
        let is_weight = |weight| weight > 0.0 && weight <= 1e6;
        Ok(Measurement {
            range_m: value(self.range, "a range above 0, to 2 m", &is_range)?,
            angle_rad: value(self.angle, "an angle up to 90 degrees", &is_angle)?,
            counts: value(self.counts, "counts of a 16-bit register", &is_count)?,
            weight: match self.weight {
                Some(column) => value(column, "a weight above 0, to 1e6", &is_weight)?,
                None => 1.0,
            },
        })
    }
}

fn unquoted(name: &str) -> String {
    name.trim().trim_matches('"').to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_of_a_bad_header_or_value_moves_no_cursor() {
        for text in ["range_m\x1b[2J counts\n", "range_m,deg\n\x1b]0;x\x07,0\n"] {
            let error = Table::parse(text).unwrap_err().to_string();
            assert!(!error.contains(char::is_control), "{error:?}");
        }
    }

    #[test]
    fn columns_come_in_any_order_with_units_comments_and_extras() {
        let table = Table::parse(
            "\u{feff}# white block\n\nset, Counts ,range_mm,weight,angle_deg\r\n\
             a,361.5,50,2,-30 # by eye\n\n# none\nb,78,100,0.5,0\n",
        )
        .unwrap();
        let [first, second] = table.rows() else {
            panic!("{table:?}");
        };
        assert!((first.range_m - 0.05).abs() < 1e-12 && (first.counts - 361.5).abs() < 1e-12);
        assert!((first.angle_rad + 30.0_f64.to_radians()).abs() < 1e-12);
        assert!((first.weight - 2.0).abs() < 1e-12 && (second.weight - 0.5).abs() < 1e-12);
    }

    #[test]
    fn bad_tables_name_line_and_reason() {
        let head = "range_m,angle_deg,counts\n";
        for (text, said) in [
            (String::new(), "no measurements"),
            ("# nothing\n\n".to_owned(), "no measurements"),
            (head.to_owned(), "no measurements"),
            (
                "range,angle_deg,counts\n".to_owned(),
                "line 1: the header 'range,angle_deg,counts' names no range_m or range_cm or range_mm",
            ),
            (
                "range_m,range_mm,angle_deg,counts\n".to_owned(),
                "line 1: the header names range_mm a second time",
            ),
            (format!("{head}0.1,0\n"), "line 2: no counts"),
            (format!("{head}\n0.1,,5\n"), "line 3: no angle_deg"),
            (
                format!("{head}0.1,0,NaN\n"),
                "line 2: counts is 'NaN', not counts of a 16-bit register",
            ),
            (
                format!("{head}0.1,0,5\n0,0,5\n"),
                "line 3: range_m is '0', not a range above 0, to 2 m",
            ),
            (
                format!("{head}0.1,100,5\n"),
                "line 2: angle_deg is '100', not an angle up to 90 degrees",
            ),
            (
                format!("{head}0.1,0,inf\n"),
                "line 2: counts is 'inf', not counts of a 16-bit register",
            ),
        ] {
            let error = Table::parse(&text).unwrap_err();
            assert_eq!(error.to_string(), said, "{text:?}");
        }
    }

    #[test]
    fn no_text_makes_the_parser_panic() {
        for text in [
            "\0",
            ",,,\n,,,",
            "\"",
            "range_m,angle_deg,counts\n\u{1f916},,",
        ] {
            assert!(Table::parse(text).is_err(), "{text:?}");
        }
        assert!(Table::load(Path::new("/nowhere/at/all.csv")).is_err());
    }
}
