//! Why a drive, or a row of it, was not read.

use std::fmt;
use std::path::Path;

use super::PoseSource;
use crate::drive::NoSteps;
use crate::escape::whole_escaped;
use crate::log::{LogError, Place};

/// Why a drive was not read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The scenario in a simulated recording cannot be used.
    #[error("{file}, the scenario in it: {source}")]
    Scenario {
        /// The file's name, escaped.
        file: String,
        /// What is wrong.
        source: crate::world::ScenarioError,
    },
    /// The filter does not run under the recording's configuration.
    #[error("{file}: {source}")]
    Run {
        /// The file's name, escaped.
        file: String,
        /// What is wrong.
        source: crate::RunError,
    },
    /// A file of walls beside the recording cannot be used.
    #[error(transparent)]
    Walls(crate::world::WallFileError),
    /// A file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file's name, escaped.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The path leads to no known format.
    #[error("{file}: of no known format; looked for {looked_for}")]
    UnknownFormat {
        /// The file's name, escaped.
        file: String,
        /// What each format looks for.
        looked_for: String,
    },
    /// No row of a file is of the format.
    #[error("{file}: no row of the format {format}{}", first(.rows))]
    NoRow {
        /// The file's name, escaped.
        file: String,
        /// The format's name.
        format: &'static str,
        /// What was refused.
        rows: RefusedRows,
    },
    /// A recording of an AMiRo is of no use as a whole.
    #[error(transparent)]
    Recording(#[from] LogError),
    /// A recording of an AMiRo leads to no step.
    #[error("{file}: {reason}")]
    NoSteps {
        /// The file's name, escaped.
        file: String,
        /// Why.
        reason: NoSteps,
    },
    /// The rig has other sensors than the recording.
    #[error("rig {rig}: {needed}")]
    Rig {
        /// The rig's name.
        rig: String,
        /// What the recording needs.
        needed: String,
    },
    /// No recording of the format carries the poses that were asked for.
    #[error("{file}: recordings of this format have no {wanted} poses")]
    NoSuchPoses {
        /// The file's name, escaped.
        file: String,
        /// The poses that were asked for.
        wanted: PoseSource,
    },
    /// The recording does not carry the poses that were asked for.
    #[error("{file} is missing: the recording has no {wanted} poses")]
    NoPoses {
        /// The file that would hold them, escaped.
        file: String,
        /// The poses that were asked for.
        wanted: PoseSource,
    },
}

fn first(rows: &RefusedRows) -> String {
    rows.first
        .first()
        .map_or_else(String::new, |row| format!("; {row}"))
}

/// A row that was not used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedRow {
    /// The file's name, escaped.
    pub file: String,
    /// Where it is.
    pub place: Place,
    /// Why.
    pub reason: String,
}

impl fmt::Display for RefusedRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}: {}", self.file, self.place, self.reason)
    }
}

/// Rows that were not used: their number, and the first five.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RefusedRows {
    /// How many.
    pub count: u64,
    /// The first of them.
    pub first: Vec<RefusedRow>,
}

impl RefusedRows {
    /// Rows that are listed.
    const LISTED: usize = 5;

    /// Adds a row.
    pub(super) fn add(&mut self, row: RefusedRow) {
        self.count += 1;
        if self.first.len() < Self::LISTED {
            self.first.push(row);
        }
    }
}

impl fmt::Display for RefusedRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in &self.first {
            writeln!(f, "{row}")?;
        }
        write!(f, "{} rows refused", self.count)
    }
}

/// A file's name as errors show it.
pub(super) fn shown(path: &Path) -> String {
    whole_escaped(path.to_string_lossy().chars())
}
