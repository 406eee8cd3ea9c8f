//! Measured counts: rows of range, angle, counts and weight from a CSV text.
//!
//! The first line that is neither empty nor a `#` comment names the columns, in any
//! order: `range_m`, `range_cm` or `range_mm`, `angle_deg` or `angle_rad`, `counts`,
//! and optionally `weight` (default 1). Other columns are ignored. Every row has as
//! many values as the header has names. Names and values may stand in quotes.
//!
//! Range and angle are those of the surface's nearest point: for a wall its perpendicular
//! distance, and the bearing of its normal off the sensor's axis.
//!
//! Commas separate values, or semicolons where the header has one. Numbers have decimal
//! points; between semicolons they may have decimal commas instead, in the whole table.

use std::path::Path;

use csv::StringRecord;

use crate::bounded::read_at_most;
use crate::escape::lines_escaped;

/// Longest file, bytes.
const MAX_BYTES: u64 = 16 << 20;
/// Longest line, bytes.
const MAX_LINE: usize = 64 << 10;
/// Largest range, metres.
const MAX_RANGE_M: f64 = 2.0;
/// Largest counts: the 16-bit register, and as much below.
const MAX_COUNTS: f64 = 65_535.0;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationPoint {
    /// Distance of the surface's nearest point from the sensor, metres (x).
    pub range_m: f64,
    /// Bearing of that point off the sensor's axis, radians (theta).
    pub angle_rad: f64,
    /// Counts, raw or above an offset: the difference is part of beta (s).
    pub counts: f64,
    /// Weight: the number of measurements of the common noise that this one is worth.
    pub weight: f64,
}

/// Measurements that a law can be fitted to; each is finite and within range.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    rows: Vec<CalibrationPoint>,
}

/// The reason for which a table is refused, and the line.
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

/// A fault of a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableProblem {
    /// The file could not be read.
    #[error("cannot read: {0}")]
    Read(String),
    /// No header, or one that lacks a column or names it twice.
    #[error("the header {0}")]
    Header(String),
    /// A line is longer than any measurement.
    #[error("longer than 64 KiB")]
    LongLine,
    /// A row has more or fewer values than the header has names.
    #[error("{found} values, but the header names {wanted} columns{hint}")]
    FieldCount {
        /// Values of the row.
        found: usize,
        /// Names of the header.
        wanted: usize,
        /// A possible reason; may be empty.
        hint: &'static str,
    },
    /// A number with a decimal point in a table that has decimal commas.
    #[error("a decimal point in '{0}', but the table has decimal commas too")]
    MixedDecimals(String),
    /// A row lacks a column's value.
    #[error("no {0}")]
    NoValue(&'static str),
    /// A value is no number, or outside the range of a sensor.
    #[error("{column} is '{value}', not {wanted}")]
    Value {
        /// The column.
        column: &'static str,
        /// The text.
        value: String,
        /// The legal values.
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

/// The columns of a row's values.
#[derive(Clone, Copy, Debug)]
struct Columns {
    /// Number of names in the header.
    count: usize,
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
        let bytes = read_at_most(path, MAX_BYTES).map_err(|error| read(error.to_string()))?;
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
        if let Some((line, _)) = (1..)
            .zip(text.lines())
            .find(|(_, text)| text.len() > MAX_LINE)
        {
            return Err(TableProblem::LongLine.at(line));
        }
        // Without empty lines, so that a record's line is the place of its own line here.
        let (numbers, lines): (Vec<usize>, Vec<&str>) = (1..)
            .zip(text.lines())
            .map(|(line, text)| (line, uncommented(text).trim()))
            .filter(|(_, text)| !text.is_empty())
            .unzip();
        let separator = match lines.first() {
            Some(header) if header.contains(';') => b';',
            Some(_) => b',',
            None => return Err(TableProblem::Empty.anywhere()),
        };
        let records = records(&lines.join("\n"), separator);
        let mut records = records.into_iter().map(|(place, record)| {
            let line = place.checked_sub(1).and_then(|place| numbers.get(place));
            let line = line.copied().unwrap_or(place);
            (line, record)
        });
        let Some((line, header)) = records.next() else {
            return Err(TableProblem::Empty.anywhere());
        };
        let columns = Columns::named_by(&header).map_err(|problem| problem.at(line))?;
        let rows: Vec<(usize, StringRecord)> = records.collect();
        let has_commas = separator == b';'
            && rows
                .iter()
                .any(|(_, row)| columns.numbers(row).any(|number| number.contains(',')));
        let rows: Vec<_> = rows
            .iter()
            .map(|(line, row)| {
                columns
                    .row(row, separator, has_commas)
                    .map_err(|problem| problem.at(*line))
            })
            .collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(TableProblem::Empty.anywhere());
        }
        Ok(Self { rows })
    }

    /// The measurements, in the order of the text; at least one.
    #[must_use]
    pub fn rows(&self) -> &[CalibrationPoint] {
        &self.rows
    }
}

