//! The reasons for which a scenario is refused.

use std::path::{Path, PathBuf};

use crate::escape::{lines_escaped, whole_escaped};

/// Why a scenario was refused.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", whole_escaped(path.to_string_lossy().chars()))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is no scenario.
    #[error("{}: {source}", whole_escaped(name.chars()))]
    File {
        /// The file.
        name: String,
        /// Why.
        source: Box<ScenarioError>,
    },
    /// The text is no scenario; with the line.
    #[error("{}", lines_escaped(&.0.to_string()))]
    Format(#[from] toml::de::Error),
    /// A text that cannot be printed, values that are too large together, or an impossible
    /// drive.
    #[error("{key}: {what}")]
    Limit {
        /// The key, or the keys.
        key: &'static str,
        /// The value and the limit.
        what: String,
    },
}

impl ScenarioError {
    /// The same with the name of the file that the scenario came from.
    #[must_use]
    pub fn of_file(self, path: &Path) -> Self {
        let name = if is_standard_input(path) {
            "standard input".to_owned()
        } else {
            path.to_string_lossy().into_owned()
        };
        Self::File {
            name,
            source: Box::new(self),
        }
    }
}

/// Whether a path stands for standard input.
pub(super) fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}
