//! The particle set: eight bytes a particle, structure of arrays, fixed capacity.

use crate::checksum::Digest;
use crate::geometry::Point;
use crate::math;

/// Positions are stored in 1/64 mm: +-512 mm in 16 bits.
const UNITS_PER_METRE: f32 = 64_000.0;

/// Particle positions in the body frame, with age, weight and view, for up to N.
///
/// A value of zeros is the empty set, so a `static` of this type costs no flash. Not
/// `Clone` and never returned by value at run time: 64 kB do not belong on a stack.
/// Two bytes each for x, y and weight, one each for life and view.
#[derive(Debug)]
pub struct ParticleSet<const N: usize> {
    x: [i16; N],
    y: [i16; N],
    weight: [u16; N],
    life: [u8; N],
    view: [u8; N],
}

impl<const N: usize> ParticleSet<N> {
    /// How many particles fit.
    pub const CAPACITY: usize = N;

    /// The set without a live particle.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            x: [0; N],
            y: [0; N],
            weight: [0; N],
            life: [0; N],
            view: [0; N],
        }
    }

    /// Kills every particle.
    pub(crate) fn clear(&mut self) {
        self.life.fill(0);
        self.x.fill(0);
        self.y.fill(0);
    }

    /// The first `active` slots, in slot order.
    #[inline]
    pub(crate) fn slots(&mut self, active: usize) -> impl Iterator<Item = Slot<'_>> {
        self.x
            .iter_mut()
            .zip(self.y.iter_mut())
            .zip(self.weight.iter_mut())
            .zip(self.life.iter_mut().zip(self.view.iter_mut()))
            .take(active)
            .map(|(((x, y), weight), (life, view))| Slot {
                x,
                y,
                weight,
                life,
                view,
            })
    }

    /// [`Digest`] over the first `active` slots: for each, y in the high and x in the
    /// low half of a word, then its life.
    ///
    /// Equal digests after every step are what "the same bytes" means between a host,
    /// the flash image and a recording.
    #[must_use]
    pub fn digest(&self, active: usize) -> u32 {
        let mut digest = Digest::default();
        for ((x, y), life) in self.x.iter().zip(&self.y).zip(&self.life).take(active) {
            digest.update(u32::from(*x as u16) | u32::from(*y as u16) << 16);
            digest.update(u32::from(*life));
        }
        digest.value()
    }

    /// Positions and ages of the live particles among the first `active`, in slot order.
    pub fn live(&self, active: usize) -> impl Iterator<Item = (Point, u8)> {
        self.x
            .iter()
            .zip(&self.y)
            .zip(&self.life)
            .take(active)
            .filter(|(_, life)| **life > 0)
            .map(|((x, y), life)| (unpack(*x, *y), *life - 1))
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

/// One particle's place in the set; dead until something is drawn into it.
#[derive(Debug)]
pub(crate) struct Slot<'a> {
    x: &'a mut i16,
    y: &'a mut i16,
    /// Score in [0, 1] as 0..=65535.
    weight: &'a mut u16,
    /// 0: dead; otherwise survived steps plus one.
    life: &'a mut u8,
    view: &'a mut u8,
}

impl Slot<'_> {
    #[inline]
    pub(crate) fn is_live(&self) -> bool {
        *self.life > 0
    }

    #[inline]
    pub(crate) fn position(&self) -> Point {
        unpack(*self.x, *self.y)
    }

    /// The position in stored units of 1/64 mm.
    #[inline]
    pub(crate) fn units(&self) -> (i16, i16) {
        (*self.x, *self.y)
    }

    #[inline]
    pub(crate) fn place(&mut self, position: Point) {
        *self.x = pack(position.x);
        *self.y = pack(position.y);
    }

    /// A new particle: age 0 at the given place.
    #[inline]
    pub(crate) fn draw(&mut self, position: Point) {
        self.place(position);
        *self.life = 1;
    }

    #[inline]
    pub(crate) fn kill(&mut self) {
        *self.life = 0;
    }

    /// One more step survived; the new age, which stops at 254.
    #[inline]
    pub(crate) fn grow_older(&mut self) -> u8 {
        let age = *self.life;
        *self.life = age.saturating_add(1);
        age
    }

    #[inline]
    pub(crate) fn weight(&self) -> u16 {
        *self.weight
    }

    #[inline]
    pub(crate) fn set_weight(&mut self, weight: u16, view: u8) {
        *self.weight = weight;
        *self.view = view;
    }

    #[inline]
    pub(crate) fn view(&self) -> u8 {
        *self.view
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::filter::{InverseParticleFilter, Profile};
    use crate::geometry::Motion;
    use crate::random::{Generator, uniform_below};
    use crate::sensor::Sample;

    #[test]
    fn a_particle_takes_eight_bytes() {
        assert_eq!(core::mem::size_of::<ParticleSet<1000>>(), 8000);
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
            slot.draw(Point::new(x, y));
            let error = slot.position() - Point::new(x, y);
            assert!(error.x.abs() <= 0.5e-3 / 64.0 + 1e-8, "x = {x}");
            assert!(error.y.abs() <= 0.5e-3 / 64.0 + 1e-8, "y = {y}");
        }
    }

    #[test]
    fn places_beyond_the_format_stop_at_its_edge() {
        let mut set = ParticleSet::<1>::new();
        let mut slot = set.slots(1).next().unwrap();
        slot.draw(Point::new(9.0, f32::NEG_INFINITY));
        assert_eq!(slot.units(), (i16::MAX, i16::MIN));
    }

    #[test]
    fn digest_sees_every_stored_value_but_the_weight() {
        let mut set = ParticleSet::<2>::new();
        let empty = set.digest(2);
        set.slots(2).for_each(|mut slot| slot.set_weight(7, 1));
        assert_eq!(set.digest(2), empty);
        set.slots(2).last().unwrap().draw(Point::new(0.0, 0.0));
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
            6 => set.life[slot] ^= 1 << (bit % 8),
            _ => set.view[slot] ^= 1 << (bit % 8),
        }
    }

    #[test]
    fn f54_flipped_bits_never_bring_a_particle_where_none_may_be() {
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
                let outcomes = tally.past_gate + tally.below_gate + tally.free + tally.behind;
                assert_eq!(outcomes, tally.live, "step {step}");
                assert!(tally.live + tally.departed <= N as u32, "step {step}");
                // One that was just drawn may lie beyond: it departs in the next step.
                let farthest = filter
                    .live()
                    .filter(|(_, age)| *age > 0)
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
    fn age_stops_before_it_wraps() {
        let mut set = ParticleSet::<1>::new();
        let mut slot = set.slots(1).next().unwrap();
        slot.draw(Point::new(0.1, 0.0));
        let ages: Vec<u8> = (0..300).map(|_| slot.grow_older()).collect();
        assert_eq!(&ages[..3], &[1, 2, 3]);
        assert_eq!(ages[299], 255);
        assert!(slot.is_live());
    }
}
