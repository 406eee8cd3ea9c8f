//! Resampling: which particles stay in the set (lines 5 to 10 of Algorithm 1).

use rand_core::Rng;

use super::particles::Slot;
use super::{FilterParameters, Outcome, SurvivalRule, Tally};

/// Decides which particles survive, one after the other in slot order.
///
/// A new resampler is made for every step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resampler<'a> {
    parameters: &'a FilterParameters,
    rule: Rule,
}

#[derive(Clone, Copy, Debug)]
enum Rule {
    /// Systematic resampling in integers: pointer k stands at
    /// (first + k total) / count. All numbers are scaled by the number of pointers,
    /// so no division occurs.
    Systematic {
        /// The cumulative weight so far, times the number of pointers.
        cumulative: u64,
        /// The next pointer, on the same scale.
        pointer: u64,
        /// The sum of all weights: the spacing of the pointers on this scale.
        total: u64,
        /// The number of pointers: one per live particle.
        count: u64,
    },
    Bernoulli,
}

impl<'a> Resampler<'a> {
    /// Prepares a step whose weighed particles are in `tally`.
    ///
    /// Systematic resampling draws its one random number here: the first pointer is
    /// uniform in one spacing. When all weights are zero, no particle survives under
    /// either rule.
    pub(super) fn new(parameters: &'a FilterParameters, tally: &Tally, rng: &mut impl Rng) -> Self {
        let total = u64::from(tally.weight_sum);
        let rule = match parameters.survival {
            SurvivalRule::Bernoulli
            | SurvivalRule::BernoulliOnWalls
            | SurvivalRule::BernoulliOnArcs => Rule::Bernoulli,
            SurvivalRule::Systematic => Rule::Systematic {
                cumulative: 0,
                pointer: (u64::from(rng.next_u32()) * total) >> 32,
                total,
                count: u64::from(tally.live),
            },
        };
        Self { parameters, rule }
    }

    /// Advances the epoch of a particle that survives and removes one that does not. A
    /// survival is worth so many steps of the gate.
    ///
    /// The particle's position and what the sensors saw of it stay readable.
    #[inline]
    pub(super) fn resample(
        &mut self,
        particle: &mut Slot<'_>,
        steps: u8,
        rng: &mut impl Rng,
    ) -> Outcome {
        if self.selects(particle.weight(), rng) {
            Outcome::of_survivor(self.parameters, particle.advance_epoch(steps))
        } else {
            particle.clear();
            Outcome::of_rejected(self.parameters, particle.flags())
        }
    }

