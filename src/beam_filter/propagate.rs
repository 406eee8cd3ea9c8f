//! Movement: particles pass the robot, and those that leave the disc enter it again.

use super::{BeamModel, BeamParticle, BeamParticleFilter, BeamTally, Reentry};
use crate::geometry::{Motion, Point, Rotation};
use crate::math;
use crate::random::{Generator, standard_normal_pair, uniform};

/// Longest piece of a motion as a share of the disc's radius: 5 cm of 1.5 m.
///
/// In one piece of a metre the crescent would be most of the disc.
const LONGEST_PIECE: f32 = 1.0 / 30.0;

/// Most draws of one position in the crescent. A draw fails with a probability of at most
/// 1 - pi / 4, and of less than 1e-4 for a piece: ten failures are no concern.
const MOST_DRAWS: u32 = 10;

/// A straight motion of the robot's centre in the axes of the particles.
#[derive(Clone, Copy, Debug)]
pub(super) struct StraightMotion {
    displacement: Point,
    length_m: f32,
    direction: Rotation,
    /// Standard deviation of the motion, each axis; metres.
    sigma_m: f32,
}

impl StraightMotion {
    /// None if nothing moves or the numbers are no motion.
    pub(super) fn new(model: &BeamModel, displacement: Point) -> Option<Self> {
        let length_m = displacement.norm();
        (length_m > 0.0 && length_m.is_finite()).then(|| Self {
            displacement,
            length_m,
            direction: Rotation {
                sine: displacement.y / length_m,
                cosine: displacement.x / length_m,
            },
            sigma_m: model.parameters().motion_noise * length_m,
        })
    }

    /// p - m + N(0, (e_m m)^2 I); a particle that leaves the disc enters it again.
    ///
    /// Returns whether it did.
    pub(super) fn propagate(
        &self,
        particle: &mut BeamParticle,
        model: &BeamModel,
        rng: &mut Generator,
    ) -> bool {
        let mut position = particle.position - self.displacement;
        if self.sigma_m > 0.0 {
            let (x, y) = standard_normal_pair(rng);
            position = position + Point::new(self.sigma_m * x, self.sigma_m * y);
        }
        let leaves = position.norm_squared() > model.radius_squared;
        *particle = if leaves {
            BeamParticle::undetermined(self.reentry(position, model, rng))
        } else {
            BeamParticle {
                position,
                ..*particle
            }
        };
        leaves
    }

    /// Where a particle that has left the disc to `outside` enters it again.
    fn reentry(&self, outside: Point, model: &BeamModel, rng: &mut Generator) -> Point {
        let radius_m = model.parameters().local_radius_m;
        match model.parameters().reentry {
            Reentry::Opposite => {
                let scale = -radius_m / outside.norm();
                Point::new(scale * outside.x, scale * outside.y)
            }
            Reentry::RimAhead => {
                let bearing = (2.0 * uniform(rng) - 1.0) * core::f32::consts::FRAC_PI_3;
                Point::new(radius_m, 0.0)
                    .rotated(Rotation::by(bearing))
                    .rotated(self.direction)
            }
            Reentry::Crescent => self.in_crescent(model, rng),
        }
    }

    /// A position that is uniform in the crescent |q| <= r, |q + m| > r.
    ///
    /// At a distance t beside the motion the crescent reaches back from the rim by |m|, or
    /// by the whole chord 2 h where that is shorter. So t is drawn uniformly in -r to r, the
    /// depth uniformly in 0 to |m|, and the draw is repeated if it lies beyond the chord.
    /// The distribution is that of drawing in the whole disc until the crescent is hit,
    /// which takes 50 draws at |m| = 0.03 r; this takes one. If every draw fails, it is the
    /// point of the rim ahead.
    fn in_crescent(&self, model: &BeamModel, rng: &mut Generator) -> Point {
        let radius_m = model.parameters().local_radius_m;
        let mut drawn = Point::new(radius_m, 0.0);
        for _ in 0..MOST_DRAWS {
            let beside = radius_m * (2.0 * uniform(rng) - 1.0);
            let half_chord = math::sqrt((model.radius_squared - beside * beside).max(0.0));
            let depth = self.length_m * uniform(rng);
            if depth <= 2.0 * half_chord {
                drawn = Point::new(half_chord - depth, beside);
                break;
            }
        }
        drawn.rotated(self.direction)
    }
}

