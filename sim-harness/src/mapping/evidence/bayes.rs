//! Bayes' rule for a cell.

use crate::mapping::{Belief, Calculus};

/// Largest magnitude of a cell's log odds.
const LIMIT: f64 = 20.0;

/// Bayes' rule over inverse sensor models (Ivanjko et al. 2003, equation 18).
///
/// The evidence is the probability L that the cell is occupied, given the reading:
///
/// ```text
/// p := L p / (L p + (1 - L) (1 - p)),   p = 0.5 at first
/// l := l + ln(L / (1 - L)),             l = ln(p / (1 - p))
/// ```
///
/// Both are the same rule; the second is used. With a first value of p other than 0.5 they
/// would not be: equation 18 holds for an even prior only. |l| is at most 20. The order of
/// readings does not matter as long as the limit is not reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bayes;

/// ln(p / (1 - p)).
fn log_odds(probability: f64) -> f64 {
    libm::log(probability / (1.0 - probability))
}

impl Calculus for Bayes {
    /// L, in (0, 1).
    type Evidence = f64;

    /// l.
    type Held = f64;

    fn blank(&self) -> f64 {
        0.0
    }

    fn update(&self, held: &mut f64, occupied: f64) {
        *held = (*held + log_odds(occupied)).clamp(-LIMIT, LIMIT);
    }

    fn belief(&self, held: &f64) -> Belief {
        Belief::of_sum(1.0 / (1.0 + libm::exp(-held)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;

    /// Equation 18 as it is printed.
    fn printed(p: f64, likelihood: f64) -> f64 {
        likelihood * p / (likelihood * p + (1.0 - likelihood) * (1.0 - p))
    }

    fn probability(held: f64) -> f64 {
        1.0 / (1.0 + libm::exp(-held))
    }

    #[test]
    fn g1_the_sum_of_log_odds_is_the_printed_rule() {
        let mut held = Bayes.blank();
        let mut p = 0.5;
        for (reading, expected_l, expected_p) in [
            (0.7, 0.847_297_860, 0.7),
            (0.7, 1.694_595_721, 0.844_827_586),
            (0.3, 0.847_297_860, 0.7),
            (0.7, 1.694_595_721, 0.844_827_586),
        ] {
            Bayes.update(&mut held, reading);
            p = printed(p, reading);
            assert!((held - expected_l).abs() < 1e-9, "{held}");
            assert!((p - expected_p).abs() < 1e-9, "{p}");
            assert!((probability(held) - p).abs() < 1e-12);
        }
    }

    #[test]
    fn g1_ten_weak_hits_add_up() {
        let mut held = Bayes.blank();
        Bayes.update(&mut held, 0.55);
        assert!((held - 0.200_670_695).abs() < 1e-9);
        (1..10).for_each(|_| Bayes.update(&mut held, 0.55));
        assert!((probability(held) - 0.881_499_469).abs() < 1e-9);
    }

    #[test]
    fn g1_the_printed_rule_differs_from_the_sum_at_an_uneven_prior() {
        // Log odds take the prior off each reading: 0.7 stays 0.7.
        let prior = 0.2;
        let summed = log_odds(prior) + (log_odds(0.7) - log_odds(prior));
        assert!((probability(summed) - 0.7).abs() < 1e-9);
        assert!((printed(prior, 0.7) - 0.368_421_053).abs() < 1e-9);
    }

    #[test]
    fn equal_evidence_for_and_against_is_unknown_despite_rounding() {
        let mut held = Bayes.blank();
        for reading in [0.7, 0.55, 0.3, 0.45, 0.61, 0.39] {
            Bayes.update(&mut held, reading);
        }
        assert_eq!(Bayes.belief(&held).occupancy(), Occupancy::Unknown);
    }

    #[test]
    fn log_odds_stay_within_their_limit() {
        let mut held = Bayes.blank();
        (0..10).for_each(|_| Bayes.update(&mut held, 1.0 - 1e-4));
        assert!((held - LIMIT).abs() < 1e-12);
        assert!(Bayes.belief(&held).p_occ() <= 1.0);
    }
}
