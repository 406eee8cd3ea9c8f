//! Percentiles of any number of values in bounded memory.

use std::collections::BTreeMap;

/// Values up to which percentiles are exact: 4 MiB of them.
const EXACT: usize = 1 << 19;
/// Bits of a number below its sign, its exponent and 12 bits of its fraction.
const BELOW_CLASS: u32 = 40;

/// Positive numbers, of which a percentile is wanted.
///
/// Exact up to half a million numbers; beyond that a number stands for the upper end of its
/// class, which is at most 1/4096 above it. A power of two is the upper end of a class, so
/// that whether a percentile exceeds it stays exact.
#[derive(Clone, Debug, Default)]
pub(super) struct Percentile {
    exact: Vec<f64>,
    /// Numbers by their class, once there are too many.
    classes: BTreeMap<u64, u64>,
    count: u64,
}

impl Percentile {
    /// Takes a finite number above 0.
    pub(super) fn take(&mut self, value: f64) {
        self.count += 1;
        if self.classes.is_empty() && self.exact.len() < EXACT {
            self.exact.push(value);
            return;
        }
        for value in self.exact.drain(..) {
            *self.classes.entry(class_of(value)).or_default() += 1;
        }
        *self.classes.entry(class_of(value)).or_default() += 1;
    }

    /// The given percentile; `None` without numbers.
    pub(super) fn of(&self, percent: u64) -> Option<f64> {
        let place = self.count * percent / 100;
        if self.classes.is_empty() {
            let mut sorted = self.exact.clone();
            sorted.sort_by(f64::total_cmp);
            return sorted.get(usize::try_from(place).ok()?).copied();
        }
        let mut below = 0;
        let class = self.classes.iter().find(|(_, count)| {
            below += **count;
            below > place
        });
        class.map(|(class, _)| f64::from_bits((class + 1) << BELOW_CLASS))
    }
}

/// Classes hold their upper ends and not their lower ones.
fn class_of(value: f64) -> u64 {
    (value.to_bits() - 1) >> BELOW_CLASS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_numbers_have_the_percentile_of_few_to_a_part_in_4096() {
        let values = |many: u32| (1..=many).map(move |n| 3.0 * f64::from(n) / f64::from(many));
        let mut few = Percentile::default();
        values(1000).for_each(|value| few.take(value));
        let mut many = Percentile::default();
        values(EXACT as u32 + 1000).for_each(|value| many.take(value));
        assert!(many.exact.is_empty() && many.classes.len() < 1 << 17);
        for percent in [0, 50, 90, 99] {
            let (few, many) = (few.of(percent).unwrap(), many.of(percent).unwrap());
            assert!(
                (many - few).abs() < 3e-3 + few / 4096.0,
                "{percent}: {few} {many}"
            );
        }
        assert_eq!(Percentile::default().of(50), None);
    }

    #[test]
    fn a_power_of_two_does_not_exceed_itself_in_its_class() {
        for value in [2.0, f64::from_bits(2.0_f64.to_bits() + 1)] {
            let mut same = Percentile::default();
            (0..=EXACT).for_each(|_| same.take(value));
            assert_eq!(same.of(50).unwrap() > 2.0, value > 2.0, "{value:e}");
        }
    }
}