impl<const N: usize> BeamParticleFilter<N> {
    /// Moves the particles against a motion of the body, without a measurement.
    ///
    /// [`Self::cycle`] does it first; alone it is for a motion between scans. A motion is
    /// applied in straight pieces of at most r / 30 (5 cm of 1.5 m), each with its own
    /// noise. The chord replaces the arc: the axes do not turn, and every particle moves by
    /// the same vector. After a motion of 2 r or more nothing of the disc is left; it is
    /// filled anew, as by [`Self::reset`]. So there are at most 61 pieces.
    ///
    /// A motion that is not finite moves nothing and is reported.
    pub fn advance(
        &mut self,
        model: &BeamModel,
        motion: &Motion,
        rng: &mut Generator,
    ) -> BeamTally {
        let mut tally = BeamTally::default();
        let turned = self.heading.radians() + motion.turn.radians();
        let Point { x, y } = motion.displacement;
        if !(x.is_finite() && y.is_finite() && turned.is_finite()) {
            tally.motion_refused = true;
            return tally;
        }
        let displacement = motion
            .displacement
            .rotated(Rotation::by(self.heading.radians()));
        self.heading = turned.into();
        let radius_m = model.parameters().local_radius_m;
        let length_m = displacement.norm();
        if length_m >= 2.0 * radius_m {
            for particle in self.live_mut() {
                *particle = BeamParticle::anywhere(model, rng);
                tally.reentered += 1;
            }
            return tally;
        }
        let pieces = (length_m / (LONGEST_PIECE * radius_m)) as u32 + 1;
        let share = 1.0 / pieces as f32;
        let piece = Point::new(share * displacement.x, share * displacement.y);
        let Some(advance) = StraightMotion::new(model, piece) else {
            return tally;
        };
        for particle in self.live_mut() {
            for _ in 0..pieces {
                tally.reentered += u32::from(advance.propagate(particle, model, rng));
            }
        }
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_filter::BeamFilterParameters;
    use crate::geometry::Angle;

    fn model(reentry: Reentry, motion_noise: f32) -> BeamModel {
        BeamModel::new(BeamFilterParameters {
            local_radius_m: 1.0,
            reentry,
            motion_noise,
            ..BeamFilterParameters::PAPER
        })
        .unwrap()
    }

    #[test]
    fn g9_a_particle_that_leaves_enters_at_the_opposite_point_of_the_rim() {
        let model = model(Reentry::Opposite, 0.0);
        let advance = StraightMotion::new(&model, Point::new(0.1, 0.0)).unwrap();
        let mut particle = BeamParticle {
            position: Point::new(-0.95, 0.1),
            weight: 0.9,
        };
        assert!(advance.propagate(&mut particle, &model, &mut Generator::seeded(1)));
        let expected = Point::new(0.995_495_5, -0.094_809_09);
        assert!((particle.position - expected).norm() < 1e-6, "{particle:?}");
        assert_eq!(particle.weight.to_bits(), 0.5_f32.to_bits());
    }

    #[test]
    fn rim_ahead_is_within_sixty_degrees_of_the_motion() {
        let model = model(Reentry::RimAhead, 0.0);
        let advance = StraightMotion::new(&model, Point::new(0.0, -0.1)).unwrap();
        let mut rng = Generator::seeded(2);
        for _ in 0..10_000 {
            let point = advance.reentry(Point::new(0.0, 1.05), &model, &mut rng);
            assert!((point.norm() - 1.0).abs() < 1e-6, "{point:?}");
            assert!(point.y < -0.499_999, "{point:?}");
        }
    }

    #[test]
    fn crescent_is_filled_uniformly() {
        // Both halves beside the motion, and both halves of the depth at the middle:
        // n = 20 000, sigma of a count of half of them is 71, 4 sigma are 283.
        let model = model(Reentry::Crescent, 0.0);
        for (length_m, seed) in [(0.03, 1), (0.4, 2), (1.5, 3)] {
            let advance = StraightMotion::new(&model, Point::new(length_m, 0.0)).unwrap();
            let mut rng = Generator::seeded(seed);
            let mut left = 0_i32;
            for _ in 0..20_000 {
                let q = advance.in_crescent(&model, &mut rng);
                let before = q + Point::new(length_m, 0.0);
                assert!(q.norm() < 1.000_001, "{length_m}: {q:?}");
                assert!(before.norm() > 0.999_999, "{length_m}: {q:?}");
                left += i32::from(q.y > 0.0);
            }
            assert!((left - 10_000).abs() < 283, "{length_m}: {left}");
        }
    }

    #[test]
    fn crescent_has_the_density_of_drawing_in_the_disc_until_it_is_hit() {
        // Share with |y| < 0.5, from both rules: sigma of each share is at most 0.0036 with
        // n = 20 000; 4 sigma of the difference are 0.02.
        let model = model(Reentry::Crescent, 0.0);
        for length_m in [0.2, 1.2] {
            let advance = StraightMotion::new(&model, Point::new(length_m, 0.0)).unwrap();
            let mut rng = Generator::seeded(4);
            let (mut direct, mut rejected, mut drawn) = (0, 0, 0);
            for _ in 0..20_000 {
                let q = advance.in_crescent(&model, &mut rng);
                direct += i32::from(q.y.abs() < 0.5);
            }
            while drawn < 20_000 {
                let q = BeamParticle::anywhere(&model, &mut rng).position;
                if (q + Point::new(length_m, 0.0)).norm() > 1.0 {
                    drawn += 1;
                    rejected += i32::from(q.y.abs() < 0.5);
                }
            }
            let difference = f64::from(direct - rejected) / 20_000.0;
            assert!(difference.abs() < 0.02, "{length_m}: {difference}");
        }
    }

    #[test]
    fn crescent_keeps_a_uniform_set_uniform_where_the_rim_does_not() {
        // Share of particles far beside the path after 3 m of straight driving. The two
        // segments beyond 0.87 r are 0.0552 of the disc; sigma 0.0051 with n = 2000. From
        // within 60 degrees of the motion nothing enters there.
        let share_beside = |reentry| {
            let model = model(reentry, 0.0);
            let mut rng = Generator::seeded(5);
            let mut filter = Box::new(BeamParticleFilter::<2000>::new());
            filter.reset(&model, 2000, Angle::default(), &mut rng);
            let motion = Motion {
                displacement: Point::new(0.02, 0.0),
                ..Motion::NONE
            };
            for _ in 0..150 {
                filter.advance(&model, &motion, &mut rng);
            }
            let beside = |p: &&BeamParticle| p.position.y.abs() > 0.87;
            filter.particles().filter(beside).count() as f32 / 2000.0
        };
        let crescent = share_beside(Reentry::Crescent);
        assert!((crescent - 0.0552).abs() < 0.021, "{crescent}");
        assert_eq!(share_beside(Reentry::RimAhead).to_bits(), 0);
    }

    #[test]
    fn motion_noise_has_the_printed_deviation_per_axis() {
        // 20 000 samples: sigma of a standard deviation is 0.5 %, 4 sigma are 2 %.
        let model = model(Reentry::Crescent, 0.05);
        let advance = StraightMotion::new(&model, Point::new(0.03, 0.04)).unwrap();
        let mut rng = Generator::seeded(6);
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        for _ in 0..20_000 {
            let mut particle = BeamParticle::undetermined(Point::default());
            advance.propagate(&mut particle, &model, &mut rng);
            x += f64::from(particle.position.x + 0.03).powi(2);
            y += f64::from(particle.position.y + 0.04).powi(2);
        }
        for variance in [x / 20_000.0, y / 20_000.0] {
            let sigma = variance.sqrt();
            assert!((sigma / 0.0025 - 1.0).abs() < 0.02, "{sigma}");
        }
    }
}
