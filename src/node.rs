//! The whole portable program: inputs in, events out.
//!
//! The node owns the loop: a host, the flash image and a replay differ only in where
//! inputs come from and where events go. It reads no clock and no pin; time comes in
//! with the inputs.

use crate::config::{Config, StepRule};
use crate::event::{Event, NodeStatus, Obstacle, ParticleEvent, Particles, StepBegun, StepDone};
use crate::fault::Fault;
use crate::filter::{InverseParticleFilter, Model, Outcome, ParticleSet, Tally};
use crate::geometry::Pose;
use crate::input::Input;
use crate::math;
use crate::odometry::Odometry;
use crate::pacing::Pacer;
use crate::sensor::{SENSORS, Sample, SensorMask};

/// The program: odometry, pace and filter, for up to N particles.
#[derive(Debug)]
pub struct Node<'a, const N: usize> {
    config: Config,
    model: Model,
    filter: InverseParticleFilter<'a, N>,
    odometry: Odometry,
    pacer: Pacer,
    sampled: Option<Sampled>,
    last_step: Option<Pose>,
    status: NodeStatus,
}

/// The newest readings and where they were taken.
#[derive(Clone, Copy, Debug)]
struct Sampled {
    stamp_us: u64,
    pose: Pose,
    samples: [Sample; SENSORS],
}

impl<'a, const N: usize> Node<'a, N> {
    /// A node with the default configuration, cut to the capacity.
    pub fn new(particles: &'a mut ParticleSet<N>) -> Self {
        let mut config = Config::default();
        if config.particles() > N {
            config.particles_per_sensor = (N / SENSORS) as u16;
        }
        Self {
            config,
            model: config.model(),
            filter: InverseParticleFilter::new(particles, config.particles(), config.seed),
            odometry: Odometry::default(),
            pacer: Pacer::default(),
            sampled: None,
            last_step: None,
            status: NodeStatus::default(),
        }
    }

    /// The configuration in force.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// How the node is.
    #[must_use]
    pub fn status(&self) -> &NodeStatus {
        &self.status
    }

