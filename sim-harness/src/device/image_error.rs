//! Why there is no flash image.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::escape::whole_escaped;

/// Why there is no image.
#[derive(Debug)]
pub enum ImageError {
    /// Cargo could not be run or failed.
    Build(String),
    /// The file cannot be read.
    Read(PathBuf, std::io::Error),
    /// The file is no ELF file of this target.
    NotAnImage(PathBuf, String),
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Build(reason) => write!(f, "the flash image was not built: {reason}"),
            Self::Read(path, error) => write!(f, "{}: {error}", shown(path)),
            Self::NotAnImage(path, reason) => {
                write!(f, "{}: no flash image: {reason}", shown(path))
            }
        }
    }
}

impl std::error::Error for ImageError {}

fn shown(path: &Path) -> String {
    whole_escaped(path.to_string_lossy().chars())
}
