//! The reasons for which recorded series are not judged.

use std::path::Path;

use crate::RunError;
use crate::calibration::{FitError, FixedError, TableError};
use crate::escape::{lines_escaped, whole_escaped};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// The description of the series cannot be read.
    #[error(
        "{file}: cannot be read: {source}; it describes the series of the folder. Copy \
         scenarios/recorded_series.toml of this project to {file} and change it for your \
         recordings, or name another file with --series"
    )]
    Unreadable {
        /// The description's file, escaped.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The description is no TOML, or a key is unknown, missing or outside its range.
    #[error("{file}: {}", lines_escaped(&.source.to_string()))]
    Format {
        /// The description's file, escaped.
        file: String,
        /// The error with its line.
        source: Box<toml::de::Error>,
    },
    /// A value that does not agree with another one, or with the recording.
    #[error("{}, line {}: {}: {what}", .at.file, .at.line, .at.key)]
    Value {
        /// Where the value is.
        at: KeyPlace,
        /// What is wrong with it.
        what: String,
    },
    /// The recording gives no alpha.
    #[error("no alpha from {series}: {what}")]
    Calibration {
        /// The series.
        series: String,
        /// Why.
        what: String,
    },
    /// The filter refused its configuration.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Place of a value in the description of the series.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyPlace {
    /// The description's file, escaped.
    pub file: String,
    /// Line in the file, counted from 1.
    pub line: usize,
    /// The key.
    pub key: &'static str,
}

impl RecordedError {
    pub(super) fn unreadable(path: &Path, source: std::io::Error) -> Self {
        Self::Unreadable {
            file: whole_escaped(path.to_string_lossy().chars()),
            source,
        }
    }
}

/// Why a table of readings gives no alpha.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoAlpha {
    #[error("too few readings of a sensor that looks straight at a wall: {0}")]
    Table(#[from] TableError),
    #[error(transparent)]
    Fixed(#[from] FixedError),
    #[error(transparent)]
    Fit(#[from] FitError),
}
