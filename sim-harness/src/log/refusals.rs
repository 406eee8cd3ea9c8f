//! The refused parts of a source, with place and reason.

use std::fmt;

use amiro_ipf::link::FrameError;

/// Refusals that are kept with their place; the rest is counted by reason.
const KEPT: usize = 5;

/// A place in a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(u64),
    /// The first byte of a frame, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// The reason of a refusal, by which refusals are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reason {
    /// An empty line.
    EmptyLine,
    /// A line of more than 64 KiB.
    LongLine,
    /// A line that holds a zero byte.
    ZeroByte,
    /// A line that is not UTF-8.
    NotUtf8,
    /// A last line without its end, or a last frame without its own.
    Cut,
    /// A row of more or fewer than eleven fields.
    FieldCount,
    /// A field that is not a plain decimal integer.
    NotAnInteger,
    /// A number beyond what a robot can deliver.
    OutOfRange,
    /// A repetition of the last entry.
    Repeated,
    /// Bytes that are no frame.
    Broken(FrameError),
    /// Missing frames of a sender.
    Lost,
    /// A sender that numbers its frames from an earlier number again.
    StartedOver,
    /// A stamp before an earlier one of the same kind.
    Backward,
    /// A coordinate or speed that is NaN or infinite.
    NotFinite,
    /// A configuration with a parameter outside its range.
    BadConfiguration,
    /// Inputs, or a simulator's truth, of a run before the first configuration.
    BeforeConfiguration,
    /// Another run: a second configuration, header or simulator's truth, and everything
    /// after it.
    SecondRun,
    /// A scenario that is too long or not UTF-8.
    BadScenario,
    /// The texts of faults are too long together, or one is not text.
    BadFaults,
    /// Everything beyond the size limit of a recording.
    Full,
}

impl Reason {
    /// Whether nothing behind the place is read: there is one such refusal at most.
    fn ends_reading(self) -> bool {
        matches!(self, Self::SecondRun | Self::Full)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EmptyLine => "empty line",
            Self::LongLine => "line too long",
            Self::ZeroByte => "zero byte",
            Self::NotUtf8 => "not UTF-8",
            Self::Cut => "cut",
            Self::FieldCount => "field count",
            Self::NotAnInteger => "not an integer",
            Self::OutOfRange => "out of range",
            Self::Repeated => "repeated",
            Self::Broken(error) => return error.fmt(f),
            Self::Lost => "frames lost",
            Self::StartedOver => "sender started over",
            Self::Backward => "stamp goes backward",
            Self::NotFinite => "not finite",
            Self::BadConfiguration => "bad configuration",
            Self::BeforeConfiguration => "before the configuration",
            Self::SecondRun => "second run",
            Self::BadScenario => "bad scenario",
            Self::BadFaults => "bad text of faults",
            Self::Full => "too much",
        })
    }
}

/// One refusal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Where it is.
    pub place: Place,
    /// Why it was refused.
    pub reason: Reason,
    /// The same with the particulars; text from the source is escaped.
    pub text: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.text)
    }
}

/// All refusals of a source.
///
/// Keeps the first five with their places and counts the rest by reason, so that a
/// source of nothing but garbage costs no memory. The one that ends the reading is kept
/// with its place too, however many there were before it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Refusals {
    first: Vec<Refusal>,
    rest: Vec<(Reason, u64)>,
}

impl Refusals {
    /// Whether everything was used.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// Number of refusals.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.first.len() as u64 + self.beyond_first()
    }

    /// Number of refusals for one reason.
    #[must_use]
    pub fn count_of(&self, reason: Reason) -> u64 {
        let first = self.first.iter().filter(|first| first.reason == reason);
        let rest = self.rest.iter().filter(|(rest, _)| *rest == reason);
        first.count() as u64 + rest.map(|(_, count)| count).sum::<u64>()
    }

    /// The first five, and behind them the one that ended the reading, if one did.
    #[must_use]
    pub fn first(&self) -> &[Refusal] {
        &self.first
    }

    fn beyond_first(&self) -> u64 {
        self.rest.iter().map(|(_, count)| count).sum()
    }

    pub(super) fn add(&mut self, place: Place, reason: Reason, text: impl fmt::Display) {
        if self.first.len() < KEPT || reason.ends_reading() {
            let text = text.to_string();
            self.first.push(Refusal {
                place,
                reason,
                text,
            });
            return;
        }
        match self.rest.iter_mut().find(|(rest, _)| *rest == reason) {
            Some((_, count)) => *count += 1,
            None => self.rest.push((reason, 1)),
        }
    }
}

/// A line for each that is kept with its place and one that sums up the rest.
impl fmt::Display for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, refusal) in self.first.iter().enumerate() {
            let end = if index == 0 { "" } else { "\n" };
            write!(f, "{end}{refusal}")?;
        }
        if self.rest.is_empty() {
            return Ok(());
        }
        write!(f, "\nand {} more (", self.beyond_first())?;
        for (index, (reason, count)) in self.rest.iter().enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            write!(f, "{comma}{reason} x {count}")?;
        }
        f.write_str(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_are_shown_and_the_rest_is_summed_by_reason() {
        let mut refusals = Refusals::default();
        assert_eq!(refusals.to_string(), "");
        for line in 1..=12 {
            let reason = if line % 3 == 0 {
                Reason::OutOfRange
            } else {
                Reason::Repeated
            };
            refusals.add(Place::Line(line), reason, format_args!("number {line}"));
        }
        assert_eq!(
            refusals.to_string(),
            "line 1: number 1\nline 2: number 2\nline 3: number 3\nline 4: number 4\n\
             line 5: number 5\nand 7 more (out of range x 3, repeated x 4)"
        );
        assert_eq!(refusals.count(), 12);
        assert_eq!(refusals.count_of(Reason::OutOfRange), 4);
        assert_eq!(refusals.count_of(Reason::Cut), 0);
    }

    #[test]
    fn the_refusal_that_ends_the_reading_is_shown_behind_any_number_of_others() {
        let mut refusals = Refusals::default();
        for line in 1..=9 {
            refusals.add(Place::Line(line), Reason::Repeated, "repeats");
        }
        refusals.add(Place::Line(10), Reason::SecondRun, "another run");
        let shown = refusals.to_string();
        assert!(
            shown.ends_with("\nline 10: another run\nand 4 more (repeated x 4)"),
            "{shown}"
        );
        assert_eq!(refusals.count_of(Reason::SecondRun), 1);
        assert_eq!(refusals.count(), 10);
    }
}
