//! One step of the filter: Algorithm 1, one line a stage.

use super::redraw::redraw;
use super::survive::Survival;
use super::{Model, Outcome, ParticleSet, Scan};
use crate::geometry::{Motion, Point};
use crate::kinematics::{InverseMotion, TravelNoise, WheelTravel};
use crate::random::{Generator, standard_normal_pair};
use crate::sensor::{Reading, SENSORS};

/// What a step did, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tally {
    /// Particles that were weighed; every one has exactly one outcome.
    pub live: u32,
    /// Outcomes "survived past the gate".
    pub past_gate: u32,
    /// Outcomes "survived below the gate".
    pub below_gate: u32,
    /// Outcomes "rejected, free".
    pub free: u32,
    /// Outcomes "rejected behind the arc or out of view".
    pub behind: u32,
    /// Particles that left the local radius: dead, no outcome.
    pub departed: u32,
    /// Sum of the weights, 65535 for 1. Zero with live particles is the degenerate
    /// set: nobody survives, everything is redrawn.
    pub weight_sum: u32,
    /// The particle past the gate that is nearest to the robot's centre, body frame.
    pub nearest: Option<Point>,
}

/// The inverse particle filter over a borrowed particle set.
///
/// The set is borrowed so that 64 kB can live wherever the owner has room: in a
/// `static` on the board, in a box on a host.
#[derive(Debug)]
pub struct InverseParticleFilter<'a, const N: usize> {
    particles: &'a mut ParticleSet<N>,
    active: usize,
    rng: Generator,
}

impl<'a, const N: usize> InverseParticleFilter<'a, N> {
    /// A filter over the first `active` slots of `particles`, all of them dead.
    ///
    /// The first step draws them. More slots than the set has mean all it has.
    pub fn new(particles: &'a mut ParticleSet<N>, active: usize, seed: u64) -> Self {
        particles.clear();
        Self {
            particles,
            active: active.min(N),
            rng: Generator::seeded(seed),
        }
    }

    /// Starts over with another number of slots and another seed.
    pub fn restart(&mut self, active: usize, seed: u64) {
        self.particles.clear();
        self.active = active.min(N);
        self.rng = Generator::seeded(seed);
    }

    /// The digest of the set, see [`ParticleSet::digest`].
    #[must_use]
    pub fn digest(&self) -> u32 {
        self.particles.digest(self.active)
    }

    /// Positions and ages of the live particles, in slot order.
    pub fn live(&self) -> impl Iterator<Item = (Point, u8)> {
        self.particles.live(self.active)
    }

    /// Moves, weighs, decides, counts and redraws every particle (Algorithm 1).
    ///
    /// `motion` is all the body did since the last step, turns in place included;
    /// `readings` are one per sensor. `report` gets the outcome of every live
    /// particle, in slot order, with its place after the motion in units of 1/64 mm
    /// in the body frame. A particle is not reported in the step that draws it.
    ///
    /// Never fails: a useless reading is left out, a set that nobody supports is
    /// redrawn ([`Tally::weight_sum`]). O(N): about 500 instructions a particle.
    pub fn step(
        &mut self,
        model: &Model,
        motion: &Motion,
        readings: &[Reading; SENSORS],
        mut report: impl FnMut((i16, i16), Outcome),
    ) -> Tally {
        let scan = Scan::new(model, readings);
        let departed = self.propagate(model, motion);
        let (live, weight_sum) = self.weigh(model, &scan);
        let parameters = &model.parameters;
        let mut survival = Survival::new(parameters.survival, weight_sum, live, &mut self.rng);
        let mut tally = Tally {
            live,
            departed,
            weight_sum,
            ..Tally::default()
        };
        for mut slot in self.particles.slots(self.active) {
            if slot.is_live() {
                let survives = survival.survives(slot.weight(), &mut self.rng);
                let outcome = if survives {
                    Outcome::of_survivor(parameters, slot.grow_older())
                } else {
                    Outcome::of_rejected(parameters, slot.view())
                };
                report(slot.units(), outcome);
                tally.count(outcome, slot.position());
                if survives {
                    continue;
                }
            }
            match redraw(model, &scan, &mut self.rng) {
                Some(place) => slot.draw(place),
                None => slot.kill(),
            }
        }
        tally
    }

    /// Line 2: k ~ p(k | k', u), the exact inverse motion plus the wheels' noise.
    ///
    /// Kills what leaves the local radius and returns how many that were.
    fn propagate(&mut self, model: &Model, motion: &Motion) -> u32 {
        let inverse = InverseMotion::of(motion);
        let travel = model.drive.travel_of_motion(motion);
        let share = model.parameters.wheel_noise;
        let sigma = WheelTravel {
            left_m: share * travel.left_m.abs(),
            right_m: share * travel.right_m.abs(),
        };
        let noise = TravelNoise::new(&model.drive, sigma);
        let radius = model.parameters.local_radius_m;
        let mut departed = 0;
        for mut slot in self.particles.slots(self.active) {
            if !slot.is_live() {
                continue;
            }
            let moved = inverse.apply(slot.position());
            let place = noise.displace(moved, standard_normal_pair(&mut self.rng));
            if place.norm_squared() > radius * radius {
                slot.kill();
                departed += 1;
            } else {
                slot.place(place);
            }
        }
        departed
    }

    /// Line 3: w = p(z | k); the number of live particles and the sum of their weights.
    ///
    /// The sum stays below 2^32 up to 65 537 particles, more than 16-bit storage of
    /// a capacity allows anywhere in this project.
    fn weigh(&mut self, model: &Model, scan: &Scan) -> (u32, u32) {
        let mut live = 0;
        let mut sum = 0_u32;
        for mut slot in self.particles.slots(self.active) {
            if !slot.is_live() {
                continue;
            }
            let view = scan.weigh(model, slot.position());
            slot.set_weight(view.packed_weight(), view.flags());
            live += 1;
            sum = sum.saturating_add(u32::from(slot.weight()));
        }
        (live, sum)
    }
}

impl Tally {
    #[inline]
    fn count(&mut self, outcome: Outcome, place: Point) {
        match outcome {
            Outcome::SurvivedPastGate => {
                self.past_gate += 1;
                let nearer = self
                    .nearest
                    .is_none_or(|nearest| place.norm_squared() < nearest.norm_squared());
                if nearer {
                    self.nearest = Some(place);
                }
            }
            Outcome::SurvivedBelowGate => self.below_gate += 1,
            Outcome::RejectedFree => self.free += 1,
            Outcome::RejectedBehind => self.behind += 1,
        }
    }

    /// Particles that survived the step.
    #[must_use]
    pub fn survived(&self) -> u32 {
        self.past_gate + self.below_gate
    }
}
