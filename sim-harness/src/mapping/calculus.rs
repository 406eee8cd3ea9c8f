//! How the evidence about a cell is held.

use super::Belief;

/// The evidence of one measurement for one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Whether it is evidence for occupied; otherwise for free.
    pub is_occupied: bool,
    /// Its weight, above 0.
    pub weight: f64,
}

/// A way to hold and combine evidence.
pub trait Calculus {
    /// What one measurement says about one cell.
    type Evidence;

    /// The evidence for one cell.
    type Held: Clone;

    /// The state of a cell without evidence.
    fn blank(&self) -> Self::Held;

    /// Adds evidence to a cell.
    fn update(&self, held: &mut Self::Held, evidence: Self::Evidence);

    /// The belief from the evidence of a cell.
    fn belief(&self, held: &Self::Held) -> Belief;
}

/// Counts of occupied and free (paper equations 3 and 4).
///
/// Each piece of evidence is one count, with any weight. At 65 535 both counts halve,
/// which keeps their ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts;

impl Calculus for Counts {
    type Evidence = Evidence;

    /// Occupied and free.
    type Held = [u16; 2];

    fn blank(&self) -> [u16; 2] {
        [0, 0]
    }

    fn update(&self, held: &mut [u16; 2], evidence: Evidence) {
        if held.contains(&u16::MAX) {
            *held = held.map(|count| count / 2);
        }
        let [occupied, free] = held;
        *(if evidence.is_occupied { occupied } else { free }) += 1;
    }

    /// f_occ = c_occ / (c_occ + c_free), eq. 4; 0.5 for equal counts, whatever rounding
    /// would give.
    fn belief(&self, [occupied, free]: &[u16; 2]) -> Belief {
        if occupied == free {
            return Belief::UNKNOWN;
        }
        let (occupied, free) = (f32::from(*occupied), f32::from(*free));
        Belief::of_probability(occupied / (occupied + free))
    }
}

/// Sum of log odds, l = ln(p / (1 - p)) (Thrun, Burgard and Fox 2005, table 4.2).
///
/// The weight of the evidence is its log odds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogOdds {
    /// Largest magnitude of the sum; infinity for no limit.
    pub limit: f64,
}

impl Calculus for LogOdds {
    type Evidence = Evidence;

    type Held = f64;

    fn blank(&self) -> f64 {
        0.0
    }

    fn update(&self, held: &mut f64, evidence: Evidence) {
        let sign = if evidence.is_occupied { 1.0 } else { -1.0 };
        *held = (*held + sign * evidence.weight).clamp(-self.limit, self.limit);
    }

    /// p = 1 - 1 / (1 + e^l).
    fn belief(&self, held: &f64) -> Belief {
        if *held == 0.0 {
            return Belief::UNKNOWN;
        }
        Belief::of_probability(probability(*held as f32))
    }
}

/// p = 1 - 1 / (1 + e^l), without cancellation for either sign.
fn probability(log_odds: f32) -> f32 {
    let odds_against = amiro_ipf::math::exp_of_minus(log_odds.abs());
    if log_odds < 0.0 {
        odds_against / (1.0 + odds_against)
    } else {
        1.0 / (1.0 + odds_against)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;
    use amiro_ipf::math;

    const OCCUPIED: Evidence = Evidence {
        is_occupied: true,
        weight: 1.0,
    };

    #[test]
    fn probability_is_the_share_of_occupied_counts() {
        for (occupied, free, p) in [
            (0, 0, 0.5),
            (3, 1, 0.75),
            (0, 9, 0.0),
            (1, 0, 1.0),
            (7, 7, 0.5),
        ] {
            let p_occ = Counts.belief(&[occupied, free]).p_occ();
            assert!((p_occ - p).abs() < 1e-7, "{occupied} / {free}");
        }
        let equal = Counts.belief(&[7, 7]);
        assert_eq!(equal.occupancy(), Occupancy::Unknown);
    }

    #[test]
    fn f53_halving_at_the_cap_keeps_the_ratio() {
        let mut held = [u16::MAX, 20_000];
        let before = Counts.belief(&held).p_occ();
        Counts.update(&mut held, OCCUPIED);
        assert!((Counts.belief(&held).p_occ() - before).abs() < 1e-4);
        assert_eq!(held, [32_768, 10_000]);
    }

    #[test]
    fn log_odds_stay_within_their_limit() {
        let calculus = LogOdds { limit: 2.5 };
        let mut held = calculus.blank();
        (0..5).for_each(|_| calculus.update(&mut held, OCCUPIED));
        assert!((held - 2.5).abs() < 1e-12);
    }

    #[test]
    fn probability_inverts_the_log_odds() {
        for tenths in -100_i16..=100 {
            let log_odds = f32::from(tenths) / 10.0;
            let p = probability(log_odds);
            if log_odds.abs() < 8.0 {
                let back = math::ln(p) - math::ln(1.0 - p);
                // 1 - p keeps seven digits less those of e^-8.
                assert!((back - log_odds).abs() < 1e-3, "{log_odds}: {back}");
            }
            assert_eq!(p > 0.5, log_odds > 0.0);
        }
    }
}