    /// Whether the next live particle, of this weight, survives.
    ///
    /// A particle under several pointers survives once: there are no clones, because
    /// the slots of rejected particles are redrawn from the readings. The loop runs at
    /// most once per live particle in a whole step.
    #[inline]
    fn selects(&mut self, weight: u16, rng: &mut impl Rng) -> bool {
        match &mut self.rule {
            Rule::Bernoulli => {
                // 65535 is certain; a weight of 0 needs no random number.
                weight > 0 && rng.next_u32() >> 16 <= u32::from(weight)
            }
            Rule::Systematic {
                cumulative,
                pointer,
                total,
                count,
            } => {
                *cumulative += u64::from(weight) * *count;
                let is_selected = *pointer < *cumulative;
                while *pointer < *cumulative {
                    *pointer += *total;
                }
                is_selected
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Generator;

    fn parameters(survival: SurvivalRule) -> FilterParameters {
        FilterParameters {
            survival,
            ..FilterParameters::PAPER
        }
    }

    fn tally(weights: &[u16]) -> Tally {
        let mut tally = Tally::default();
        weights.iter().for_each(|&weight| tally.add_weight(weight));
        tally
    }

    fn selected(rule: SurvivalRule, weights: &[u16], rng: &mut impl Rng) -> Vec<bool> {
        let parameters = parameters(rule);
        let mut resampler = Resampler::new(&parameters, &tally(weights), rng);
        weights
            .iter()
            .map(|&weight| resampler.selects(weight, rng))
            .collect()
    }

    fn survivors(rule: SurvivalRule, weights: &[u16], seed: u64) -> Vec<bool> {
        selected(rule, weights, &mut Generator::seeded(seed))
    }

    #[test]
    fn systematic_resampling_selects_all_of_an_equal_set() {
        for seed in 0..20 {
            for weight in [1, 1000, 65_535] {
                let survived = survivors(SurvivalRule::Systematic, &[weight; 500], seed);
                assert!(survived.iter().all(|&s| s), "seed {seed}, weight {weight}");
            }
        }
    }

    #[test]
    fn systematic_resampling_selects_every_weight_above_the_mean_and_none_of_zero() {
        let weights: Vec<u16> = (0..1000).map(|i| [0, 100, 5000, 20_000][i % 4]).collect();
        let mean = weights.iter().map(|&w| u64::from(w)).sum::<u64>() / 1000;
        for seed in 0..20 {
            let survived = survivors(SurvivalRule::Systematic, &weights, seed);
            for (weight, survived) in weights.iter().zip(&survived) {
                assert!(
                    u64::from(*weight) < mean || *survived,
                    "seed {seed}: {weight} lost"
                );
                assert!(*weight > 0 || !survived, "seed {seed}: zero survived");
            }
        }
    }

    #[test]
    fn systematic_resampling_selects_a_small_weight_in_proportion() {
        // Mean weight 10 000: a weight of 2500 is selected for a quarter of the seeds.
        let mut weights = [10_833_u16; 10];
        weights[4] = 2500;
        let hits = (0..4000)
            .filter(|&seed| survivors(SurvivalRule::Systematic, &weights, seed)[4])
            .count();
        // sigma = sqrt(4000 * 0.25 * 0.75) = 27; 4 sigma.
        assert!((hits as i32 - 1000).abs() < 110, "{hits}");
    }

    #[test]
    fn bernoulli_survives_with_its_weight() {
        for (weight, probability) in [(65_535_u16, 1.0), (32_768, 0.5), (6553, 0.1), (0, 0.0)] {
            let survived = survivors(SurvivalRule::Bernoulli, &vec![weight; 40_000], 5);
            let share = survived.iter().filter(|&&s| s).count() as f64 / 40_000.0;
            // sigma at most 0.0025; 4 sigma.
            assert!((share - probability).abs() < 0.01, "{weight}: {share}");
        }
    }

    /// A generator that has one number.
    struct Constant(u32);

    impl rand_core::TryRng for Constant {
        type Error = core::convert::Infallible;

        fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
            Ok(self.0)
        }

        fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
            Ok(u64::from(self.0) << 32 | u64::from(self.0))
        }

        fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error> {
            bytes.fill(self.0 as u8);
            Ok(())
        }
    }

    #[test]
    fn bernoulli_is_certain_at_both_ends() {
        // For every random number: a statistical test would miss one lost particle of 40 000.
        for number in [
            0,
            0xffff,
            0x10000,
            0x7fff_ffff,
            u32::MAX - 0x10000,
            u32::MAX,
        ] {
            let mut rng = Constant(number);
            let survived = selected(SurvivalRule::Bernoulli, &[65_535, 0], &mut rng);
            assert_eq!(survived, [true, false], "{number:#x}");
        }
    }

    #[test]
    fn a_first_pointer_at_zero_selects_no_weight_of_zero() {
        // Pointers at 0, 2, 4 and 6 of 8.
        let survived = selected(SurvivalRule::Systematic, &[0, 2, 6, 0], &mut Constant(0));
        assert_eq!(survived, [false, true, true, false]);
    }

    #[test]
    fn f52_with_all_weights_zero_no_particle_survives() {
        for rule in [SurvivalRule::Systematic, SurvivalRule::Bernoulli] {
            assert!(survivors(rule, &[0; 100], 3).iter().all(|&s| !s));
            assert!(survivors(rule, &[], 3).is_empty());
        }
    }
}
