//! What is wrong with a line, in words: `ber:1e-3+off@2s..5s`.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use crate::quantity::{probability, time, whole};

/// Longest burst of dropped bytes, or of garbage, that can be asked for.
const LONGEST_BURST: u32 = 1_000_000;

/// Bytes of a burst of garbage when the word does not say.
const GARBAGE_BYTES: u32 = 64;

/// One thing that is wrong with a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineFault {
    /// `ber:R`: each bit is flipped with this probability.
    BitErrors(f64),
    /// `drop:R` or `drop:RxN`: at each byte, with this probability, it and up to N - 1
    /// bytes after it are lost; N is 1 if not given.
    Dropped {
        /// Probability that a burst begins at a byte.
        rate: f64,
        /// Longest burst, bytes.
        most: u32,
    },
    /// `garbage:R` or `garbage:RxN`: before each byte, with this probability, 1 to N
    /// random bytes; N is 64 if not given.
    Garbage {
        /// Probability in front of a byte.
        rate: f64,
        /// Longest piece, bytes.
        most: u32,
    },
    /// `lose:R`: each frame is lost with this probability.
    Lost(f64),
    /// `twice:R`: each frame comes twice with this probability.
    Twice(f64),
    /// `swap:R`: each frame comes behind the next one with this probability.
    Swapped(f64),
    /// `cut:R`: each frame ends early, without its zero byte, with this probability.
    Cut(f64),
    /// `delay:2ms`: everything comes so much later.
    Delay(Duration),
    /// `slow:9600`: so many bytes a second and no more; what is more comes later.
    Slow(u32),
    /// `off`: nothing passes.
    Off,
}

/// When something is wrong: `@2s..5s`, `@500ms`, `@..5s`, `@1000B..2000B`; always if not
/// given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Window {
    /// From the first byte to the last.
    #[default]
    Always,
    /// Between two times since the line was first used; without an end for ever.
    Time(Duration, Option<Duration>),
    /// Between two bytes of those sent, counted from 0; without an end for ever.
    Bytes(u64, Option<u64>),
}

impl Window {
    /// Whether a byte that is sent at a time, as which of all, is inside.
    #[must_use]
    pub fn contains(&self, now: Duration, byte: u64) -> bool {
        match *self {
            Self::Always => true,
            Self::Time(from, to) => now >= from && to.is_none_or(|to| now < to),
            Self::Bytes(from, to) => byte >= from && to.is_none_or(|to| byte < to),
        }
    }
}

/// All that is wrong with a line: words joined by `+`, each with a window or without.
///
/// Nothing at all is written `ok`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineFaults(Vec<(LineFault, Window)>);

impl LineFaults {
    /// Faults and when each of them holds.
    #[must_use]
    pub fn new(faults: impl IntoIterator<Item = (LineFault, Window)>) -> Self {
        Self(faults.into_iter().collect())
    }

    /// The faults, in the order in which they were named.
    pub fn iter(&self) -> impl Iterator<Item = &(LineFault, Window)> {
        self.0.iter()
    }
}

/// A word that says nothing that can be wrong with a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{word}\" {problem}")]
pub struct LineFaultError {
    word: String,
    problem: &'static str,
}

impl LineFaultError {
    /// The word as it was given.
    #[must_use]
    pub fn word(&self) -> &str {
        &self.word
    }
}

const UNKNOWN: &str = "is nothing that can be wrong with a line: ok, off, ber:R, drop:R, \
                       garbage:R, lose:R, twice:R, swap:R, cut:R, delay:TIME or slow:N, \
                       each with @FROM or @FROM..TO or without";
const NO_RATE: &str = "needs a probability from 0 to 1, as in ber:1e-3";
const NO_BURST: &str = "needs a probability and up to 1000000 bytes, as in drop:1e-4x300";
const NO_TIME: &str = "needs a time of at most a day, as in 2s or 50ms";
const NO_SPEED: &str = "needs bytes a second, at least 1, as in slow:9600";
const NO_VALUE: &str = "takes no value";
const NO_WINDOW: &str = "has no window that begins before it ends, as in @2s..5s or @100B..200B";

