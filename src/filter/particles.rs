//! The particle set: eight bytes per particle, structure of arrays, fixed capacity.

use super::{Evaluation, SegmentModel, SegmentTracker};
use crate::checksum::Digest;
use crate::geometry::Point;
use crate::math;

/// Positions are stored in 1/64 mm: +-512 mm in 16 bits.
const UNITS_PER_METRE: f32 = 64_000.0;

/// Up to N particles: positions in the body frame, epochs, weights and flags.
///
/// A value of zeros is the empty set, so a `static` of this type needs no flash. Not
/// `Clone` and never returned by value at run time, because 64 kB would go over the
/// stack. Two bytes each for x, y and weight, one each for epoch and flags.
#[derive(Debug)]
pub struct ParticleSet<const N: usize> {
    x: [i16; N],
    y: [i16; N],
    weight: [u16; N],
    epoch: [u8; N],
    flags: [u8; N],
    /// Without segments but in the profile `wall`. Here, since what is not in the set
    /// goes over the stack when a node is made.
    pub(super) tracker: SegmentTracker,
    /// What the tracker needs; made in its first step.
    pub(super) segment_model: Option<SegmentModel>,
}

impl<const N: usize> ParticleSet<N> {
    /// The number of slots.
    pub const CAPACITY: usize = N;

    /// The empty set.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            x: [0; N],
            y: [0; N],
            weight: [0; N],
            epoch: [0; N],
            flags: [0; N],
            tracker: SegmentTracker::new(),
            segment_model: None,
        }
    }

    /// Removes every particle.
    pub(super) fn clear(&mut self) {
        self.epoch.fill(0);
        self.x.fill(0);
        self.y.fill(0);
        self.tracker.reset();
    }

    /// Those of the first `active` slots that have a particle, in slot order.
    #[inline]
    pub(super) fn live_slots(&mut self, active: usize) -> impl Iterator<Item = Slot<'_>> {
        self.slots(active).filter(Slot::is_live)
    }

    /// The first `active` slots, in slot order.
    #[inline]
    pub(super) fn slots(&mut self, active: usize) -> impl Iterator<Item = Slot<'_>> {
        self.x
            .iter_mut()
            .zip(self.y.iter_mut())
            .zip(self.weight.iter_mut())
            .zip(self.epoch.iter_mut().zip(self.flags.iter_mut()))
            .take(active)
            .map(|(((x, y), weight), (epoch, flags))| Slot {
                x,
                y,
                weight,
                epoch,
                flags,
            })
    }

    /// [`Digest`] over the first `active` slots: for each, y in the high and x in the
    /// low half of a word, then its stored epoch.
    ///
    /// A host, the flash image and a recording compute the same filter exactly when
    /// their digests are equal after every step.
    #[must_use]
    pub fn digest(&self, active: usize) -> u32 {
        let mut digest = Digest::default();
        for ((x, y), epoch) in self.x.iter().zip(&self.y).zip(&self.epoch).take(active) {
            digest.update(u32::from(*x as u16) | u32::from(*y as u16) << 16);
            digest.update(u32::from(*epoch));
        }
        digest.value()
    }

    /// Positions and epochs of the live particles among the first `active`, in slot order.
    pub fn live(&self, active: usize) -> impl Iterator<Item = (Point, u8)> {
        self.x
            .iter()
            .zip(&self.y)
            .zip(&self.epoch)
            .take(active)
            .filter(|(_, epoch)| **epoch > 0)
            .map(|((x, y), epoch)| (unpack(*x, *y), *epoch - 1))
    }
}

impl<const N: usize> Default for ParticleSet<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[inline]
fn unpack(x: i16, y: i16) -> Point {
    Point::new(
        f32::from(x) * (1.0 / UNITS_PER_METRE),
        f32::from(y) * (1.0 / UNITS_PER_METRE),
    )
}

/// Nearest unit, halves upward; beyond +-512 mm the last one.
#[inline]
fn pack(metres: f32) -> i16 {
    const ZERO: u16 = 1 << 15;
    let shifted = math::round_to_u32(metres * UNITS_PER_METRE + f32::from(ZERO));
    (shifted.min(u32::from(u16::MAX)) as u16).wrapping_sub(ZERO) as i16
}

/// One slot of the set, with or without a particle.
#[derive(Debug)]
pub(super) struct Slot<'a> {
    x: &'a mut i16,
    y: &'a mut i16,
    /// Score in [0, 1] as 0..=65535.
    weight: &'a mut u16,
    /// 0: empty; otherwise the survived steps plus one.
    epoch: &'a mut u8,
    flags: &'a mut u8,
}