    /// The filter, for looking at its particles.
    #[must_use]
    pub fn filter(&self) -> &InverseParticleFilter<'a, N> {
        &self.filter
    }

    /// Takes one input and emits the events that follow from it.
    ///
    /// At most one step an input. [`Input::Hello`] is the link's to answer and does
    /// nothing here.
    ///
    /// # Errors
    /// Why the input was refused; nothing has changed then but the counters.
    pub fn handle(&mut self, input: &Input, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        let handled = match *input {
            Input::Hello => Ok(()),
            Input::Configure(config) => self.configure(&config, emit),
            Input::Odometry { stamp_us, pose } => self.odometry.take_pose(stamp_us, pose),
            Input::Wheels { stamp_us, speeds } => {
                self.odometry
                    .take_wheels(&self.config.drive, stamp_us, speeds)
            }
            Input::Proximity { stamp_us, samples } => self.sample(stamp_us, samples, emit),
            Input::Tick { .. } => self.tick(emit),
        };
        self.status.inputs = self.status.inputs.wrapping_add(1);
        if let Err(fault) = handled {
            self.status.refused = self.status.refused.wrapping_add(1);
            self.status.last_fault = Some(fault);
        }
        handled
    }

    fn configure(&mut self, config: &Config, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        config.validate().map_err(|_| Fault::BadParameter)?;
        if config.particles() > N {
            return Err(Fault::TooManyParticles);
        }
        self.config = *config;
        self.model = config.model();
        self.filter.restart(config.particles(), config.seed);
        self.odometry = Odometry::default();
        self.pacer = Pacer::default();
        self.sampled = None;
        self.last_step = None;
        self.status = NodeStatus {
            inputs: self.status.inputs,
            refused: self.status.refused,
            last_fault: self.status.last_fault,
            own_ticks: config.step_rule == StepRule::PerTick { own_clock: true },
            ..NodeStatus::default()
        };
        emit(&Event::Configured(*config));
        Ok(())
    }

    /// Readings: find where they were taken, step if enough way lies behind.
    fn sample(
        &mut self,
        stamp_us: u64,
        samples: [Sample; SENSORS],
        emit: &mut impl FnMut(&Event),
    ) -> Result<(), Fault> {
        if self
            .sampled
            .is_some_and(|before| stamp_us < before.stamp_us)
        {
            return Err(Fault::StampBackward);
        }
        let pose = self.odometry.pose_at(&self.config.drive, stamp_us)?;
        let travel_m = self
            .sampled
            .map(|before| before.pose.motion_to(&pose).travel());
        let sampled = Sampled {
            stamp_us,
            pose,
            samples,
        };
        self.sampled = Some(sampled);
        if self.is_step_due(travel_m) {
            self.step(&sampled, emit);
        }
        Ok(())
    }

    /// The sample-per-speed rule: a step at the first reading, then one per distance.
    fn is_step_due(&mut self, travel_m: Option<f32>) -> bool {
        match (self.config.step_rule, travel_m) {
            (StepRule::PerTick { .. }, _) => false,
            (StepRule::PerDistance { .. }, None) => true,
            (StepRule::PerDistance { step_m }, Some(travel_m)) => {
                self.pacer.advance(travel_m, step_m)
            }
        }
    }

    fn tick(&mut self, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        let sampled = self.sampled.ok_or(Fault::NoReading)?;
        if let StepRule::PerTick { .. } = self.config.step_rule {
            self.step(&sampled, emit);
        }
        Ok(())
    }

    /// One step of the filter, and everything that is said about it.
    fn step(&mut self, sampled: &Sampled, emit: &mut impl FnMut(&Event)) {
        let index = self.status.steps;
        let motion = self
            .last_step
            .map(|before| before.motion_to(&sampled.pose))
            .unwrap_or_default();
        let samples = self.masked(&sampled.samples);
        let readings = samples.map(|sample| self.model.photometry().read(sample));
        emit(&Event::StepBegun(StepBegun {
            index,
            stamp_us: sampled.stamp_us,
            pose: sampled.pose,
            samples,
        }));
        let mut batch = Batch::new(index, emit);
        let tally = self
            .filter
            .step(&self.model, &motion, &readings, |place, outcome| {
                batch.push(place, outcome);
            });
        batch.flush();
        emit(&Event::StepDone(step_done(
            index,
            self.filter.digest(),
            &tally,
        )));
        self.last_step = Some(sampled.pose);
        self.status.steps = index.wrapping_add(1);
        self.status.obstacle = tally.nearest.map(|place| Obstacle {
            range_m: place.norm(),
            bearing_rad: math::coarse_atan2(place.y, place.x),
        });
        self.status.without = (0..SENSORS)
            .zip(&samples)
            .filter(|(_, sample)| !matches!(sample, Sample::Counts(_)))
            .fold(SensorMask::NONE, |mask, (sensor, _)| mask.with(sensor))
            .0;
    }

    /// The samples with those of the sensors that are not in use taken out.
    fn masked(&self, samples: &[Sample; SENSORS]) -> [Sample; SENSORS] {
        let mut masked = *samples;
        for (sensor, sample) in masked.iter_mut().enumerate() {
            if !self.config.sensors.contains(sensor) {
                *sample = Sample::Missing;
            }
        }
        masked
    }
}

fn step_done(index: u32, digest: u32, tally: &Tally) -> StepDone {
    let count = |count: u32| u16::try_from(count).unwrap_or(u16::MAX);
    StepDone {
        index,
        digest,
        past_gate: count(tally.past_gate),
        below_gate: count(tally.below_gate),
        free: count(tally.free),
        behind: count(tally.behind),
        departed: count(tally.departed),
        degenerate: tally.live > 0 && tally.weight_sum == 0,
    }
}

/// Collects particle events and emits them by the frame.
struct Batch<'e, E: FnMut(&Event)> {
    event: Event,
    emit: &'e mut E,
}

impl<'e, E: FnMut(&Event)> Batch<'e, E> {
    fn new(index: u32, emit: &'e mut E) -> Self {
        let [step, ..] = index.to_le_bytes();
        let particles = Particles {
            step,
            outcomes: heapless::Vec::new(),
        };
        Self {
            event: Event::Particles(particles),
            emit,
        }
    }

    #[inline]
    fn push(&mut self, place: (i16, i16), outcome: Outcome) {
        let Event::Particles(particles) = &mut self.event else {
            return;
        };
        // Flushed as soon as it is full: the push cannot be refused.
        let _ = particles.outcomes.push(ParticleEvent::new(place, outcome));
        if particles.outcomes.is_full() {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let Event::Particles(particles) = &self.event else {
            return;
        };
        if particles.outcomes.is_empty() {
            return;
        }
        (self.emit)(&self.event);
        if let Event::Particles(particles) = &mut self.event {
            particles.outcomes.clear();
        }
    }
}