impl FromStr for LineFaults {
    type Err = LineFaultError;

    fn from_str(text: &str) -> Result<Self, LineFaultError> {
        if text == "ok" {
            return Ok(Self::default());
        }
        text.split('+')
            .map(fault)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// A word: what, a value, a window.
fn fault(word: &str) -> Result<(LineFault, Window), LineFaultError> {
    let wrong = |problem| LineFaultError {
        word: word.to_owned(),
        problem,
    };
    let (what, window) = match word.split_once('@') {
        None => (word, Window::Always),
        Some((what, window)) => (what, self::window(window).ok_or_else(|| wrong(NO_WINDOW))?),
    };
    let (name, value) = match what.split_once(':') {
        None => (what, None),
        Some((name, value)) => (name, Some(value)),
    };
    let given = value.unwrap_or_default();
    let rate = || probability(given).ok_or_else(|| wrong(NO_RATE));
    let burst = |most| burst(given, most).ok_or_else(|| wrong(NO_BURST));
    let fault = match name {
        "ber" => LineFault::BitErrors(rate()?),
        "lose" => LineFault::Lost(rate()?),
        "twice" => LineFault::Twice(rate()?),
        "swap" => LineFault::Swapped(rate()?),
        "cut" => LineFault::Cut(rate()?),
        "drop" => {
            let (rate, most) = burst(1)?;
            LineFault::Dropped { rate, most }
        }
        "garbage" => {
            let (rate, most) = burst(GARBAGE_BYTES)?;
            LineFault::Garbage { rate, most }
        }
        "delay" => LineFault::Delay(time(given).ok_or_else(|| wrong(NO_TIME))?),
        "slow" => match whole(given) {
            Some(speed @ 1..=0xffff_ffff) => LineFault::Slow(speed as u32),
            _ => return Err(wrong(NO_SPEED)),
        },
        "off" if value.is_some() => return Err(wrong(NO_VALUE)),
        "off" => LineFault::Off,
        _ => return Err(wrong(UNKNOWN)),
    };
    Ok((fault, window))
}

fn burst(text: &str, most: u32) -> Option<(f64, u32)> {
    let (rate, most) = match text.split_once('x') {
        None => (text, u64::from(most)),
        Some((rate, most)) => (rate, whole(most)?),
    };
    let is_legal = (1..=u64::from(LONGEST_BURST)).contains(&most);
    Some((probability(rate)?, is_legal.then_some(most as u32)?))
}

fn window(text: &str) -> Option<Window> {
    let (from, to) = match text.split_once("..") {
        None => (text, None),
        Some((from, to)) => (from, Some(to)),
    };
    if let Some(first) = from.strip_suffix('B') {
        let to = match to {
            None => None,
            Some(to) => Some(whole(to.strip_suffix('B')?)?),
        };
        let from = whole(first)?;
        return to
            .is_none_or(|to| from < to)
            .then_some(Window::Bytes(from, to));
    }
    let from = match (from, to) {
        ("", Some(_)) => Duration::ZERO,
        _ => time(from)?,
    };
    let to = match to {
        None => None,
        Some(to) => Some(time(to)?),
    };
    to.is_none_or(|to| from < to)
        .then_some(Window::Time(from, to))
}

impl fmt::Display for LineFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("ok");
        }
        for (place, (fault, window)) in self.0.iter().enumerate() {
            let joint = if place == 0 { "" } else { "+" };
            write!(f, "{joint}{fault}{window}")?;
        }
        Ok(())
    }
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::BitErrors(rate) => write!(f, "ber:{rate}"),
            Self::Dropped { rate, most: 1 } => write!(f, "drop:{rate}"),
            Self::Dropped { rate, most } => write!(f, "drop:{rate}x{most}"),
            Self::Garbage { rate, most } => write!(f, "garbage:{rate}x{most}"),
            Self::Lost(rate) => write!(f, "lose:{rate}"),
            Self::Twice(rate) => write!(f, "twice:{rate}"),
            Self::Swapped(rate) => write!(f, "swap:{rate}"),
            Self::Cut(rate) => write!(f, "cut:{rate}"),
            Self::Delay(time) => write!(f, "delay:{}s", time.as_secs_f64()),
            Self::Slow(speed) => write!(f, "slow:{speed}"),
            Self::Off => f.write_str("off"),
        }
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Always => Ok(()),
            Self::Time(from, None) => write!(f, "@{}s", from.as_secs_f64()),
            Self::Time(from, Some(to)) => {
                write!(f, "@{}s..{}s", from.as_secs_f64(), to.as_secs_f64())
            }
            Self::Bytes(from, None) => write!(f, "@{from}B"),
            Self::Bytes(from, Some(to)) => write!(f, "@{from}B..{to}B"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_printed_and_read_again_as_it_was() {
        for (text, printed) in [
            ("ok", "ok"),
            ("ber:1e-3", "ber:0.001"),
            ("drop:1e-4", "drop:0.0001"),
            ("drop:1e-4x300@2s..5s", "drop:0.0001x300@2s..5s"),
            ("garbage:0.5", "garbage:0.5x64"),
            ("off@2s..5s", "off@2s..5s"),
            ("off@500ms", "off@0.5s"),
            ("off@..8s", "off@0s..8s"),
            ("off@10B..20B+off@90B", "off@10B..20B+off@90B"),
            ("slow:9600+delay:20ms", "slow:9600+delay:0.02s"),
            (
                "lose:0.1+twice:0.2+swap:0.3+cut:0.4",
                "lose:0.1+twice:0.2+swap:0.3+cut:0.4",
            ),
        ] {
            let faults: LineFaults = text.parse().unwrap();
            assert_eq!(faults.to_string(), printed);
            assert_eq!(printed.parse(), Ok(faults), "{text}");
        }
    }

    #[test]
    fn a_word_that_is_wrong_is_named() {
        for (text, word) in [
            ("", ""),
            ("bear:1e-3", "bear:1e-3"),
            ("ber", "ber"),
            ("ber:", "ber:"),
            ("ber:1.5", "ber:1.5"),
            ("ber:-0.1", "ber:-0.1"),
            ("ber:NaN", "ber:NaN"),
            ("ber:1e-3 ", "ber:1e-3 "),
            ("ber:1e-3+", ""),
            ("ber:1e-3+drop:0.1x0", "drop:0.1x0"),
            ("drop:0.1x1000001", "drop:0.1x1000001"),
            ("slow:0", "slow:0"),
            ("slow:+5", "slow:"),
            ("off:1", "off:1"),
            ("off@5s..2s", "off@5s..2s"),
            ("off@2s..5", "off@2s..5"),
            ("off@2s..50B", "off@2s..50B"),
            ("off@..", "off@.."),
            ("delay:1h", "delay:1h"),
            ("delay:1e9s", "delay:1e9s"),
            ("ok+off", "ok"),
        ] {
            let error = text.parse::<LineFaults>().unwrap_err();
            assert_eq!(error.word(), word, "{text}: {error}");
            assert!(
                error.to_string().starts_with(&format!("\"{word}\" ")),
                "{error}"
            );
        }
    }

    #[test]
    fn windows_hold_their_begin_and_not_their_end() {
        let faults: LineFaults = "off@2s..5s+off@10B..20B".parse().unwrap();
        let at = |place: usize, ms, byte| {
            let (_, window) = faults.iter().nth(place).unwrap();
            window.contains(Duration::from_millis(ms), byte)
        };
        assert_eq!(
            [1999, 2000, 4999, 5000].map(|ms| at(0, ms, 0)),
            [false, true, true, false]
        );
        assert_eq!(
            [9, 10, 19, 20].map(|byte| at(1, 0, byte)),
            [false, true, true, false]
        );
    }
}
