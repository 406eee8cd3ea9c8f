//! Geometrically distributed distances between rare events.

use amiro_ipf::random::Generator;

/// 2^-32: the spacing of the uniform numbers drawn here.
const STEP: f64 = 1.0 / 4_294_967_296.0;

/// A uniform number in (0, 1], a multiple of 2^-32.
pub(super) fn uniform(random: &mut Generator) -> f64 {
    (f64::from(random.bits()) + 1.0) * STEP
}

/// Independent trials of one probability, drawn as the gaps between their successes.
///
/// A gap is distributed geometrically, so that the cost is one draw per success and not one
/// per trial.
#[derive(Clone, Debug)]
pub(super) struct Geometric {
    rate: f64,
    trials_before: u64,
}

impl Geometric {
    pub(super) fn new(rate: f64, random: &mut Generator) -> Self {
        let mut geometric = Self {
            rate,
            trials_before: 0,
        };
        geometric.draw(random);
        geometric
    }

    /// The trial of the next success among the next `trials`; all up to it, or all of them,
    /// are consumed.
    pub(super) fn next_within(&mut self, trials: u64, random: &mut Generator) -> Option<u64> {
        if self.trials_before >= trials {
            self.trials_before -= trials;
            return None;
        }
        let hit = self.trials_before;
        self.draw(random);
        Some(hit)
    }

    fn draw(&mut self, random: &mut Generator) {
        // A rate of 1 gives a quotient of 0, a rate of 0 one of infinity.
        let gap = uniform(random).ln() / (-self.rate).ln_1p();
        self.trials_before = if self.rate > 0.0 {
            gap as u64
        } else {
            u64::MAX
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn successes_match_the_rate() {
        for (seed, rate) in [(1, 1e-3), (2, 1e-2), (3, 0.3)] {
            let mut random = Generator::seeded(seed);
            let mut geometric = Geometric::new(rate, &mut random);
            let trials = 1_000_000;
            let hits = (0..trials)
                .filter(|_| geometric.next_within(1, &mut random).is_some())
                .count() as f64;
            // Four standard deviations of a binomial count.
            let expected = rate * f64::from(trials);
            let error = (hits - expected).abs();
            let bound = 4.0 * (expected * (1.0 - rate)).sqrt();
            assert!(error < bound, "seed {seed}: {hits} of {expected}");
        }
    }

    #[test]
    fn never_and_always_are_exact() {
        let mut random = Generator::seeded(1);
        let mut never = Geometric::new(0.0, &mut random);
        let mut always = Geometric::new(1.0, &mut random);
        for _ in 0..1000 {
            assert_eq!(never.next_within(1000, &mut random), None);
            assert_eq!(always.next_within(1, &mut random), Some(0));
        }
    }
}
