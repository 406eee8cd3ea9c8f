//! Resampling: low particles move to obstacles or are scattered.

use super::{BeamModel, BeamParticle, BeamParticleFilter, BeamTally};
use crate::geometry::Point;
use crate::random::{Generator, standard_normal_pair, uniform};

/// Goes through the high particles along their summed weights.
#[derive(Debug, Default)]
struct HighParticles {
    next: usize,
    /// Sum of the weights of the high particles before `next`.
    weight: f32,
    current: Option<BeamParticle>,
}

impl HighParticles {
    /// The high particle at which the summed weights pass `pointer`; pointers must grow.
    fn at(&mut self, particles: &[BeamParticle], pointer: f32) -> Option<BeamParticle> {
        while self.current.is_none() || self.weight <= pointer {
            let Some(particle) = particles.get(self.next) else {
                break;
            };
            self.next += 1;
            if particle.is_high() {
                self.weight += particle.weight;
                self.current = Some(*particle);
            }
        }
        self.current
    }
}

impl<const N: usize> BeamParticleFilter<N> {
    /// Gives each low particle another place; mid and high ones are not touched (guideline
    /// 1 of \[KS\]).
    ///
    /// A low particle is left where it is with the probability `scout_share`; else it is
    /// scattered with the probability `scatter_share`; else it moves to a high particle,
    /// drawn in proportion to the weights, plus N(0, (l_w / 2)^2) per axis, and takes its
    /// weight. Without a high particle it stays.
    ///
    /// \[KS\] uses a "resampling wheel with a slight modification" and does not give it. The
    /// wheel draws each source on its own. Here the pointers are equidistant, as in
    /// systematic resampling: the same expected number of copies, less variance, and one
    /// pass over the set whatever the number of high particles, so a cycle is O(n).
    pub(super) fn resample(
        &mut self,
        model: &BeamModel,
        tally: &mut BeamTally,
        rng: &mut Generator,
    ) {
        self.cycles_since_resampling = 0;
        let low = self.particles().filter(|p| p.is_low()).count();
        let high = self.particles().filter(|p| p.is_high());
        let spacing = high.map(|p| p.weight).sum::<f32>() / low.max(1) as f32;
        let parameters = model.parameters();
        let mut pointer = spacing * uniform(rng);
        let mut sources = HighParticles::default();
        for index in 0..self.count {
            let live = self.particles.get(..self.count).unwrap_or_default();
            let Some(particle) = live.get(index).filter(|p| p.is_low()) else {
                continue;
            };
            let source = sources.at(live, pointer);
            pointer += spacing;
            let replaced = if uniform(rng) < parameters.scout_share {
                *particle
            } else if uniform(rng) < parameters.scatter_share {
                tally.scattered += 1;
                BeamParticle::anywhere(model, rng)
            } else if let Some(source) = source {
                tally.moved_to_obstacles += 1;
                marked_copy(&source, model, rng)
            } else {
                *particle
            };
            if let Some(slot) = self.particles.get_mut(index) {
                *slot = replaced;
            }
        }
        for particle in self.live_mut() {
            particle.weight = particle.weight.abs();
        }
    }
}