impl Columns {
    fn named_by(header: &StringRecord) -> Result<Self, TableProblem> {
        let names: Vec<String> = header.iter().map(|it| bare(it).to_lowercase()).collect();
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
                let known: Vec<_> = wanted.iter().map(|(name, _)| *name).collect();
                let (names, known) = (names.join(","), known.join(" or "));
                TableProblem::Header(format!("'{names}' names no {known}"))
            };
            among(wanted)?.ok_or_else(missing)
        };
        Ok(Self {
            count: names.len(),
            range: needed(&[("range_m", 1.0), ("range_cm", 0.01), ("range_mm", 0.001)])?,
            angle: needed(&[
                ("angle_deg", core::f64::consts::PI / 180.0),
                ("angle_rad", 1.0),
            ])?,
            counts: needed(&[("counts", 1.0)])?,
            weight: among(&[("weight", 1.0)])?,
        })
    }

    /// A row's values that are numbers, as they are written.
    fn numbers<'r>(&self, row: &'r StringRecord) -> impl Iterator<Item = &'r str> {
        [
            Some(self.range),
            Some(self.angle),
            Some(self.counts),
            self.weight,
        ]
        .into_iter()
        .flatten()
        .filter_map(|column| row.get(column.place))
    }

    fn row(
        &self,
        row: &StringRecord,
        separator: u8,
        has_commas: bool,
    ) -> Result<CalibrationPoint, TableProblem> {
        if row.len() != self.count {
            return Err(TableProblem::FieldCount {
                found: row.len(),
                wanted: self.count,
                hint: if row.len() > self.count && separator == b',' {
                    ": decimal commas need semicolons between the values"
                } else {
                    ""
                },
            });
        }
        if has_commas && let Some(number) = self.numbers(row).find(|it| it.contains('.')) {
            return Err(TableProblem::MixedDecimals(number.to_owned()));
        }
        let value = |column: Column, wanted, is_legal: &dyn Fn(f64) -> bool| {
            let field = row
                .get(column.place)
                .map(bare)
                .filter(|field| !field.is_empty())
                .ok_or(TableProblem::NoValue(column.name))?;
            let number = if has_commas {
                field.replace(',', ".").parse()
            } else {
                field.parse()
            };
            let number = number.ok().map(|number: f64| number * column.unit);
            number
                .filter(|number| is_legal(*number))
                .ok_or_else(|| TableProblem::Value {
                    column: column.name,
                    value: field.to_owned(),
                    wanted,
                })
        };
        let is_range = |metres| metres > 0.0 && metres <= MAX_RANGE_M;
        // Rounding may put 90 degrees above a right angle.
        let is_angle = |radians: f64| radians.abs() < core::f64::consts::FRAC_PI_2 + 1e-9;
        let is_count = |counts: f64| counts.abs() <= MAX_COUNTS;
        let is_weight = |weight| weight > 0.0 && weight <= 1e6;
        Ok(CalibrationPoint {
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

/// A text's records, each with the line that it begins on, from 1.
fn records(text: &str, separator: u8) -> Vec<(usize, StringRecord)> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        // Rows of another length are refused with a message of their own.
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut records = Vec::new();
    let mut record = StringRecord::new();
    // A text in memory is read without errors.
    while reader.read_record(&mut record).unwrap_or(false) {
        let line = record.position().map_or(0, csv::Position::line);
        records.push((usize::try_from(line).unwrap_or(0), record.clone()));
    }
    records
}

/// A line up to its comment; a `#` in quotes begins none.
fn uncommented(line: &str) -> &str {
    let mut is_quoted = false;
    for (place, letter) in line.char_indices() {
        match letter {
            '"' => is_quoted = !is_quoted,
            '#' if !is_quoted => return line.get(..place).unwrap_or(line),
            _ => {}
        }
    }
    line
}

/// A value without the blanks and quotes around it; the reader leaves quotes that stand
/// behind a blank.
fn bare(field: &str) -> &str {
    field.trim().trim_matches('"').trim()
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
            (
                format!("{head}0.1,0\n"),
                "line 2: 2 values, but the header names 3 columns",
            ),
            (
                format!("{head}\n# one\n0.1,0,5\n0.1,0,5,7\n"),
                "line 5: 4 values, but the header names 3 columns: \
                 decimal commas need semicolons between the values",
            ),
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

    /// A row's range in centimetres and its counts.
    fn read(text: &str) -> Result<Vec<(f64, f64)>, String> {
        let table = Table::parse(text).map_err(|error| error.to_string())?;
        let rounded = |number: f64| (number * 1e6).round() / 1e6;
        let rows = table.rows().iter();
        Ok(rows
            .map(|row| (rounded(row.range_m * 100.0), row.counts))
            .collect())
    }

    #[test]
    fn decimal_commas_between_commas_are_refused_with_their_line() {
        for text in [
            "range_cm,angle_deg,counts\n5,5,0,361\n6,5,0,240\n",
            "counts,range_cm,angle_deg\n361,5,5,0\n240,6,5,0\n",
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with("line 2: 4 values"), "{error}");
            assert!(error.contains("semicolons"), "{error}");
        }
        let quoted = read("range_cm,angle_deg,counts\n\"5,5\",0,361\n").unwrap_err();
        assert!(quoted.starts_with("line 2: range_cm is '5,5'"), "{quoted}");
    }

    #[test]
    fn decimal_commas_between_semicolons_are_decimal_points() {
        let rows = Ok(vec![(5.5, 361.0), (6.5, 240.25)]);
        let text = "range_cm;angle_deg;counts\r\n5,5;0;361\r\n6,5;0;240,25\r\n";
        assert_eq!(read(text), rows);
        assert_eq!(read(&text.replace(',', ".")), rows);
        let error = read(&text.replace("240,25", "240.25")).unwrap_err();
        assert_eq!(
            error,
            "line 3: a decimal point in '240.25', but the table has decimal commas too"
        );
        let error = read(&text.replace("240,25", "1,240,25")).unwrap_err();
        assert!(error.starts_with("line 3: counts is '1,240,25'"), "{error}");
    }

    #[test]
    fn quotes_blanks_and_marks_around_values_change_nothing() {
        let rows = Ok(vec![(5.5, 361.0), (6.5, 240.0)]);
        for text in [
            "\"range_cm\",\"angle_deg\",\"counts\"\n\"5.5\",\"0\",\"361\"\n\"6.5\",\"0\",\"240\"\n",
            "range_cm, angle_deg, counts\n5.5, 0, 361\n  6.5,\t0, 240  \n",
            "\u{feff}range_cm, \"angle_deg\", \"counts\"\r\n\r\n5.5, \"0\", \"361\"\r\n6.5,0,240",
            "set,range_cm,angle_deg,counts\n\"a, #1\",5.5,0,361\nb,6.5,0,240 # by eye\n",
        ] {
            assert_eq!(read(text), rows, "{text:?}");
        }
        let error = read("set,range_cm,angle_deg,counts\n\"a,5.5,0,361\nb,6.5,0,240\n");
        assert_eq!(
            error.unwrap_err(),
            "line 2: 1 values, but the header names 4 columns",
            "a quote that is never closed"
        );
    }

    #[test]
    fn a_line_beyond_64_kib_is_refused_with_its_number() {
        let long = "5".repeat(MAX_LINE + 1);
        let text = format!("range_m,angle_deg,counts\n0.1,0,5\n{long}\n");
        assert_eq!(read(&text).unwrap_err(), "line 3: longer than 64 KiB");
    }

    #[cfg(unix)]
    #[test]
    fn an_endless_file_is_given_up() {
        let error = Table::load(Path::new("/dev/zero")).unwrap_err();
        assert!(
            error.to_string().contains("more than 16777216 bytes"),
            "{error}"
        );
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
