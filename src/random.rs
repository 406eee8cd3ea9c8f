//! Random numbers: one seeded generator, uniform and normal samples from it.
//!
//! Nothing else in the crate is random. The generator is `xoshiro128++`, 16 bytes of
//! state and 32-bit operations only, which suits a core without 64-bit arithmetic.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

use crate::math;

/// The filter's source of randomness.
#[derive(Clone, Debug, PartialEq)]
pub struct Generator(Xoshiro128PlusPlus);

impl Generator {
    /// The generator with the given seed; equal seeds give equal sequences everywhere.
    ///
    /// Every seed is good, 0 included: it is spread over the state by SplitMix64,
    /// which never gives the all-zero state.
    #[must_use]
    pub fn seeded(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    /// 32 uniform bits.
    #[inline]
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }
}

impl rand_core::TryRng for Generator {
    type Error = core::convert::Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
        Ok(self.0.next_u32())
    }

    fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
        Ok(self.0.next_u64())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.fill_bytes(bytes);
        Ok(())
    }
}

/// 2^-24: the spacing of uniform samples.
const UNIFORM_STEP: f32 = 1.0 / 16_777_216.0;

/// A uniform sample in [0, 1), a multiple of 2^-24.
#[inline]
pub fn uniform(rng: &mut impl Rng) -> f32 {
    (rng.next_u32() >> 8) as f32 * UNIFORM_STEP
}

/// A uniform integer in [0, bound); 0 for a bound of 0.
///
/// By multiplication (Lemire 2019, without the rejection step): with the bounds in
/// use here, at most 16, no value is preferred by more than 4e-9.
#[inline]
pub fn uniform_below(rng: &mut impl Rng, bound: u32) -> u32 {
    ((u64::from(rng.next_u32()) * u64::from(bound)) >> 32) as u32
}

/// Two independent samples of the standard normal distribution (Box and Muller 1958).
///
/// Constant time, about 100 instructions; the largest value is sqrt(-2 ln 2^-24) =
/// 5.77 standard deviations. A pair is what the two wheels need.
#[inline]
pub fn standard_normal_pair(rng: &mut impl Rng) -> (f32, f32) {
    // (0, 1]: the logarithm of 0 never occurs.
    let u = ((rng.next_u32() >> 8) + 1) as f32 * UNIFORM_STEP;
    let radius = math::sqrt(-2.0 * math::ln(u));
    let (sine, cosine) = math::sin_cos_of_random(rng.next_u32());
    (radius * cosine, radius * sine)
}

/// Two independent samples of mean 0 and variance 1, each the sum of four uniform bytes.
///
/// Close to the standard normal distribution (excess kurtosis -0.3), a multiple of 0.007
/// and within 3.46. Less than half of the instructions of [`standard_normal_pair`].
#[inline]
pub fn nearly_normal_pair(rng: &mut impl Rng) -> (f32, f32) {
    (nearly_normal(rng), nearly_normal(rng))
}

/// One sample of [`nearly_normal_pair`].
#[inline]
pub fn nearly_normal(rng: &mut impl Rng) -> f32 {
    /// 1 / the standard deviation of the sum: sqrt(4 (256^2 - 1) / 12) = 147.8.
    const SCALE: f32 = 1.0 / 147.800_54;
    let bits = rng.next_u32();
    // Two sums of two bytes in the halves, then the sum of these.
    let halves = (bits & 0x00ff_00ff) + (bits >> 8 & 0x00ff_00ff);
    let sum = (halves >> 16) + (halves & 0xffff);
    (sum as f32 - 510.0) * SCALE
}

