//! Why a source is no recording at all.

use std::{fmt, io};

use super::{Place, Refusals};
use crate::escape::whole_escaped;

/// Why a source could not be used, with its name and, where there is one, the place.
#[derive(Debug)]
pub struct LogError {
    name: String,
    place: Option<Place>,
    problem: Problem,
}

/// The error of a whole source.
#[derive(Debug)]
pub enum Problem {
    /// It cannot be read.
    Unreadable(io::Error),
    /// It has no byte.
    Empty,
    /// It is text of two bytes per character.
    Utf16,
    /// Its first MiB holds neither the header of AMiRo's text nor a frame.
    Shapeless,
    /// It does not begin with the header of AMiRo's text.
    NoHeader {
        /// Its beginning, and a guess at its numbers.
        found: String,
    },
    /// Its header names other units than micrometres and microradians.
    OtherUnits {
        /// The columns of the header.
        found: String,
    },
    /// Its numbers are in other units than they claim.
    ImplausibleUnits {
        /// The likely units, and the reason.
        found: String,
    },
    /// Every line or frame of it was refused.
    NothingUsable(Refusals),
    /// It was written to while it was read.
    Changed,
}

impl LogError {
    pub(super) fn new(name: &str, place: Option<Place>, problem: Problem) -> Self {
        Self {
            name: whole_escaped(name.chars()),
            place,
            problem,
        }
    }

    /// The error.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The place of the error.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        self.place
    }
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        if let Some(place) = self.place {
            write!(f, ", {place}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for LogError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            Problem::Unreadable(error) => Some(error),
            _ => None,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const HEADER: &str = "PRV 0 ... PRV 7, X [ym], Y [ym], Theta [yrad] with tabs between";
        match self {
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
            Self::Empty => f.write_str("is empty"),
            Self::Utf16 => f.write_str("is UTF-16 text; expected UTF-8"),
            Self::Shapeless => write!(
                f,
                "neither a frame nor the header {HEADER} in the first 1 MiB"
            ),
            Self::NoHeader { found } => write!(f, "{found}; expected the header {HEADER}"),
            Self::OtherUnits { found } => write!(
                f,
                "the header names {found}; expected X [ym], Y [ym], Theta [yrad], \
                 which are micrometres and microradians"
            ),
            Self::ImplausibleUnits { found } => f.write_str(found),
            Self::Changed => f.write_str("changed while it was read"),
            Self::NothingUsable(refusals) if refusals.is_empty() => {
                f.write_str("holds no row and no frame to use")
            }
            Self::NothingUsable(refusals) => {
                write!(f, "holds no row and no frame to use\n{refusals}")
            }
        }
    }
}
