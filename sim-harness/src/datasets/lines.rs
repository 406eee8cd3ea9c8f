//! Lines of a file, of bounded length.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::error::{DatasetError, RefusedRow, shown};
use crate::log::Place;

/// Longest line, bytes: a scan of 8192 beams has fewer.
const MAX_LINE: usize = 1 << 16;

/// The lines of a file, one at a time.
#[derive(Debug)]
pub(super) struct Lines {
    file: String,
    reader: BufReader<File>,
    line: u64,
    bytes: Vec<u8>,
    /// Whether there is a line that was read last.
    has_line: bool,
    read: u64,
    length: Option<u64>,
}

impl Lines {
    /// Opens a file.
    pub(super) fn open(path: &Path) -> Result<Self, DatasetError> {
        let file = shown(path);
        match File::open(path) {
            Ok(source) => Ok(Self {
                file,
                length: source.metadata().ok().map(|found| found.len()),
                reader: BufReader::new(source),
                line: 0,
                bytes: Vec::new(),
                has_line: false,
                read: 0,
            }),
            Err(source) => Err(DatasetError::Read { file, source }),
        }
    }

    /// The file's name, escaped.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// Whether there is a line that was read last: not at the end of the file.
    pub(super) fn has_line(&self) -> bool {
        self.has_line
    }

    /// The bytes read so far, and the file's length, where it has one.
    pub(super) fn progress(&self) -> (u64, Option<u64>) {
        (self.read, self.length)
    }

    /// Reads the next line, without its end; `false` at the end of the file.
    ///
    /// Of a line that is longer than 64 KiB the rest is passed over.
    pub(super) fn advance(&mut self) -> Result<bool, DatasetError> {
        self.bytes.clear();
        let limit = MAX_LINE as u64 + 1;
        let read = self
            .reader
            .by_ref()
            .take(limit)
            .read_until(b'\n', &mut self.bytes);
        let mut length = self.sound(read)?;
        self.has_line = length > 0;
        if !self.has_line {
            return Ok(false);
        }
        self.line += 1;
        let mut rest = Vec::new();
        while length == MAX_LINE + 1 && rest.last().or(self.bytes.last()) != Some(&b'\n') {
            rest.clear();
            let read = self
                .reader
                .by_ref()
                .take(limit)
                .read_until(b'\n', &mut rest);
            length = self.sound(read)?;
        }
        Ok(true)
    }

    /// The line that was read last.
    ///
    /// Refused if it is longer than 64 KiB, holds zero bytes, is no UTF-8 text, or has no
    /// line end: the last number of a file that was cut may have lost digits.
    pub(super) fn text(&self) -> Result<&str, RefusedRow> {
        if self.bytes.len() > MAX_LINE {
            return Err(self.refused(format!("longer than {MAX_LINE} bytes")));
        }
        let zeros = self.bytes.iter().filter(|byte| **byte == 0).count();
        if zeros > 0 {
            return Err(self.refused(format!("holds {zeros} zero bytes")));
        }
        let Some(line) = self.bytes.strip_suffix(b"\n") else {
            return Err(self.refused("the file ends within the line".to_owned()));
        };
        let text =
            core::str::from_utf8(line).map_err(|_| self.refused("no UTF-8 text".to_owned()))?;
        Ok(text.strip_suffix('\r').unwrap_or(text))
    }

    /// The refusal of the line that was read last.
    pub(super) fn refused(&self, reason: String) -> RefusedRow {
        RefusedRow {
            file: self.file.clone(),
            place: Place::Line(self.line),
            reason,
        }
    }

    fn sound(&mut self, read: std::io::Result<usize>) -> Result<usize, DatasetError> {
        self.read += read.as_ref().map_or(0, |length| *length as u64);
        read.map_err(|source| DatasetError::Read {
            file: self.file.clone(),
            source,
        })
    }
}
