//! One step of the filter: Algorithm 1, line by line.

use super::propagate::InverseKinematics;
use super::resample::Resampler;
use super::tally::Tally;
use super::wall_scan::WallScan;
use super::{
    Model, Outcome, ParticleSet, Scan, SegmentModel, SegmentParameters, SegmentTracker,
    TrackedSegment,
};
use crate::checksum::Digest;
use crate::geometry::{Motion, Point};
use crate::model::{Reading, SENSORS, Sample};
use crate::random::Generator;

/// The inverse particle filter over a borrowed particle set.
///
/// The owner decides where the 64 kB of the set are stored: in a `static` on the
/// board, in a box on a host.
#[derive(Debug)]
pub struct InverseParticleFilter<'a, const N: usize> {
    particles: &'a mut ParticleSet<N>,
    active: usize,
    rng: Generator,
}

impl<'a, const N: usize> InverseParticleFilter<'a, N> {
    /// A filter over the first `active` slots of `particles`, all of them empty.
    ///
    /// The first step draws the particles. An `active` above N means N.
    pub fn new(particles: &'a mut ParticleSet<N>, active: usize, seed: u64) -> Self {
        particles.clear();
        particles.segment_model = None;
        Self {
            particles,
            active: active.min(N),
            rng: Generator::seeded(seed),
        }
    }

    /// A filter that continues with the particles that the set has.
    #[cfg(test)]
    pub(super) fn over(particles: &'a mut ParticleSet<N>, active: usize, seed: u64) -> Self {
        Self {
            particles,
            active: active.min(N),
            rng: Generator::seeded(seed),
        }
    }

    /// Clears the set and starts again with `active` slots and a seed.
    pub fn restart(&mut self, active: usize, seed: u64) {
        self.particles.clear();
        self.active = active.min(N);
        self.rng = Generator::seeded(seed);
        self.particles.segment_model = None;
    }

    /// Lowers the number of active slots; a higher number changes nothing.
    pub fn limit(&mut self, active: usize) {
        self.active = active.min(self.active);
    }

    /// Removes every particle; the next step draws new ones. The generator continues.
    pub fn forget(&mut self) {
        self.particles.clear();
    }

    /// The digest of the set, see [`ParticleSet::digest`], with the wall segments if
    /// there are any.
    #[must_use]
    pub fn digest(&self) -> u32 {
        let particles = self.particles.digest(self.active);
        if self.particles.tracker.is_idle() {
            return particles;
        }
        let mut digest = Digest::default();
        digest.update(particles);
        self.particles.tracker.update(&mut digest);
        digest.value()
    }

    /// The wall segments; none but in the profile `wall`.
    #[must_use]
    pub fn segments(&self) -> &[TrackedSegment] {
        self.particles.tracker.segments()
    }

    /// The tracker of the wall segments; it does nothing but in the profile `wall`.
    #[must_use]
    pub fn tracker(&self) -> &SegmentTracker {
        &self.particles.tracker
    }

    /// Fits the wall segments to the samples of a step; to be called before
    /// [`step_on_walls`](Self::step_on_walls). Nothing happens with the model of another
    /// profile. `retired` receives the segments that are left behind, as in
    /// [`SegmentTracker::step`].
    ///
    /// Apart from the step, so that the stack holds the fit or the scan, not both.
    #[inline(never)]
    pub fn track(
        &mut self,
        model: &Model,
        motion: &Motion,
        samples: &[Sample; SENSORS],
        retired: &mut impl FnMut(&TrackedSegment),
    ) {
        if let Some(parameters) = model.walls.and_then(|walls| walls.segments) {
            let ParticleSet {
                tracker,
                segment_model,
                ..
            } = &mut *self.particles;
            if segment_model.is_none() {
                prepare(segment_model, parameters, model);
            }
            let Some(segments) = segment_model else {
                return;
            };
            tracker.step(segments, motion, samples, retired);
        }
    }

    /// Positions and epochs of the live particles, in slot order.
    pub fn live(&self) -> impl Iterator<Item = (Point, u8)> {
        self.particles.live(self.active)
    }

    /// Propagates, weighs, resamples, counts and redraws the particles (Algorithm 1).
    ///
    /// `motion` is the whole motion of the body since the last step, turns in place
    /// included; `readings` has one reading per sensor. `report` receives the outcome
    /// of every live particle, in slot order, with its position after the motion in
    /// units of 1/64 mm in the body frame. A particle is not reported in the step that
    /// draws it.
    ///
    /// Weighing uses the position before it is rounded to the set's units. A particle
    /// outside the local radius is removed and has no outcome.
    ///
    /// The step does not fail: an unusable reading has no beam, and a set without any
    /// weight is redrawn ([`Tally::weight_sum`]). O(N): about 500 instructions per
    /// particle.
    pub fn step(
        &mut self,
        model: &Model,
        motion: &Motion,
        readings: &[Reading; SENSORS],
        mut report: impl FnMut((i16, i16), Outcome),
    ) -> Tally {
        let scan = Scan::new(model, readings);
        let kinematics = InverseKinematics::new(model, motion);
        let mut tally = Tally::default();
        for mut particle in self.particles.live_slots(self.active) {
            let position = kinematics.sample(particle.position(), &mut self.rng); // 2: k ~ p(k | k', u)
            if model.is_outside(position) {
                particle.clear();
                tally.departed += 1;
                continue;
            }
            particle.place(position);
            particle.set_evaluation(&scan.weigh(model, position)); // 3: w = p(z | k)
            tally.add_weight(particle.weight()); // 4
        }
        let mut resampler = Resampler::new(&model.parameters, &tally, &mut self.rng); // 5 to 7
        for mut particle in self.particles.slots(self.active) {
            if particle.is_live() {
                let outcome = resampler.resample(&mut particle, 1, &mut self.rng); // 9, 10
                tally.count(outcome, particle.position()); // equation 3
                report(particle.units(), outcome);
            }
            if !particle.is_live() {
                particle.redraw(model, &scan, &mut self.rng); // Algorithm 2
            }
        }
        tally
    }

