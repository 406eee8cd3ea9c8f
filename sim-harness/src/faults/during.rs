//! Windows of time.

use std::fmt;
use std::ops::Range;
use std::time::Duration;

use super::word::micros;
use crate::quantity::{in_words, time};

/// When something is wrong: `@5s`, `@5s..8s` or `@..8s`; always if not given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct During {
    /// From then on.
    pub from: Duration,
    /// Before that time; without it for good.
    pub to: Option<Duration>,
}

impl During {
    /// What stands behind the `@`; `None` for what is no window or ends as it begins.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (from, to) = match text.split_once("..") {
            None => (time(text)?, None),
            Some(("", to)) => (Duration::ZERO, Some(time(to)?)),
            Some((from, to)) => (time(from)?, Some(time(to)?)),
        };
        to.is_none_or(|to| from < to).then_some(Self { from, to })
    }

    /// The same, microseconds; without an end up to the end of time.
    #[must_use]
    pub fn range_us(&self) -> Range<u64> {
        micros(self.from)..self.to.map_or(u64::MAX, micros)
    }
}

impl fmt::Display for During {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = in_words(self.from);
        match self.to.map(in_words) {
            None if self.from.is_zero() => Ok(()),
            None => write!(f, "@{from}"),
            Some(to) if self.from.is_zero() => write!(f, "@..{to}"),
            Some(to) => write!(f, "@{from}..{to}"),
        }
    }
}
