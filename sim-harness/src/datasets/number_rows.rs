//! Rows of numbers in a JSON list of lists, read one at a time in bounded memory.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::error::{DatasetError, RefusedRow, shown};
use crate::escape::escaped;
use crate::log::Place;

/// Longest number, bytes.
const MAX_NUMBER: usize = 32;

/// The rows of a file; the place of a row is the byte of its bracket.
#[derive(Debug)]
pub(super) struct NumberRows {
    file: String,
    reader: BufReader<File>,
    /// Numbers of a row.
    count: usize,
    read: u64,
    length: Option<u64>,
    /// First byte of the row that was read last.
    row_at: u64,
}

impl NumberRows {
    /// Opens a file whose rows have `count` numbers each.
    pub(super) fn open(path: &Path, count: usize) -> Result<Self, DatasetError> {
        let file = shown(path);
        let source = match File::open(path) {
            Ok(source) => source,
            Err(source) => return Err(DatasetError::Read { file, source }),
        };
        let length = source.metadata().ok().map(|found| found.len());
        let mut rows = Self {
            file,
            reader: BufReader::new(source),
            count,
            read: 0,
            length,
            row_at: 0,
        };
        // The bracket of the list.
        rows.skip_to(b'[')?;
        Ok(rows)
    }

    /// The bytes read so far, and the file's length, where it has one.
    pub(super) fn progress(&self) -> (u64, Option<u64>) {
        (self.read, self.length)
    }

    /// The refusal of the row that was read last.
    pub(super) fn refused(&self, reason: String) -> RefusedRow {
        RefusedRow {
            file: self.file.clone(),
            place: Place::Byte(self.row_at),
            reason,
        }
    }

    /// The next row; `None` at the end of the file.
    ///
    /// A row is refused for what is no number, for another number of numbers, and where
    /// the file ends within it.
    pub(super) fn advance(&mut self) -> Result<Option<Result<Vec<f64>, RefusedRow>>, DatasetError> {
        if !self.skip_to(b'[')? {
            return Ok(None);
        }
        self.row_at = self.read - 1;
        let mut row = Vec::with_capacity(self.count);
        let mut number = Vec::with_capacity(MAX_NUMBER);
        let mut wrong = None;
        let mut found = 0_u64;
        loop {
            let Some(byte) = self.byte()? else {
                return Ok(Some(Err(
                    self.refused("the file ends within the row".to_owned())
                )));
            };
            if byte != b',' && byte != b']' {
                // A longer number keeps one byte too many, and is refused.
                if number.len() <= MAX_NUMBER {
                    number.push(byte);
                }
                continue;
            }
            found += 1;
            match number_in(&number) {
                Ok(value) if row.len() < self.count => row.push(value),
                Ok(_) => {}
                Err(shown) => {
                    wrong.get_or_insert_with(|| format!("'{shown}' is no number"));
                }
            }
            number.clear();
            if byte == b']' {
                break;
            }
        }
        if wrong.is_none() && found != self.count as u64 {
            wrong = Some(format!("{found} values where {} are expected", self.count));
        }
        Ok(Some(match wrong {
            Some(reason) => Err(self.refused(reason)),
            None => Ok(row),
        }))
    }

    /// Passes over the bytes up to one behind a given byte; false without one.
    fn skip_to(&mut self, wanted: u8) -> Result<bool, DatasetError> {
        while let Some(byte) = self.byte()? {
            if byte == wanted {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn byte(&mut self) -> Result<Option<u8>, DatasetError> {
        let next = match self.reader.fill_buf() {
            Ok(buffer) => buffer.first().copied(),
            Err(source) => {
                let file = self.file.clone();
                return Err(DatasetError::Read { file, source });
            }
        };
        if next.is_some() {
            self.reader.consume(1);
            self.read += 1;
        }
        Ok(next)
    }
}

/// The number in some bytes, or the bytes as an error shows them.
fn number_in(bytes: &[u8]) -> Result<f64, String> {
    let shown = || escaped(String::from_utf8_lossy(bytes).trim());
    if bytes.len() > MAX_NUMBER {
        return Err(shown());
    }
    let text = core::str::from_utf8(bytes).ok();
    let value = text.and_then(|text| text.trim().parse().ok());
    value
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(shown)
}
