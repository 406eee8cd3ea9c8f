//! What an experiment is to show, and whether it does.

use std::fmt;

/// One line of an experiment's verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentCheck {
    /// What is to hold, with the figures.
    pub text: String,
    /// Whether it does.
    pub holds: bool,
}

impl ExperimentCheck {
    /// A figure that must be at most a limit.
    #[must_use]
    pub fn at_most(name: &str, value: f64, limit: f64) -> Self {
        Self {
            text: format!("{name}: {value:.3}, at most {limit:.3}"),
            // A NaN holds nothing.
            holds: value <= limit,
        }
    }

    /// A figure that must be at least a limit.
    #[must_use]
    pub fn at_least(name: &str, value: f64, limit: f64) -> Self {
        Self {
            text: format!("{name}: {value:.3}, at least {limit:.3}"),
            holds: value >= limit,
        }
    }

    /// A statement that holds or does not.
    #[must_use]
    pub fn new(text: String, holds: bool) -> Self {
        Self { text, holds }
    }
}

impl fmt::Display for ExperimentCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = if self.holds { "PASS" } else { "FAIL" };
        write!(f, "{verdict}  {}", self.text)
    }
}
