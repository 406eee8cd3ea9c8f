//! The source of a board's first seed.
//!
//! A host gives the seed of a run. Until then a board draws its own: from its random
//! number unit where that works, otherwise from the chip's unique number.

use serde::{Deserialize, Serialize};

/// Words that are drawn to judge a random number unit by: 1024 bits.
pub const WORDS: usize = 32;

/// What a seed was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SeedSource {
    /// The configuration names it; no board is involved.
    #[default]
    Configured,
    /// The random number unit.
    RandomUnit,
    /// The chip's unique number and the count of its boots: the random number unit did
    /// not answer in its time, or answered with something that is not random.
    UniqueNumber,
}

/// The seed that a random number unit's words give, if they look random.
///
/// 1024 fair bits hold 512 ones with a standard deviation of 16; beyond four of them
/// (1 in 16 000) the words are refused, as are two equal words in a row (1 in 10^8).
/// A unit that is stuck fails both.
#[must_use]
pub fn from_words(words: &[u32; WORDS]) -> Option<u64> {
    let ones: u32 = words.iter().map(|word| word.count_ones()).sum();
    let repeats = words.iter().zip(words.iter().skip(1)).any(|(a, b)| a == b);
    if repeats || ones.abs_diff(512) > 64 {
        return None;
    }
    let [low, high, ..] = *words;
    Some(u64::from(high) << 32 | u64::from(low))
}

/// A seed of the chip's unique number and the count of its boots.
///
/// Other chips and other boots give other seeds, every bit of which depends on every
/// bit given: the finaliser of SplitMix64 (Steele et al. 2014) after each word.
#[must_use]
pub fn from_unique_number(number: [u32; 3], boots: u32) -> u64 {
    let [a, b, c] = number;
    [a, b, c, boots]
        .into_iter()
        .fold(0x9e37_79b9_7f4a_7c15, |hash, word| {
            mixed(hash ^ u64::from(word))
        })
}

fn mixed(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ word >> 31
}

#[cfg(test)]
mod tests {
    use rand_core::Rng;

    use super::*;
    use crate::random::Generator;

    #[test]
    fn f51_a_stuck_unit_is_refused_and_a_working_one_taken() {
        for stuck in [0, u32::MAX, 0x5555_5555, 0x1234_5678] {
            assert_eq!(from_words(&[stuck; WORDS]), None, "{stuck:#x}");
        }
        let biased: [u32; WORDS] = core::array::from_fn(|word| 1 << (word % 32));
        assert_eq!(from_words(&biased), None);
        let mut generator = Generator::seeded(7);
        let taken = (0..10_000)
            .filter(|_| from_words(&core::array::from_fn(|_| generator.next_u32())).is_some())
            .count();
        // Beyond four standard deviations lie 0.006 %: 0.6 of 10 000, sigma 0.8.
        assert!(taken >= 9_995, "{taken}");
    }

    #[test]
    fn f50_chips_and_boots_have_seeds_of_their_own() {
        let mut seeds: Vec<u64> = (0..100)
            .flat_map(|boots| (0..100).map(move |chip| from_unique_number([chip, 0, 0], boots)))
            .collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 10_000);
        // One bit changes half of them: 32 with a standard deviation of 4.
        for bit in 0..32 {
            let one = from_unique_number([1 << bit, 0, 0], 0);
            let changed = (one ^ from_unique_number([0, 0, 0], 0)).count_ones();
            assert!((16..=48).contains(&changed), "bit {bit}: {changed}");
        }
    }

    #[test]
    fn f51_no_seed_stops_the_generator() {
        for seed in [0, u64::MAX] {
            let mut generator = Generator::seeded(seed);
            let words: Vec<u32> = (0..100).map(|_| generator.next_u32()).collect();
            assert!(words.iter().any(|word| *word != words[0]), "seed {seed}");
        }
    }
}
