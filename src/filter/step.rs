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

    /// A filter that goes on with whatever is in the set.
    #[cfg(test)]
    pub(super) fn over(particles: &'a mut ParticleSet<N>, active: usize, seed: u64) -> Self {
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

    /// Goes on with the first `active` slots, if that is fewer; the others die.
    pub fn limit(&mut self, active: usize) {
        self.active = active.min(self.active);
    }

    /// Forgets every particle; the next step draws them anew. The generator goes on.
    pub fn forget(&mut self) {
        self.particles.clear();
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
        let mut tally = self.propagate_and_weigh(model, motion, &scan);
        let parameters = &model.parameters;
        let (live, weight_sum) = (tally.live, tally.weight_sum);
        let mut survival = Survival::new(parameters.survival, weight_sum, live, &mut self.rng);
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

    /// Lines 1 to 4: k ~ p(k | k', u), the exact inverse motion plus the wheels' noise,
    /// and w = p(z | k) at the new place.
    ///
    /// Kills what leaves the local radius. Returns how many departed, how many live,
    /// and the sum of their weights, which stays below 2^32 up to 65 537 particles.
    fn propagate_and_weigh(&mut self, model: &Model, motion: &Motion, scan: &Scan) -> Tally {
        let inverse = InverseMotion::of(motion);
        let travel = model.drive.travel_of_motion(motion);
        let share = model.parameters.wheel_noise;
        let sigma = WheelTravel {
            left_m: share * travel.left_m.abs(),
            right_m: share * travel.right_m.abs(),
        };
        let noise = TravelNoise::new(&model.drive, sigma);
        let radius = model.parameters.local_radius_m;
        let mut tally = Tally::default();
        for mut slot in self.particles.slots(self.active) {
            if !slot.is_live() {
                continue;
            }
            let moved = inverse.apply(slot.position());
            let place = noise.displace(moved, standard_normal_pair(&mut self.rng));
            if place.norm_squared() > radius * radius {
                slot.kill();
                tally.departed += 1;
                continue;
            }
            slot.place(place);
            let view = scan.weigh(model, place);
            slot.set_weight(view.packed_weight(), view.flags());
            tally.live += 1;
            tally.weight_sum = tally.weight_sum.saturating_add(u32::from(slot.weight()));
        }
        tally
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{FilterParameters, Profile};
    use crate::geometry::{Angle, Pose};
    use crate::kinematics::DifferentialDrive;
    use crate::sensor::{Photometry, Ring, Sample};

    const N: usize = 800;

    fn model(parameters: FilterParameters) -> Model {
        Model::new(
            parameters,
            Photometry::VCNL4020,
            &Ring::AMIRO,
            DifferentialDrive::AMIRO,
        )
    }

    fn readings(counts: i32) -> [Reading; SENSORS] {
        [Photometry::VCNL4020.read(Sample::Counts(counts)); SENSORS]
    }

    fn forward(metres: f32) -> Motion {
        Motion {
            displacement: Point::new(metres, 0.0),
            turn: Angle::default(),
        }
    }

    #[test]
    fn first_step_draws_everybody_and_counts_nobody() {
        for profile in [Profile::Paper, Profile::Plus] {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, 1);
            let model = model(profile.parameters());
            let mut reported = 0;
            let tally = filter.step(&model, &Motion::NONE, &readings(78), |_, _| reported += 1);
            assert_eq!((reported, tally), (0, Tally::default()), "{profile:?}");
            assert_eq!(filter.live().count(), N);
            assert!(filter.live().all(|(_, age)| age == 0));
        }
    }

    #[test]
    fn every_live_particle_has_one_outcome_and_only_survivors_age() {
        for profile in [Profile::Paper, Profile::Plus] {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, 2);
            let model = model(profile.parameters());
            filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
            let mut reported = 0;
            let tally = filter.step(&model, &forward(0.01), &readings(78), |_, _| reported += 1);
            let outcomes = tally.past_gate + tally.below_gate + tally.free + tally.behind;
            assert_eq!(
                (outcomes, reported),
                (tally.live, tally.live),
                "{profile:?}"
            );
            assert_eq!(tally.live + tally.departed, N as u32, "{profile:?}");
            let aged = filter.live().filter(|(_, age)| *age == 1).count();
            let young = filter.live().filter(|(_, age)| *age == 0).count();
            assert_eq!(aged as u32, tally.survived(), "{profile:?}");
            assert_eq!(aged + young, N, "{profile:?}");
        }
    }

    #[test]
    fn without_motion_and_noise_survivors_pass_the_gate_at_the_g_th_step() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 3);
        let model = model(FilterParameters::PAPER);
        for step in 0..=4 {
            let tally = filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
            assert_eq!(tally.past_gate > 0, step == 4, "step {step}");
        }
    }

    #[test]
    fn f52_an_empty_room_has_no_surface_and_its_degenerate_set_is_redrawn() {
        for profile in [Profile::Paper, Profile::Plus] {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, 4);
            let model = model(profile.parameters());
            filter.step(&model, &Motion::NONE, &readings(0), |_, _| {});
            for _ in 0..20 {
                let tally = filter.step(&model, &forward(0.01), &readings(0), |_, _| {});
                assert_eq!((tally.survived(), tally.weight_sum), (0, 0), "{profile:?}");
                assert!(tally.free > 0, "{profile:?}");
            }
            assert!(filter.live().all(|(_, age)| age == 0));
        }
    }

    #[test]
    fn without_a_usable_sensor_the_set_dies_and_returns_with_the_sensors() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 5);
        let model = model(FilterParameters::PLUS);
        filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
        let dead = [Reading::Faulty; SENSORS];
        let tally = filter.step(&model, &forward(0.01), &dead, |_, _| {});
        assert_eq!((tally.behind, tally.free), (tally.live, 0));
        assert_eq!(filter.live().count(), 0);
        let tally = filter.step(&model, &forward(0.01), &dead, |_, _| {});
        assert_eq!(tally, Tally::default());
        filter.step(&model, &forward(0.01), &readings(78), |_, _| {});
        assert_eq!(filter.live().count(), N);
    }

    #[test]
    fn particles_beyond_the_local_radius_depart_without_an_outcome() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 6);
        let model = model(FilterParameters::PAPER);
        filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
        let tally = filter.step(&model, &forward(1.0), &readings(78), |_, _| {});
        assert_eq!((tally.live, tally.departed), (0, N as u32));
        assert_eq!(filter.live().count(), N, "redrawn at once");
    }

    #[test]
    fn exactly_those_beyond_the_local_radius_depart() {
        let radius = 0.2;
        let model = model(FilterParameters {
            local_radius_m: radius,
            ..FilterParameters::PLUS
        });
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 6);
        // Empty lobes are searched up to 0.2 m in front of the hull.
        filter.step(&model, &Motion::NONE, &readings(0), |_, _| {});
        let beyond = filter
            .live()
            .filter(|(place, _)| place.norm_squared() > radius * radius)
            .count();
        assert!((10..N - 10).contains(&beyond), "{beyond}");
        let tally = filter.step(&model, &Motion::NONE, &readings(0), |_, _| {});
        assert_eq!(tally.departed, beyond as u32);
        assert_eq!(tally.live, (N - beyond) as u32);
    }

    #[test]
    fn a_particle_on_the_local_radius_is_within_it() {
        let mut set = ParticleSet::<1>::new();
        let model = model(FilterParameters {
            local_radius_m: 0.5,
            ..FilterParameters::PAPER
        });
        for (x, departed) in [(0.5, 0), (0.500_02, 1)] {
            set.slots(1)
                .for_each(|mut slot| slot.draw(Point::new(x, 0.0)));
            let mut filter = InverseParticleFilter::over(&mut set, 1, 1);
            let tally = filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
            assert_eq!(tally.departed, departed, "{x} m");
        }
    }

    /// The digest after three steps.
    fn after_three_steps(filter: &mut InverseParticleFilter<'_, N>) -> u32 {
        let model = model(FilterParameters::PLUS);
        for _ in 0..3 {
            filter.step(&model, &forward(0.01), &readings(60), |_, _| {});
        }
        filter.digest()
    }

    #[test]
    fn nothing_is_left_of_a_set_s_last_use_or_of_a_filter_s_last_run() {
        let mut set = ParticleSet::<N>::new();
        let fresh = after_three_steps(&mut InverseParticleFilter::new(&mut set, 300, 11));
        after_three_steps(&mut InverseParticleFilter::new(&mut set, N, 12));
        let mut filter = InverseParticleFilter::new(&mut set, 300, 11);
        assert_eq!(filter.live().count(), 0, "a used set");
        assert_eq!(after_three_steps(&mut filter), fresh, "a used set");
        filter.restart(300, 11);
        assert_eq!(filter.live().count(), 0, "a used filter");
        assert_eq!(after_three_steps(&mut filter), fresh, "a used filter");
    }

    #[test]
    fn forgotten_particles_are_drawn_anew_and_the_generator_goes_on() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 11);
        let first = after_three_steps(&mut filter);
        filter.forget();
        assert_eq!(filter.live().count(), 0);
        let model = model(FilterParameters::PLUS);
        let tally = filter.step(&model, &Motion::NONE, &readings(60), |_, _| {});
        assert_eq!(tally, Tally::default());
        assert!(filter.live().all(|(_, age)| age == 0));
        assert_eq!(filter.live().count(), N);
        filter.forget();
        assert_ne!(after_three_steps(&mut filter), first);
    }

    #[test]
    fn a_limit_lowers_the_number_of_particles_and_never_raises_it() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 11);
        after_three_steps(&mut filter);
        for (limit, left) in [(300, 300), (500, 300), (0, 0)] {
            filter.limit(limit);
            assert_eq!(filter.live().count(), left, "limit {limit}");
            after_three_steps(&mut filter);
            assert_eq!(filter.live().count(), left, "limit {limit}");
        }
    }

    #[test]
    fn moved_particles_stay_put_in_the_world() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 7);
        let model = model(FilterParameters {
            wheel_noise: 0.0,
            ..FilterParameters::PAPER
        });
        filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
        let before: Vec<Point> = filter.live().map(|(place, _)| place).collect();
        let motion = Motion {
            displacement: Point::new(0.009, 0.002),
            turn: Angle::from_radians(0.4),
        };
        let pose = Pose::default().moved(&motion);
        let mut after = Vec::new();
        filter.step(&model, &motion, &readings(78), |(x, y), _| {
            after.push(Point::new(f32::from(x) / 64_000.0, f32::from(y) / 64_000.0));
        });
        for (old, new) in before.iter().zip(&after) {
            let error = (pose.world_from_body(*new) - *old).norm();
            assert!(error < 2e-5, "{old:?} went to {new:?}");
        }
    }

    #[test]
    fn figure_four_s_share_survives_the_paper_s_first_step() {
        // An object 100 mm ahead of a front sensor, one step of 10 mm towards it: about
        // 80 % survive. The independent prototype found 82 % (systematic) and 74 %
        // (Bernoulli, without veto); 4000 particles, 4 sigma are 2.5 %.
        let law = Photometry::VCNL4020;
        let ring = Ring {
            axis_rad: [0.0; SENSORS],
            ..Ring::AMIRO
        };
        for (profile, share) in [(Profile::Paper, 0.82), (Profile::Plus, 0.74)] {
            let parameters = FilterParameters {
                veto: 1.0,
                ..profile.parameters()
            };
            let model = Model::new(parameters, law, &ring, DifferentialDrive::AMIRO);
            for seed in 1..=3 {
                let mut set = ParticleSet::<4000>::new();
                let mut filter = InverseParticleFilter::new(&mut set, 4000, seed);
                let mut seen = [Reading::Faulty; SENSORS];
                seen[0] = Reading::Range(law.echo(law.counts(0.10, 0.0).unwrap()).unwrap());
                filter.step(&model, &Motion::NONE, &seen, |_, _| {});
                seen[0] = Reading::Range(law.echo(law.counts(0.09, 0.0).unwrap()).unwrap());
                let tally = filter.step(&model, &forward(0.01), &seen, |_, _| {});
                let survived = tally.survived() as f32 / 4000.0;
                assert!(
                    (survived - share).abs() < 0.03,
                    "{profile:?}, seed {seed}: {survived}"
                );
            }
        }
    }

    #[test]
    fn equal_seeds_give_equal_sets_and_others_do_not() {
        let digest = |seed| {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, seed);
            let model = model(FilterParameters::PLUS);
            for _ in 0..5 {
                filter.step(&model, &forward(0.01), &readings(60), |_, _| {});
            }
            filter.digest()
        };
        assert_eq!(digest(8), digest(8));
        assert_ne!(digest(8), digest(9));
    }

    #[test]
    fn nearest_surface_is_the_nearest_particle_past_the_gate() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 10);
        let model = model(FilterParameters::PLUS);
        let mut nearest: Option<f32> = None;
        for _ in 0..10 {
            let mut closest = f32::INFINITY;
            let tally = filter.step(&model, &Motion::NONE, &readings(78), |(x, y), outcome| {
                if outcome == Outcome::SurvivedPastGate {
                    let place = Point::new(f32::from(x) / 64_000.0, f32::from(y) / 64_000.0);
                    closest = closest.min(place.norm());
                }
            });
            nearest = tally.nearest.map(Point::norm);
            if let Some(nearest) = nearest {
                assert!((nearest - closest).abs() < 1e-6);
            }
        }
        assert!(nearest.is_some(), "a standing wall passes the gate");
    }
}
