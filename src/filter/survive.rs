//! Survival: who stays in the set, by the weights (lines 6 and 9 of Algorithm 1).

use rand_core::Rng;

use super::SurvivalRule;

/// Decides particle after particle, in slot order; made anew for every step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Survival {
    /// Systematic resampling in integers: tooth k of the comb stands at
    /// (first + k total) / teeth. Everything is scaled by the number of teeth, so no
    /// division occurs.
    Systematic {
        /// The weights passed so far, times the number of teeth.
        passed: u64,
        /// The next tooth, on the same scale.
        tooth: u64,
        total: u64,
        teeth: u64,
    },
    Bernoulli,
}

impl Survival {
    /// Prepares a step in which `live` particles weigh `total` together.
    ///
    /// Systematic resampling draws its one random number here: the first tooth is
    /// uniform in [0, total), so the comb's phase is uniform in one spacing. When
    /// all weights are zero, nobody survives under either rule.
    pub(crate) fn new(rule: SurvivalRule, total: u32, live: u32, rng: &mut impl Rng) -> Self {
        match rule {
            SurvivalRule::Bernoulli => Self::Bernoulli,
            SurvivalRule::Systematic => Self::Systematic {
                passed: 0,
                tooth: (u64::from(rng.next_u32()) * u64::from(total)) >> 32,
                total: u64::from(total),
                teeth: u64::from(live),
            },
        }
    }

    /// Whether the next live particle, of this weight, survives.
    ///
    /// A particle under several teeth survives once: there are no clones, the slots
    /// that lose are redrawn from the readings instead. Over a whole step at most as
    /// many teeth are passed as particles live.
    #[inline]
    pub(crate) fn survives(&mut self, weight: u16, rng: &mut impl Rng) -> bool {
        match self {
            Self::Bernoulli => {
                // 65535 is certain; a weight of 0 needs no random number.
                weight > 0 && rng.next_u32() >> 16 <= u32::from(weight)
            }
            Self::Systematic {
                passed,
                tooth,
                total,
                teeth,
            } => {
                *passed += u64::from(weight) * *teeth;
                let hit = *tooth < *passed;
                while *tooth < *passed {
                    *tooth += *total;
                }
                hit
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Generator;

    fn survivors(rule: SurvivalRule, weights: &[u16], seed: u64) -> Vec<bool> {
        let mut rng = Generator::seeded(seed);
        let total = weights.iter().map(|&weight| u32::from(weight)).sum();
        let mut survival = Survival::new(rule, total, weights.len() as u32, &mut rng);
        weights
            .iter()
            .map(|&weight| survival.survives(weight, &mut rng))
            .collect()
    }

    #[test]
    fn comb_takes_all_of_an_equal_set() {
        for seed in 0..20 {
            for weight in [1, 1000, 65_535] {
                let survived = survivors(SurvivalRule::Systematic, &[weight; 500], seed);
                assert!(survived.iter().all(|&s| s), "seed {seed}, weight {weight}");
            }
        }
    }

    #[test]
    fn comb_hits_every_weight_above_the_mean_and_nothing_of_weight_zero() {
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
    fn comb_hits_a_small_weight_in_proportion() {
        // Mean weight 10 000: a weight of 2500 is hit by a quarter of the combs.
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
        // Whatever is drawn: one of 40 000 particles lost would be no outlier.
        for number in [
            0,
            0xffff,
            0x10000,
            0x7fff_ffff,
            u32::MAX - 0x10000,
            u32::MAX,
        ] {
            let mut rng = Constant(number);
            let mut survival = Survival::new(SurvivalRule::Bernoulli, 0, 0, &mut rng);
            assert!(survival.survives(65_535, &mut rng), "{number:#x}");
            assert!(!survival.survives(0, &mut rng), "{number:#x}");
        }
    }

    #[test]
    fn comb_with_its_first_tooth_at_zero_hits_no_weight_of_zero() {
        // Teeth at 0, 2, 4 and 6 of 8.
        let mut rng = Constant(0);
        let mut survival = Survival::new(SurvivalRule::Systematic, 8, 4, &mut rng);
        let survived = [0, 2, 6, 0].map(|weight| survival.survives(weight, &mut rng));
        assert_eq!(survived, [false, true, true, false]);
    }

    #[test]
    fn f52_all_weights_zero_means_nobody_survives() {
        for rule in [SurvivalRule::Systematic, SurvivalRule::Bernoulli] {
            assert!(survivors(rule, &[0; 100], 3).iter().all(|&s| !s));
            assert!(survivors(rule, &[], 3).is_empty());
        }
    }
}
