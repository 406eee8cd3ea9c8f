//! Faults as they were named.

use std::fmt;

use super::{Component, During, Word};
use crate::link::LineFaults;

/// A part, what is wrong with it, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Which part.
    pub component: Component,
    /// What is wrong.
    pub word: Word,
    /// When.
    pub during: During,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            component,
            word,
            during,
        } = self;
        write!(f, "{component}={}{during}", word.in_words(*component))
    }
}

/// All that is to break: faults of the robot's parts, and those of the line.
///
/// Read from text and printed as text; what is printed is read back as it was. Nothing at
/// all is written `ok`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    pub(super) parts: Vec<Fault>,
    pub(super) line: LineFaults,
}

impl Faults {
    /// What is wrong with the robot's parts, in the order in which it was named.
    #[must_use]
    pub fn parts(&self) -> &[Fault] {
        &self.parts
    }

    /// What is wrong with the serial line.
    #[must_use]
    pub const fn line(&self) -> &LineFaults {
        &self.line
    }

    /// Whether nothing was named, neither a part nor anything of the line.
    #[must_use]
    pub fn are_none(&self) -> bool {
        self.parts.is_empty() && self.line.iter().next().is_none()
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.are_none() {
            return f.write_str("ok");
        }
        let mut words: Vec<String> = self.parts.iter().map(Fault::to_string).collect();
        if self.line.iter().next().is_some() {
            words.push(format!("link={}", self.line));
        }
        f.write_str(&words.join(", "))
    }
}