/// A particle beside `source`, inside the disc.
///
/// Its weight is negative until the pass ends: then it is not high, and no source of others.
fn marked_copy(source: &BeamParticle, model: &BeamModel, rng: &mut Generator) -> BeamParticle {
    let sigma_m = 0.5 * model.parameters().beam_tolerance_m;
    let (x, y) = standard_normal_pair(rng);
    let beside = source.position + Point::new(sigma_m * x, sigma_m * y);
    let is_inside = beside.norm_squared() <= model.radius_squared;
    BeamParticle {
        position: if is_inside { beside } else { source.position },
        weight: -source.weight,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_filter::BeamFilterParameters;
    use crate::random::uniform_below;

    const N: usize = 3000;

    /// In random order about two thirds low; of the rest a quarter each mid, high with 0.8,
    /// high with 1.0 and mid. An order with a period would lock the equidistant pointers.
    fn filter() -> Box<BeamParticleFilter<N>> {
        let mut filter = Box::new(BeamParticleFilter::<N>::new());
        let mut rng = Generator::seeded(9);
        filter.count = N;
        for particle in &mut filter.particles {
            let (x, weight) = match uniform_below(&mut rng, 12) {
                0 => (0.2, 0.5),
                1 => (0.3, 0.8),
                2 => (0.4, 1.0),
                3 => (0.5, 0.7),
                _ => (-0.5, 0.1),
            };
            *particle = BeamParticle {
                position: Point::new(x, 0.0),
                weight,
            };
        }
        filter
    }

    fn count(filter: &BeamParticleFilter<N>, is_counted: impl Fn(&BeamParticle) -> bool) -> u32 {
        filter.particles().filter(|p| is_counted(p)).count() as u32
    }

    fn resampled(
        change: impl FnOnce(&mut BeamFilterParameters),
        seed: u64,
    ) -> (Box<BeamParticleFilter<N>>, BeamTally) {
        let mut parameters = BeamFilterParameters::PAPER;
        change(&mut parameters);
        let model = BeamModel::new(parameters).unwrap();
        let (mut filter, mut tally) = (filter(), BeamTally::default());
        filter.resample(&model, &mut tally, &mut Generator::seeded(seed));
        (filter, tally)
    }

    #[test]
    fn guideline_1_mid_and_high_particles_are_untouched() {
        let (filter, _) = resampled(|_| (), 1);
        for (before, after) in self::filter().particles().zip(filter.particles()) {
            assert!(before.is_low() || before == after, "{before:?} {after:?}");
            assert!((0.0..=1.0).contains(&after.weight), "{after:?}");
        }
    }

    #[test]
    fn guideline_2_scouts_stay_in_empty_space() {
        // About 2000 low particles, 5 % scouts: sigma 9.7, 4 sigma 39.
        let low = count(&filter(), BeamParticle::is_low);
        for seed in 1..=3 {
            let (filter, tally) = resampled(|_| (), seed);
            let scouts = count(&filter, BeamParticle::is_low);
            let expected = 0.05 * low as f32;
            assert!((scouts as f32 - expected).abs() < 39.0, "{seed}: {scouts}");
            assert_eq!(tally.moved_to_obstacles, low - scouts, "seed {seed}");
        }
    }

    #[test]
    fn copies_are_in_proportion_to_the_weights() {
        // Equidistant pointers: each source has at most one copy more or less than its
        // share. 250 sources: sigma of the sum is 8, 4 sigma are 32.
        let near_x = |filter: &_, x: f32| count(filter, |p| (p.position.x - x).abs() < 0.045);
        let start = filter();
        let (weak, strong) = (near_x(&start, 0.3), near_x(&start, 0.4));
        let low = count(&start, BeamParticle::is_low);
        let per_weight = low as f32 / (0.8 * weak as f32 + strong as f32);
        for seed in 1..=3 {
            let (filter, tally) = resampled(|p| p.scout_share = 0.0, seed);
            assert_eq!(tally.moved_to_obstacles, low, "seed {seed}");
            for (x, sources, weight) in [(0.3, weak, 0.8), (0.4, strong, 1.0)] {
                let copies = (near_x(&filter, x) - sources) as f32;
                let expected = sources as f32 * weight * per_weight;
                assert!((copies - expected).abs() < 32.0, "seed {seed}: {copies}");
            }
        }
    }

    #[test]
    fn half_of_the_low_particles_are_scattered_in_the_form_for_a_moving_robot() {
        // 1900 of 2000 low particles are no scouts; half of them 950, sigma 22.
        let is_mid = |p: &BeamParticle| !p.is_low() && !p.is_high();
        let (low, mid) = (
            count(&filter(), BeamParticle::is_low),
            count(&filter(), is_mid),
        );
        let (filter, tally) = resampled(|p| *p = BeamFilterParameters::MOVING, 1);
        let expected = 0.475 * low as f32;
        assert!(
            (tally.scattered as f32 - expected).abs() < 88.0,
            "{tally:?}"
        );
        assert_eq!(count(&filter, is_mid) - mid, tally.scattered);
    }

    #[test]
    fn without_an_obstacle_low_particles_stay() {
        let mut filter = filter();
        for particle in filter.particles.iter_mut().filter(|p| p.is_high()) {
            particle.weight = 0.5;
        }
        let before = filter.digest();
        let model = BeamModel::new(BeamFilterParameters::PAPER).unwrap();
        let mut tally = BeamTally::default();
        filter.resample(&model, &mut tally, &mut Generator::seeded(1));
        assert_eq!(filter.digest(), before);
        assert_eq!(tally, BeamTally::default());
    }
}
