//! A periodic clock inside a part.

/// When a periodic measurement ends next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cadence {
    next_ns: u64,
    period_ns: u64,
}

impl Cadence {
    /// Ends first at `first_ns` and then every `nominal_ns`, longer by `error_ppm`
    /// millionths.
    pub(super) fn new(first_ns: u64, nominal_ns: u64, error_ppm: i32) -> Self {
        let millionths = 1_000_000_i64.saturating_add(i64::from(error_ppm)).max(1);
        Self {
            next_ns: first_ns,
            period_ns: (nominal_ns * millionths.unsigned_abs() / 1_000_000).max(1),
        }
    }

    /// When the measurement under way ends.
    pub(super) const fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Whether a measurement has ended by now; each is reported once.
    pub(super) fn has_ended(&mut self, now_ns: u64) -> bool {
        let ended = self.next_ns <= now_ns;
        if ended {
            self.next_ns += self.period_ns;
        }
        ended
    }

    /// Sets when the measurement under way ends; the others follow by their periods.
    pub(super) fn end_at(&mut self, at_ns: u64) {
        self.next_ns = at_ns;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_clock_counts_fewer_periods() {
        // 5 % slow: 1 s holds 119 whole periods of 8.4 ms, the first at 0.
        for (error_ppm, expected) in [(0, 126), (50_000, 120), (-50_000, 132)] {
            let mut cadence = Cadence::new(0, 8_000_000, error_ppm);
            let mut ended = 0;
            while cadence.has_ended(1_000_000_000) {
                ended += 1;
            }
            assert_eq!(ended, expected, "{error_ppm} ppm");
        }
    }
}
