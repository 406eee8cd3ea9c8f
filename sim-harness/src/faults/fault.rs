//! Faults as they are written.

use std::fmt;

use super::{Component, Kind, Window};

/// A component, a kind of fault and a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// The component.
    pub component: Component,
    /// The kind.
    pub kind: Kind,
    /// The window.
    pub window: Window,
}

/// The text that is read back; a fault of the link without `link=`, because these are joined.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.component != Component::Link {
            write!(f, "{}=", self.component)?;
        }
        f.write_str(&self.kind.in_words(self.component))?;
        self.window.write(self.component, f)
    }
}

/// The faults of the robot's parts and of the line.
///
/// Read from text and printed as text; a printed text is read back unchanged. No faults are
/// written `ok`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    pub(super) parts: Vec<Fault>,
    pub(super) line: Vec<Fault>,
}

impl Faults {
    /// The faults of the robot's parts, in the order of the text.
    #[must_use]
    pub fn parts(&self) -> &[Fault] {
        &self.parts
    }

    /// The faults of the serial line.
    #[must_use]
    pub fn line(&self) -> &[Fault] {
        &self.line
    }

    /// Whether there are no faults, neither of a part nor of the line.
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
