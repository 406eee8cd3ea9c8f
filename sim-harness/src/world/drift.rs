//! Drift of the sensors' offsets from the stored ones.

use std::str::FromStr;

use super::OptionsError;

/// Counts added to every reading, changing linearly from one value to another over the
/// drive. Written `10` for a constant drift, `0..10` for a growing one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// At the start of the drive, counts.
    pub from_counts: f64,
    /// At its end, counts.
    pub to_counts: f64,
}

impl Drift {
    /// No drift.
    pub const NONE: Self = Self::constant(0.0);

    /// The same offset over the whole drive.
    #[must_use]
    pub const fn constant(counts: f64) -> Self {
        Self {
            from_counts: counts,
            to_counts: counts,
        }
    }

    /// The drift at a stamp of a drive of the given length, counts.
    #[must_use]
    pub fn at(&self, stamp_us: u64, end_us: u64) -> f64 {
        // A drive without legs has one sample, at its start.
        let share = stamp_us as f64 / end_us.max(1) as f64;
        self.from_counts + (self.to_counts - self.from_counts) * share
    }
}

impl std::fmt::Display for Drift {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if *self == Self::constant(self.from_counts) {
            return write!(f, "{}", self.from_counts);
        }
        write!(f, "{}..{}", self.from_counts, self.to_counts)
    }
}

impl FromStr for Drift {
    type Err = OptionsError;

    fn from_str(text: &str) -> Result<Self, OptionsError> {
        let (from, to) = text.split_once("..").unwrap_or((text, text));
        match (from.parse(), to.parse()) {
            (Ok(from_counts), Ok(to_counts)) => Ok(Self {
                from_counts,
                to_counts,
            }),
            _ => Err(OptionsError::value("drift", text, "counts, as 10 or 0..10")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_runs_evenly_from_start_to_end() {
        let drift: Drift = "-4..16".parse().unwrap();
        let is = |drift: Drift, stamp_us, counts: f64| {
            let found = drift.at(stamp_us, 2_000_000);
            assert_eq!(found.to_bits(), counts.to_bits(), "{drift}: {found}");
        };
        is(drift, 0, -4.0);
        is(drift, 500_000, 1.0);
        is(drift, 2_000_000, 16.0);
        is(Drift::constant(0.1), 0, 0.1);
        is(Drift::constant(0.1), 700_000, 0.1);
        assert_eq!(Drift::constant(-10.0), "-10".parse().unwrap());
        let without_legs = drift.at(0, 0);
        assert_eq!(without_legs.to_bits(), (-4.0_f64).to_bits());
    }
}