impl Slot<'_> {
    #[inline]
    pub(super) fn is_live(&self) -> bool {
        *self.epoch > 0
    }

    #[inline]
    pub(super) fn position(&self) -> Point {
        unpack(*self.x, *self.y)
    }

    /// The position in stored units of 1/64 mm.
    #[inline]
    pub(super) fn units(&self) -> (i16, i16) {
        (*self.x, *self.y)
    }

    #[inline]
    pub(super) fn place(&mut self, position: Point) {
        *self.x = pack(position.x);
        *self.y = pack(position.y);
    }

    /// Puts a particle of epoch 0 at `position` into the slot.
    #[inline]
    pub(super) fn fill(&mut self, position: Point) {
        self.place(position);
        *self.epoch = 1;
    }

    /// Removes the particle; its position and flags stay readable until the next one.
    #[inline]
    pub(super) fn clear(&mut self) {
        *self.epoch = 0;
    }

    /// Counts so many survived steps more, at least one, and returns the new epoch, which
    /// stops at 255.
    #[inline]
    pub(super) fn advance_epoch(&mut self, steps: u8) -> u8 {
        let epoch = *self.epoch;
        *self.epoch = epoch.saturating_add(steps);
        epoch.saturating_add(steps.saturating_sub(1))
    }

    #[inline]
    pub(super) fn weight(&self) -> u16 {
        *self.weight
    }

    #[inline]
    pub(super) fn set_evaluation(&mut self, evaluation: &Evaluation) {
        *self.weight = evaluation.packed_weight();
        *self.flags = evaluation.flags();
    }

    /// What the sensors saw of the particle's position, see [`Evaluation::flags`].
    #[inline]
    pub(super) fn flags(&self) -> u8 {
        *self.flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{InverseParticleFilter, Profile};
    use crate::geometry::Motion;
    use crate::model::Sample;
    use crate::node::Config;
    use crate::random::{Generator, uniform_below};

    const SEEN: Evaluation = Evaluation {
        weight: 0.5,
        in_view: true,
        seen_past: false,
    };

    #[test]
    fn a_particle_takes_eight_bytes() {
        let bytes =
            core::mem::size_of::<ParticleSet<2000>>() - core::mem::size_of::<ParticleSet<1000>>();
        assert_eq!(bytes, 8000);
    }

    #[test]
    fn positions_return_within_half_a_unit() {
        let mut set = ParticleSet::<4>::new();
        for (x, y) in [
            (0.0, 0.0),
            (0.123_45, -0.317),
            (-0.5, 0.5),
            (-0.000_008, 0.000_007),
        ] {
            let mut slot = set.slots(1).next().unwrap();
            slot.fill(Point::new(x, y));
            let error = slot.position() - Point::new(x, y);
            assert!(error.x.abs() <= 0.5e-3 / 64.0 + 1e-8, "x = {x}");
            assert!(error.y.abs() <= 0.5e-3 / 64.0 + 1e-8, "y = {y}");
        }
    }

    #[test]
    fn places_beyond_the_format_stop_at_its_edge() {
        let mut set = ParticleSet::<1>::new();
        let mut slot = set.slots(1).next().unwrap();
        slot.fill(Point::new(9.0, f32::NEG_INFINITY));
        assert_eq!(slot.units(), (i16::MAX, i16::MIN));
    }

    #[test]
    fn digest_sees_every_stored_value_but_the_weight() {
        let mut set = ParticleSet::<2>::new();
        let empty = set.digest(2);
        set.slots(2).for_each(|mut slot| slot.set_evaluation(&SEEN));
        assert_eq!(set.digest(2), empty);
        set.slots(2).last().unwrap().fill(Point::new(0.0, 0.0));
        let drawn = set.digest(2);
        assert_ne!(drawn, empty);
        set.slots(2).last().unwrap().place(Point::new(0.0, 0.001));
        assert_ne!(set.digest(2), drawn);
    }

    /// Flips one bit of the set's memory.
    fn flip<const N: usize>(set: &mut ParticleSet<N>, generator: &mut Generator) {
        let slot = uniform_below(generator, N as u32) as usize;
        let bit = uniform_below(generator, 16);
        match uniform_below(generator, 8) {
            0 | 1 => set.x[slot] ^= 1 << bit,
            2 | 3 => set.y[slot] ^= 1 << bit,
            4 | 5 => set.weight[slot] ^= 1 << bit,
            6 => set.epoch[slot] ^= 1 << (bit % 8),
            _ => set.flags[slot] ^= 1 << (bit % 8),
        }
    }

    #[test]
    fn f54_flipped_bits_never_move_a_particle_to_an_illegal_place() {
        const N: usize = 400;
        let mut generator = Generator::seeded(54);
        for profile in [Profile::Paper, Profile::Plus] {
            let config = Config::amiro(profile);
            let model = config.model();
            let mut set = ParticleSet::<N>::new();
            let mut readings = [Sample::Counts(0); 8].map(|sample| model.photometry().read(sample));
            readings[1] = model.photometry().read(Sample::Counts(110));
            let motion = Motion {
                displacement: Point::new(0.01, 0.0),
                ..Motion::NONE
            };
            // 1000 steps with 50 flips before each, in each profile: 10^5 in all.
            for step in 0..1000 {
                let mut filter = InverseParticleFilter::over(&mut set, N, step);
                let tally = filter.step(&model, &motion, &readings, |_, _| ());
                let outcomes = tally.past_gate + tally.below_gate + tally.free + tally.unobserved;
                assert_eq!(outcomes, tally.live, "step {step}");
                assert!(tally.live + tally.departed <= N as u32, "step {step}");
                // One that was just drawn may lie beyond: it departs in the next step.
                let farthest = filter
                    .live()
                    .filter(|(_, epoch)| *epoch > 0)
                    .map(|(place, _)| place.norm())
                    .fold(0.0, f32::max);
                // Half a unit of storage each way.
                let limit = model.parameters.local_radius_m + 0.000_02;
                assert!(farthest <= limit, "step {step}: {farthest}");
                (0..50).for_each(|_| flip(&mut set, &mut generator));
            }
        }
    }

    #[test]
    fn epoch_stops_before_it_wraps() {
        let mut set = ParticleSet::<1>::new();
        let mut slot = set.slots(1).next().unwrap();
        slot.fill(Point::new(0.1, 0.0));
        let epochs: Vec<u8> = (0..300).map(|_| slot.advance_epoch(1)).collect();
        assert_eq!(&epochs[..3], &[1, 2, 3]);
        assert_eq!(epochs[299], 255);
        assert!(slot.is_live());
    }
}
