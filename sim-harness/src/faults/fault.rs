//! Faults as they were named.

use std::fmt;

use super::{Component, Kind, Window};

/// A component, what is wrong with it, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Which component.
    pub component: Component,
    /// What is wrong.
    pub kind: Kind,
    /// When.
    pub window: Window,
}

/// As it is read; a fault of the link without `link=`, for these are joined.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.component != Component::Link {
            write!(f, "{}=", self.component)?;
        }
        f.write_str(&self.kind.in_words(self.component))?;
        self.window.write(self.component, f)
    }
}

/// All that is to break: faults of the robot's parts, and those of the line.
///
/// Read from text and printed as text; what is printed is read back as it was. Nothing at
/// all is written `ok`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    pub(super) parts: Vec<Fault>,
    pub(super) line: Vec<Fault>,
}

impl Faults {
    /// What is wrong with the robot's parts, in the order in which it was named.
    #[must_use]
    pub fn parts(&self) -> &[Fault] {
        &self.parts
    }

    /// What is wrong with the serial line.
    #[must_use]
    pub fn line(&self) -> &[Fault] {
        &self.line
    }

    /// Whether nothing was named, neither a part nor anything of the line.
    #[must_use]
    pub fn are_none(&self) -> bool {
        self.parts.is_empty() && self.line.is_empty()
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.are_none() {
            return f.write_str("ok");
        }
        let mut words: Vec<String> = self.parts.iter().map(Fault::to_string).collect();
        if !self.line.is_empty() {
            let line: Vec<String> = self.line.iter().map(Fault::to_string).collect();
            words.push(format!("link={}", line.join("+")));
        }
        f.write_str(&words.join(", "))
    }
}
