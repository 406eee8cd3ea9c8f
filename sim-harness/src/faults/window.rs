//! When a fault is active.

use std::fmt;
use std::ops::Range;
use std::time::Duration;

use super::Component;
use crate::quantity::{in_words, time, whole};

/// The window of a fault: `@5s`, `@5s..8s`, `@..8s`, of the link also `@10B..20B`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// The whole drive: no window is given.
    #[default]
    Always,
    /// From one time up to another; without the second, to the end.
    Time(Duration, Option<Duration>),
    /// From one byte of those sent, counted from 0, and up to another.
    Bytes(u64, Option<u64>),
}

impl Window {
    /// The window after the `@`; `None` for an invalid or empty window.
    pub(super) fn parse(component: Component, text: &str) -> Option<Self> {
        let (from, to) = match text.split_once("..") {
            None => (text, None),
            Some((from, to)) => (from, Some(to)),
        };
        if component == Component::Link
            && let Some(first) = from.strip_suffix('B')
        {
            let to = match to {
                None => None,
                Some(to) => Some(whole(to.strip_suffix('B')?)?),
            };
            let from = whole(first)?;
            return to
                .is_none_or(|to| from < to)
                .then_some(Self::Bytes(from, to));
        }
        let from = match (from, to) {
            ("", Some(_)) => Duration::ZERO,
            _ => time(from)?,
        };
        let to = match to {
            None => None,
            Some(to) => Some(time(to)?),
        };
        if component != Component::Link && from.is_zero() && to.is_none() {
            return Some(Self::Always);
        }
        to.is_none_or(|to| from < to)
            .then_some(Self::Time(from, to))
    }

    /// Whether a byte with a time and a number is inside.
    #[must_use]
    pub fn contains(&self, now: Duration, byte: u64) -> bool {
        match *self {
            Self::Always => true,
            Self::Time(from, to) => now >= from && to.is_none_or(|to| now < to),
            Self::Bytes(from, to) => byte >= from && to.is_none_or(|to| byte < to),
        }
    }

    /// The window in microseconds; the whole drive for one that counts bytes.
    #[must_use]
    pub fn range_us(&self) -> Range<u64> {
        match *self {
            Self::Always | Self::Bytes(..) => 0..u64::MAX,
            Self::Time(from, to) => micros(from)..to.map_or(u64::MAX, micros),
        }
    }

    /// Writes the window as it is read. The link's times are all in seconds, and its
    /// windows have a begin, as in recordings.
    pub(super) fn write(self, component: Component, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_of_link = component == Component::Link;
        let words = |time: Duration| match is_of_link {
            true => format!("{}s", time.as_secs_f64()),
            false => in_words(time),
        };
        match self {
            Self::Always => Ok(()),
            Self::Time(from, Some(to)) if from.is_zero() && !is_of_link => {
                write!(f, "@..{}", words(to))
            }
            Self::Time(from, None) => write!(f, "@{}", words(from)),
            Self::Time(from, Some(to)) => write!(f, "@{}..{}", words(from), words(to)),
            Self::Bytes(from, None) => write!(f, "@{from}B"),
            Self::Bytes(from, Some(to)) => write!(f, "@{from}B..{to}B"),
        }
    }
}

/// Microseconds of a time, which is at most a day.
pub(super) fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_their_begin_and_not_their_end() {
        let window = |text| Window::parse(Component::Link, text).unwrap();
        let at_ms = |ms| window("2s..5s").contains(Duration::from_millis(ms), 0);
        assert_eq!(
            [1999, 2000, 4999, 5000].map(at_ms),
            [false, true, true, false]
        );
        let at_byte = |byte| window("10B..20B").contains(Duration::ZERO, byte);
        assert_eq!([9, 10, 19, 20].map(at_byte), [false, true, true, false]);
    }
}
