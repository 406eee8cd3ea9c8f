//! Random loss of samples.

use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::random::{Generator, uniform};

/// Removes samples at random, each independently.
#[derive(Clone, Debug)]
pub struct Dropout {
    share: f64,
    generator: Generator,
}

impl Dropout {
    /// Removes the given share of all samples, to 2^-24; 1 removes all.
    #[must_use]
    pub const fn new(share: f64, generator: Generator) -> Self {
        Self { share, generator }
    }

    /// The samples with some missing. Draws eight random numbers in every call.
    #[must_use]
    pub fn thin(&mut self, mut samples: [Sample; SENSORS]) -> [Sample; SENSORS] {
        for sample in &mut samples {
            if f64::from(uniform(&mut self.generator)) < self.share {
                *sample = Sample::Missing;
            }
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(share: f64, seed: u64, instants: u32) -> [u32; SENSORS] {
        let mut dropout = Dropout::new(share, Generator::seeded(seed));
        let mut counts = [0; SENSORS];
        for _ in 0..instants {
            let samples = dropout.thin([Sample::Counts(5); SENSORS]);
            for (count, sample) in counts.iter_mut().zip(samples) {
                *count += u32::from(sample == Sample::Missing);
            }
        }
        counts
    }

    #[test]
    fn the_share_that_is_missing_is_the_one_asked_for_at_every_sensor() {
        // 20 000 samples with p = 0.1: sigma of a sensor's count is
        // sqrt(n p (1 - p)) = 42.4, 4 sigma are 170.
        for seed in 1..=3 {
            for count in missing(0.1, seed, 20_000) {
                assert!(count.abs_diff(2_000) < 170, "seed {seed}: {count}");
            }
        }
        assert_eq!(missing(0.0, 1, 1_000), [0; SENSORS]);
        assert_eq!(missing(1.0, 1, 1_000), [1_000; SENSORS]);
    }
}