/// A uniform integer in [0, bound) and an independent uniform sample in [0, 1) from one
/// random number; (0, 0) for a bound of 0.
///
/// The two halves of the product of [`uniform_below`]. The sample is a multiple of 2^-24; all
/// of its bits are random for bounds of at most 256.
#[inline]
pub fn uniform_below_and_within(rng: &mut impl Rng, bound: u32) -> (u32, f32) {
    let product = u64::from(rng.next_u32()) * u64::from(bound);
    let (index, rest) = ((product >> 32) as u32, product as u32);
    (index, (rest >> 8) as f32 * UNIFORM_STEP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_seeds_give_equal_sequences_and_others_do_not() {
        let draw = |seed| {
            let mut generator = Generator::seeded(seed);
            core::array::from_fn::<u32, 8, _>(|_| generator.bits())
        };
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
        assert_ne!(draw(0), [0; 8]);
    }

    #[test]
    fn first_draws_of_seed_one_are_pinned() {
        // A changed generator changes every recording: a decision, not an accident.
        let mut generator = Generator::seeded(1);
        let draws: [u32; 4] = core::array::from_fn(|_| generator.bits());
        assert_eq!(
            draws,
            [2_146_930_148, 2_585_199_205, 3_670_091_704, 2_556_029_204]
        );
    }

    #[test]
    fn uniform_integers_reach_every_value_equally() {
        // 80 000 draws of 8 values: sigma of a count is 93.5, 4 sigma are 374.
        for seed in 1..=3 {
            let mut generator = Generator::seeded(seed);
            let mut counts = [0_i32; 8];
            for _ in 0..80_000 {
                counts[uniform_below(&mut generator, 8) as usize] += 1;
            }
            for count in counts {
                assert!((count - 10_000).abs() < 374, "seed {seed}: {counts:?}");
            }
        }
        assert_eq!(uniform_below(&mut Generator::seeded(1), 0), 0);
    }

    #[test]
    fn normal_samples_have_normal_moments() {
        // n samples: sigma of the mean is 1/sqrt(n), of the variance sqrt(2/n), of
        // the skewness sqrt(6/n), of the excess kurtosis sqrt(24/n); 4 sigma each.
        const PAIRS: u32 = 500_000;
        let n = 2.0 * f64::from(PAIRS);
        for seed in 1..=3 {
            let mut generator = Generator::seeded(seed);
            let mut powers = [0.0_f64; 4];
            let mut product = 0.0;
            let mut beyond_three = 0_u32;
            for _ in 0..PAIRS {
                let (a, b) = standard_normal_pair(&mut generator);
                product += f64::from(a) * f64::from(b);
                for z in [f64::from(a), f64::from(b)] {
                    beyond_three += u32::from(z.abs() > 3.0);
                    for (power, sum) in (1..).zip(&mut powers) {
                        *sum += z.powi(power);
                    }
                }
            }
            let [mean, variance, skewness, fourth] = powers.map(|sum| sum / n);
            assert!(mean.abs() < 4.0 / n.sqrt(), "seed {seed}: mean {mean}");
            assert!(
                (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(),
                "seed {seed}: {variance}"
            );
            assert!(
                skewness.abs() < 4.0 * (15.0 / n).sqrt(),
                "seed {seed}: {skewness}"
            );
            assert!(
                (fourth - 3.0).abs() < 4.0 * (96.0 / n).sqrt(),
                "seed {seed}: {fourth}"
            );
            // E(ab) = 0 with sigma 1/sqrt(pairs).
            let correlation = product / f64::from(PAIRS);
            assert!(
                correlation.abs() < 4.0 / f64::from(PAIRS).sqrt(),
                "seed {seed}: {correlation}"
            );
            // P(|z| > 3) = 0.0026998.
            let expected = 0.002_699_8 * n;
            let error = (f64::from(beyond_three) - expected).abs();
            assert!(
                error < 4.0 * expected.sqrt(),
                "seed {seed}: {beyond_three} beyond 3 sigma"
            );
        }
    }

    #[test]
    fn nearly_normal_samples_have_the_first_four_moments_of_four_uniform_numbers() {
        for seed in 1..=3 {
            let mut generator = Generator::seeded(seed);
            const PAIRS: u32 = 100_000;
            let n = f64::from(2 * PAIRS);
            let (mut powers, mut product, mut most) = ([0.0; 4], 0.0, 0.0_f64);
            for _ in 0..PAIRS {
                let (a, b) = nearly_normal_pair(&mut generator);
                product += f64::from(a) * f64::from(b);
                for z in [f64::from(a), f64::from(b)] {
                    most = most.max(z.abs());
                    for (power, sum) in (1..).zip(&mut powers) {
                        *sum += z.powi(power);
                    }
                }
            }
            let [mean, variance, skewness, fourth] = powers.map(|sum| sum / n);
            let moments = format!("seed {seed}: {mean} {variance} {skewness} {fourth} {product}");
            assert!(mean.abs() < 4.0 / n.sqrt(), "{moments}");
            // The variance of z^2 is 2.7 - 1, that of z^3 below 15, of z^4 below 96.
            assert!((variance - 1.0).abs() < 4.0 * (1.7 / n).sqrt(), "{moments}");
            assert!(skewness.abs() < 4.0 * (15.0 / n).sqrt(), "{moments}");
            assert!((fourth - 2.7).abs() < 4.0 * (96.0 / n).sqrt(), "{moments}");
            let correlation = product / f64::from(PAIRS);
            assert!(
                correlation.abs() < 4.0 / f64::from(PAIRS).sqrt(),
                "{moments}"
            );
            assert!((3.0..=3.451).contains(&most), "{most}");
        }
    }

    #[test]
    fn one_random_number_gives_an_index_and_an_independent_share() {
        for bound in [1, 3, 8] {
            let mut generator = Generator::seeded(u64::from(bound));
            let mut sums = vec![(0_u32, 0.0_f64); bound as usize];
            for _ in 0..80_000 {
                let (index, share) = uniform_below_and_within(&mut generator, bound);
                assert!((0.0..1.0).contains(&share));
                let sum = &mut sums[index as usize];
                *sum = (sum.0 + 1, sum.1 + f64::from(share));
            }
            for (count, sum) in sums {
                let n = f64::from(count);
                // Four standard deviations of a count, and of a mean of uniform numbers.
                let expected = 80_000.0 / f64::from(bound);
                assert!(
                    (n - expected).abs() <= 4.0 * expected.sqrt(),
                    "{bound}: {n}"
                );
                let mean = sum / n;
                assert!(
                    (mean - 0.5).abs() < 4.0 / (12.0 * n).sqrt(),
                    "{bound}: {mean}"
                );
            }
        }
        assert_eq!(
            uniform_below_and_within(&mut Generator::seeded(1), 0),
            (0, 0.0)
        );
    }
}
