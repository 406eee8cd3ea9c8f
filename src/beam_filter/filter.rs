//! The particle set and its cycle (\[KS\] Algorithms 1 and 2).

use super::{BeamModel, BeamParticle, RangeBeam};
use crate::checksum::Digest;
use crate::geometry::{Angle, Motion, Point, Pose, Rotation};
use crate::random::Generator;

/// What one cycle did, in numbers of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamTally {
    /// The motion was not finite and was not applied; what the particles say may be wrong.
    pub motion_refused: bool,
    /// Left the disc and entered it again.
    pub reentered: u32,
    /// Moved by resampling to an obstacle.
    pub moved_to_obstacles: u32,
    /// Scattered by resampling over the disc.
    pub scattered: u32,
    /// Weighed by at least one beam.
    pub weighed: u32,
}

/// Up to N particles about the robot: 12 N bytes and 12 more on the target.
///
/// A value of zeros is the empty filter, so a `static` of this type needs no flash. Not
/// `Clone` and never returned by value at run time, because it would go over the stack.
/// Two filters with the same seed, model and inputs hold the same bytes.
#[derive(Debug)]
pub struct BeamParticleFilter<const N: usize> {
    pub(super) particles: [BeamParticle; N],
    pub(super) count: usize,
    /// Direction of the body's x axis in the axes of the particles.
    pub(super) heading: Angle,
    pub(super) cycles_since_resampling: u16,
}

/// 1000 particles fit 12 KiB, on every target that the library is built for.
const _: () = assert!(size_of::<BeamParticleFilter<1000>>() <= 12 * 1024);

impl<const N: usize> BeamParticleFilter<N> {
    /// The number of particles that fit.
    pub const CAPACITY: usize = N;

    /// The filter without particles; [`Self::reset`] fills it.
    #[must_use]
    pub const fn new() -> Self {
        const EMPTY: BeamParticle = BeamParticle {
            position: Point::new(0.0, 0.0),
            weight: 0.0,
        };
        Self {
            particles: [EMPTY; N],
            count: 0,
            heading: Motion::NONE.turn,
            cycles_since_resampling: 0,
        }
    }

    /// Fills the disc uniformly with `count` undetermined particles, at most N.
    ///
    /// `heading` is the body's direction in the axes of the particles: with the heading in
    /// a world frame, the axes are those of the world. A heading that is not finite is
    /// taken as 0. Returns the number of particles.
    pub fn reset(
        &mut self,
        model: &BeamModel,
        count: usize,
        heading: Angle,
        rng: &mut Generator,
    ) -> usize {
        self.count = count.min(N);
        self.cycles_since_resampling = 0;
        self.heading = Motion::NONE.turn;
        self.set_heading(heading);
        for particle in self.live_mut() {
            *particle = BeamParticle::anywhere(model, rng);
        }
        self.count
    }

    /// One cycle: the motion since the last cycle, then all beams of the present instant.
    ///
    /// The stages of \[KS\] are decay, measurement, movement, resampling. Here the cycle
    /// begins with the movement, because a robot knows the motion since its last scan and
    /// not the next one. The sequence over many cycles is the same, and the weights after a
    /// cycle are those that its beams gave.
    ///
    /// A motion that is not finite is not applied and reported. Without beams the weights
    /// only decay. Beams overwrite: where two beams meet, the later one counts.
    ///
    /// Costs about 15 operations per beam and particle, and one square root where a beam
    /// reaches a particle; about 100 per particle and piece of the motion
    /// ([`Self::advance`]). On a desktop core a cycle with 32 beams takes 10 ns per beam and
    /// particle, motion included, with 500, 1000 and 4000 particles alike.
    pub fn cycle(
        &mut self,
        model: &BeamModel,
        motion: &Motion,
        beams: &[RangeBeam],
        rng: &mut Generator,
    ) -> BeamTally {
        let mut tally = self.advance(model, motion, rng);
        if self.is_resampling_due(model) {
            self.resample(model, &mut tally, rng);
        }
        tally.weighed = self.weigh(model, beams);
        self.cycles_since_resampling = self.cycles_since_resampling.saturating_add(1);
        tally
    }

    fn is_resampling_due(&self, model: &BeamModel) -> bool {
        let period = model.parameters().resampling_period;
        period > 0 && self.cycles_since_resampling >= period
    }

