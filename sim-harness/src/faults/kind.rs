//! The kinds of faults, and the values that belong to them.

use std::time::Duration;

use super::Component;
use crate::quantity::{in_words, positive, probability, signed, time};

/// Most counts that a sensor can be wrong by: a whole register.
const MOST_COUNTS: i32 = 65_535;
/// Farthest that the odometry can jump, millimetres.
const FARTHEST_MM: i32 = 100_000;
/// Lowest and highest rate of `slow`: a sensor measures 125 times per second.
const RATES_HZ: std::ops::RangeInclusive<f64> = 0.1..=100.0;
/// Longest delay.
const LATEST: Duration = Duration::from_secs(10);

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `ok`: no fault; it ends earlier ones.
    Ok,
    /// `off`: unplugged, without power, silent.
    Off,
    /// `stuck`: the same value repeatedly; a bus whose wire is held low; a multiplexer that
    /// stays where it is.
    Stuck,
    /// `garbage`: random values, disturbed bytes, random channels.
    Garbage,
    /// `wrong:+200`, `wrong:-300mm`: an offset of a sensor's counts; an offset of the
    /// odometry in millimetres along the world's x.
    Wrong(i32),
    /// `slow:20Hz`: at most that rate.
    Slow(f64),
    /// `delayed:50ms`: later by that time.
    Delayed(Duration),
    /// `intermittent:0.3`: missing for this share of the time.
    Intermittent(f64),
    /// `saturated`: a full register, as when something touches the hull.
    Saturated,
    /// A lamp shines into a sensor. It has no word.
    Lit {
        /// Result of the sensor's ambient measurements, counts.
        ambient: u16,
        /// Counts added to the proximity measurements.
        added: u16,
    },
    /// `ber:R` of the link: each bit is flipped with this probability.
    BitErrors(f64),
    /// `drop:R` or `drop:RxN` of the link: at each byte, with this probability, it and up
    /// to N - 1 bytes after it are lost; N is 1 if not given.
    Dropped {
        /// Probability that a burst begins at a byte.
        rate: f64,
        /// Longest burst, bytes.
        most: u32,
    },
    /// `garbage:R` or `garbage:RxN` of the link: before each byte, with this probability, 1
    /// to N random bytes; N is 64 if not given.
    GarbageBytes {
        /// Probability in front of a byte.
        rate: f64,
        /// Longest piece, bytes.
        most: u32,
    },
    /// `lose:R` of the link: each frame is lost with this probability.
    Lost(f64),
    /// `twice:R` of the link: each frame comes twice with this probability.
    Twice(f64),
    /// `swap:R` of the link: each frame comes behind the next one with this probability.
    Swapped(f64),
    /// `cut:R` of the link: each frame ends early, without its zero byte, with this
    /// probability.
    Cut(f64),
    /// `slow:9600` of the link: at most that many bytes per second; the rest comes later.
    BytesPerSecond(u32),
}

const NO_VALUE: &str = "takes no value";
const NO_COUNTS: &str = "needs counts from -65535 to 65535 but 0, as in wrong:+200";
const NO_JUMP: &str = "needs millimetres from -100000 to 100000 but 0, as in wrong:+500mm";
const NO_RATE: &str = "needs a rate from 0.1Hz to 100Hz, as in slow:20Hz";
const NO_DELAY: &str = "needs a time above 0 of at most 10s, as in delayed:50ms";
const NO_SHARE: &str = "needs a share from 0 to 1, as in intermittent:0.3";

/// The words' names.
const NAMES: [&str; 9] = [
    "ok",
    "off",
    "stuck",
    "garbage",
    "wrong",
    "slow",
    "delayed",
    "intermittent",
    "saturated",
];

impl Kind {
    /// The probability of a fault of frames, if the fault is of the given kind.
    pub(crate) fn rate_if(self, of_rate: fn(f64) -> Self) -> Option<f64> {
        let (Self::Lost(rate) | Self::Cut(rate) | Self::Swapped(rate) | Self::Twice(rate)) = self
        else {
            return None;
        };
        (of_rate(rate) == self).then_some(rate)
    }

    /// The kind that a component's word names: its name and, behind a colon, its value.
    ///
    /// # Errors
    /// The reason, in words that follow the text itself.
    pub(super) fn parse(component: Component, text: &str) -> Result<Self, String> {
        let (name, value) = match text.split_once(':') {
            None => (text, None),
            Some((name, value)) => (name, Some(value)),
        };
        let known = component.words();
        let is_known = known
            .iter()
            .any(|word| word.split(':').next() == Some(name));
        if !is_known {
            let what = if NAMES.contains(&name) {
                "makes no sense"
            } else {
                "is no word"
            };
            return Err(format!("{what} for {component}: {}", known.join(", ")));
        }
        let given = value.unwrap_or_default();
        let word = match name {
            "wrong" if component == Component::Can => {
                let jump = given.strip_suffix("mm").and_then(signed);
                let legal = jump.filter(|mm| *mm != 0 && (-FARTHEST_MM..=FARTHEST_MM).contains(mm));
                Self::Wrong(legal.ok_or(NO_JUMP)?)
            }
            "wrong" => {
                let counts = signed(given);
                let legal = counts.filter(|n| *n != 0 && (-MOST_COUNTS..=MOST_COUNTS).contains(n));
                Self::Wrong(legal.ok_or(NO_COUNTS)?)
            }
            "slow" => {
                let rate_hz = given.strip_suffix("Hz").and_then(positive);
                Self::Slow(rate_hz.filter(|hz| RATES_HZ.contains(hz)).ok_or(NO_RATE)?)
            }
            "delayed" => {
                let by = time(given).filter(|by| !by.is_zero() && *by <= LATEST);
                Self::Delayed(by.ok_or(NO_DELAY)?)
            }
            "intermittent" => Self::Intermittent(probability(given).ok_or(NO_SHARE)?),
            _ if value.is_some() => return Err(NO_VALUE.to_owned()),
            "off" => Self::Off,
            "stuck" => Self::Stuck,
            "garbage" => Self::Garbage,
            "saturated" => Self::Saturated,
            _ => Self::Ok,
        };
        Ok(word)
    }

    /// The word of a component as it is read.
    pub(super) fn in_words(self, component: Component) -> String {
        if component == Component::Link {
            return super::line_words::in_words(self);
        }
        match self {
            Self::Ok => "ok".to_owned(),
            Self::Off => "off".to_owned(),
            Self::Stuck => "stuck".to_owned(),
            Self::Garbage => "garbage".to_owned(),
            Self::Wrong(by) if component == Component::Can => format!("wrong:{by:+}mm"),
            Self::Wrong(by) => format!("wrong:{by:+}"),
            Self::Slow(rate_hz) => format!("slow:{rate_hz}Hz"),
            Self::Delayed(by) => format!("delayed:{}", in_words(by)),
            Self::Intermittent(share) => format!("intermittent:{share}"),
            Self::Saturated => "saturated".to_owned(),
            Self::Lit { ambient, added } => format!("lit:{ambient}+{added}"),
            of_link => super::line_words::in_words(of_link),
        }
    }
}

/// Period of a rate, microseconds.
pub(crate) fn period_us(rate_hz: f64) -> u64 {
    (1e6 / rate_hz).round() as u64
}
