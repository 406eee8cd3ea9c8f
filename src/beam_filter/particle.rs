//! A particle of the beam filter: 12 bytes.

use super::BeamModel;
use crate::geometry::{Point, Rotation};
use crate::math;
use crate::random::{Generator, uniform};

/// A position near the robot and the probability that it is part of an obstacle.
///
/// Three floats. \[KS\] counts five: the other two are an angle that it writes and never
/// reads, and one that no table names.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamParticle {
    /// Position relative to the robot's centre, in axes that do not turn with it; metres.
    pub position: Point,
    /// Probability of being part of an obstacle, 0 to 1, not normalised (omega).
    pub weight: f32,
}

impl BeamParticle {
    /// A weight below this is low: the position is free.
    pub const LOW: f32 = 0.25;

    /// A weight above this is high: the position is part of an obstacle.
    pub const HIGH: f32 = 0.75;

    /// The weight of a position of which nothing is known.
    pub const UNDETERMINED: f32 = 0.5;

    /// Whether the position is free.
    #[must_use]
    #[inline]
    pub fn is_low(&self) -> bool {
        self.weight < Self::LOW
    }

    /// Whether the position is part of an obstacle.
    #[must_use]
    #[inline]
    pub fn is_high(&self) -> bool {
        self.weight > Self::HIGH
    }

    /// An undetermined particle at a position.
    #[inline]
    pub(super) fn undetermined(position: Point) -> Self {
        Self {
            position,
            weight: Self::UNDETERMINED,
        }
    }

    /// An undetermined particle, uniform in the disc: radius r sqrt(U), any bearing
    /// (\[KS\] Algorithm 1, corrected).
    #[inline]
    pub(super) fn anywhere(model: &BeamModel, rng: &mut Generator) -> Self {
        let distance_m = model.parameters().local_radius_m * math::sqrt(uniform(rng));
        let (sine, cosine) = math::sin_cos_of_random(rng.bits());
        Self::undetermined(Point::new(distance_m, 0.0).rotated(Rotation { sine, cosine }))
    }

    /// Returns the weight towards 0.5: w = 0.5 + (w - 0.5) (1 - e_w).
    #[inline]
    pub(super) fn decay(&mut self, model: &BeamModel) {
        let keep = 1.0 - model.parameters().decay;
        self.weight = Self::UNDETERMINED + (self.weight - Self::UNDETERMINED) * keep;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_filter::BeamFilterParameters;

    fn model(decay: f32) -> BeamModel {
        BeamModel::new(BeamFilterParameters {
            decay,
            ..BeamFilterParameters::PAPER
        })
        .unwrap()
    }

    fn printed_decay(weight: f32, decay: f32) -> f32 {
        if weight < 0.5 {
            weight * (1.0 + decay)
        } else {
            weight * (1.0 - decay)
        }
    }

    #[test]
    fn g9_a_particle_takes_twelve_bytes_and_ten_thousand_do_not_fit_in_50_kb() {
        let bytes = core::mem::size_of::<BeamParticle>();
        assert_eq!(bytes, 12);
        assert_eq!(bytes * 10_000, 120_000);
        // The printed layout: five single floats per particle.
        assert_eq!(core::mem::size_of::<[f32; 5]>() * 10_000, 200_000);
    }

    #[test]
    fn g9_decay_is_symmetric_about_one_half_where_the_printed_one_is_not() {
        for (weight, corrected, printed) in [
            (0.1, 0.108, 0.102),
            (0.5, 0.5, 0.49),
            (0.9, 0.892, 0.882),
            (0.0, 0.01, 0.0),
        ] {
            let mut particle = BeamParticle {
                weight,
                ..BeamParticle::default()
            };
            particle.decay(&model(0.02));
            assert!((particle.weight - corrected).abs() < 1e-7, "{weight}");
            assert!((printed_decay(weight, 0.02) - printed).abs() < 1e-7);
        }
    }

    #[test]
    fn g9_a_uniform_start_fills_the_disc_of_radius_r_where_the_printed_bound_does_not() {
        // n = 40 000 in 4 rings of equal area: sigma of a count is 87, 4 sigma are 347.
        let parameters = BeamFilterParameters {
            local_radius_m: 3.0,
            ..BeamFilterParameters::PAPER
        };
        let model = BeamModel::new(parameters).unwrap();
        for seed in 1..=3 {
            let mut rng = Generator::seeded(seed);
            let mut rings = [0_i32; 4];
            let mut printed = 0;
            for _ in 0..40_000 {
                let particle = BeamParticle::anywhere(&model, &mut rng);
                let share = particle.position.norm_squared() / 9.0;
                assert!(share <= 1.000_001, "seed {seed}: {particle:?}");
                rings[((share * 4.0) as usize).min(3)] += 1;
                printed += i32::from(particle.position.norm_squared() <= 3.0);
            }
            for count in rings {
                assert!((count - 10_000).abs() < 347, "seed {seed}: {rings:?}");
            }
            // x^2 + y^2 <= r would fill a third of this disc.
            assert!((printed - 13_333).abs() < 400, "seed {seed}: {printed}");
        }
    }
}