    /// Decay of every weight, then the beams in their order.
    ///
    /// Beams are fixed to the body, so each particle is turned into the body frame once.
    fn weigh(&mut self, model: &BeamModel, beams: &[RangeBeam]) -> u32 {
        let body_from_axes = Rotation::by(self.heading.radians()).inverse();
        let mut weighed = 0;
        for particle in self.live_mut() {
            particle.decay(model);
            let body = particle.position.rotated(body_from_axes);
            // Later beams overwrite: the last one that reaches the particle counts.
            let mut latest_first = beams.iter().rev();
            if let Some(weight) = latest_first.find_map(|beam| beam.weight_at(model, body)) {
                particle.weight = weight;
                weighed += 1;
            }
        }
        weighed
    }

    /// The body's direction in the axes of the particles.
    #[must_use]
    pub const fn heading(&self) -> Angle {
        self.heading
    }

    /// Corrects the body's direction, as by a compass; no particle moves.
    ///
    /// A heading that is not finite changes nothing and gives `false`.
    pub fn set_heading(&mut self, heading: Angle) -> bool {
        let is_legal = heading.radians().is_finite();
        if is_legal {
            self.heading = heading;
        }
        is_legal
    }

    /// The pose of the particles' axes in the frame in which the body has the pose `body`.
    ///
    /// `world_from_axes`: [`Pose::world_from_body`] of it takes a particle's position into
    /// the world.
    #[must_use]
    pub fn particle_frame(&self, body: &Pose) -> Pose {
        let heading = body.heading.radians() - self.heading.radians();
        Pose::new(body.position.x, body.position.y, heading)
    }

    /// The particles: positions in the particles' axes ([`Self::particle_frame`]), weights.
    ///
    /// A map counts them per cell after each cycle: [`BeamParticle::is_low`] for free,
    /// [`BeamParticle::is_high`] for occupied.
    pub fn particles(&self) -> impl Iterator<Item = &BeamParticle> {
        self.particles.iter().take(self.count)
    }

    #[inline]
    pub(super) fn live_mut(&mut self) -> impl Iterator<Item = &mut BeamParticle> {
        self.particles.iter_mut().take(self.count)
    }

    /// The nearest particle with a weight above `min_weight`, in the body frame; metres.
    ///
    /// `min_weight` is [`BeamParticle::HIGH`] for "part of an obstacle"; a NaN gives none.
    /// \[KS\] section 5: "return the nearest particle to be avoided". When the answer is
    /// valid:
    ///
    /// - None means that no obstacle is **known**, not that the way is free: after a start,
    ///   with sensors that look elsewhere, or with too few particles there is none.
    /// - A particle stays above 0.75 for at most ln 2 / e_w cycles after the last beam that
    ///   confirmed it (69 cycles at 0.01, 347 at 0.002). An obstacle that has moved is
    ///   returned for as long, until a beam passes through its old place.
    /// - Beyond r nothing is known. Two particles are sqrt(pi / n) r apart on average; an
    ///   obstacle is found at the first cycle only if a particle lies within l_w of the end
    ///   of a beam on it.
    ///
    /// Its error on recordings is given at [`super::BeamFilterParameters::MOVING`]; an error
    /// of the robot's motion comes on top. O(n).
    #[must_use]
    pub fn nearest_obstacle(&self, min_weight: f32) -> Option<Point> {
        let mut nearest: Option<Point> = None;
        for particle in self.particles().filter(|p| p.weight > min_weight) {
            let distance_squared = particle.position.norm_squared();
            if nearest.is_none_or(|known| distance_squared < known.norm_squared()) {
                nearest = Some(particle.position);
            }
        }
        let body_from_axes = Rotation::by(self.heading.radians()).inverse();
        nearest.map(|position| position.rotated(body_from_axes))
    }

    /// [`Digest`] over heading, cycles and the bits of every particle: x, y, weight.
    ///
    /// Two machines compute the same filter exactly when their digests are equal.
    #[must_use]
    pub fn digest(&self) -> u32 {
        let mut digest = Digest::default();
        digest.update(self.heading.radians().to_bits());
        digest.update(u32::from(self.cycles_since_resampling));
        for particle in self.particles() {
            digest.update(particle.position.x.to_bits());
            digest.update(particle.position.y.to_bits());
            digest.update(particle.weight.to_bits());
        }
        digest.value()
    }
}

impl<const N: usize> Default for BeamParticleFilter<N> {
    fn default() -> Self {
        Self::new()
    }
}