    /// The step of the profiles `wall` and `arcs`: as [`step`](Self::step) with weights and
    /// draws by upper bounds, against wall segments if there are any, a gate in travel, and a
    /// nearly normal wheel noise.
    ///
    /// Nothing happens with the model of another profile. A function of its own: the
    /// other profiles keep their code and its speed.
    #[inline(never)]
    pub fn step_on_walls(
        &mut self,
        model: &Model,
        motion: &Motion,
        readings: &[Reading; SENSORS],
        report: &mut impl FnMut((i16, i16), Outcome),
    ) -> Tally {
        let mut tally = Tally::default();
        let scan = Scan::new(model, readings);
        let Some(scan) = WallScan::new(model, self.particles, scan) else {
            return tally;
        };
        let kinematics = InverseKinematics::new(model, motion);
        for mut particle in self.particles.live_slots(self.active) {
            let position = kinematics.sample_nearly(particle.position(), &mut self.rng);
            if model.is_outside(position) {
                particle.clear();
                tally.departed += 1;
                continue;
            }
            particle.place(position);
            particle.set_evaluation(&scan.weigh(position));
            tally.add_weight(particle.weight());
        }
        let mut resampler = Resampler::new(&model.parameters, &tally, &mut self.rng);
        let epochs = scan.epochs(motion.displacement.norm());
        for mut particle in self.particles.slots(self.active) {
            if particle.is_live() {
                let outcome = resampler.resample(&mut particle, epochs, &mut self.rng);
                tally.count(outcome, particle.position());
                report(particle.units(), outcome);
            }
            if !particle.is_live()
                && let Some(position) = scan.draw(&mut self.rng)
            {
                particle.fill(position);
            }
        }
        tally
    }
}

/// Makes what the tracker needs, apart from the step: it takes 3 kB of stack.
#[inline(never)]
fn prepare(segments: &mut Option<SegmentModel>, parameters: SegmentParameters, model: &Model) {
    let made = SegmentModel::of_mounts(parameters, &model.photometry, &model.mounts);
    *segments = Some(made);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{FilterParameters, Profile};
    use crate::geometry::{Angle, Pose};
    use crate::model::{DifferentialDrive, Photometry, Ring};

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
    fn first_step_draws_all_particles_and_counts_none() {
        for profile in [Profile::Paper, Profile::Plus] {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, 1);
            let model = model(profile.parameters());
            let mut reported = 0;
            let tally = filter.step(&model, &Motion::NONE, &readings(78), |_, _| reported += 1);
            assert_eq!((reported, tally), (0, Tally::default()), "{profile:?}");
            assert_eq!(filter.live().count(), N);
            assert!(filter.live().all(|(_, epoch)| epoch == 0));
        }
    }

    #[test]
    fn every_live_particle_has_one_outcome_and_only_survivors_advance_an_epoch() {
        for profile in [Profile::Paper, Profile::Plus] {
            let mut set = ParticleSet::<N>::new();
            let mut filter = InverseParticleFilter::new(&mut set, N, 2);
            let model = model(profile.parameters());
            filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
            let mut reported = 0;
            let tally = filter.step(&model, &forward(0.01), &readings(78), |_, _| reported += 1);
            let outcomes = tally.past_gate + tally.below_gate + tally.free + tally.unobserved;
            assert_eq!(
                (outcomes, reported),
                (tally.live, tally.live),
                "{profile:?}"
            );
            assert_eq!(tally.live + tally.departed, N as u32, "{profile:?}");
            let aged = filter.live().filter(|(_, epoch)| *epoch == 1).count();
            let young = filter.live().filter(|(_, epoch)| *epoch == 0).count();
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
            assert!(filter.live().all(|(_, epoch)| epoch == 0));
        }
    }

    #[test]
    fn without_a_usable_sensor_the_set_empties_and_refills_with_the_sensors() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 5);
        let model = model(FilterParameters::PLUS);
        filter.step(&model, &Motion::NONE, &readings(78), |_, _| {});
        let dead = [Reading::Faulty; SENSORS];
        let tally = filter.step(&model, &forward(0.01), &dead, |_, _| {});
        assert_eq!((tally.unobserved, tally.free), (tally.live, 0));
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
                .for_each(|mut slot| slot.fill(Point::new(x, 0.0)));
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
    fn cleared_particles_are_drawn_anew_and_the_generator_goes_on() {
        let mut set = ParticleSet::<N>::new();
        let mut filter = InverseParticleFilter::new(&mut set, N, 11);
        let first = after_three_steps(&mut filter);
        filter.forget();
        assert_eq!(filter.live().count(), 0);
        let model = model(FilterParameters::PLUS);
        let tally = filter.step(&model, &Motion::NONE, &readings(60), |_, _| {});
        assert_eq!(tally, Tally::default());
        assert!(filter.live().all(|(_, epoch)| epoch == 0));
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
                seen[0] =
                    Reading::Range(law.range_estimate(law.counts(0.10, 0.0).unwrap()).unwrap());
                filter.step(&model, &Motion::NONE, &seen, |_, _| {});
                seen[0] =
                    Reading::Range(law.range_estimate(law.counts(0.09, 0.0).unwrap()).unwrap());
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
