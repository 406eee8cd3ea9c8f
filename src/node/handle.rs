//! The node and its answer to each kind of input.

use super::odometry::{Continuity, Odometry};
use super::step::Sampled;
use super::{Config, Event, Fault, Input, NodeStatus, SampleWindow, StepRule, StepTrigger};
use crate::filter::{InverseParticleFilter, Model, ParticleSet};
use crate::geometry::Pose;
use crate::model::SENSORS;

/// The program of odometry, step trigger and filter, for up to N particles.
#[derive(Debug)]
pub struct Node<'a, const N: usize> {
    pub(super) config: Config,
    pub(super) model: Model,
    pub(super) filter: InverseParticleFilter<'a, N>,
    pub(super) odometry: Odometry,
    pub(super) trigger: StepTrigger,
    pub(super) samples: SampleWindow,
    pub(super) last_sampled: Option<Sampled>,
    pub(super) last_step: Option<Pose>,
    pub(super) status: NodeStatus,
}

impl<'a, const N: usize> Node<'a, N> {
    /// A node with the default configuration, limited to the capacity.
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
            trigger: StepTrigger::default(),
            samples: SampleWindow::default(),
            last_sampled: None,
            last_step: None,
            status: NodeStatus::default(),
        }
    }

    /// The configuration in force.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The state of the node.
    #[must_use]
    pub fn status(&self) -> &NodeStatus {
        &self.status
    }

    /// The filter, to read its particles.
    #[must_use]
    pub fn filter(&self) -> &InverseParticleFilter<'a, N> {
        &self.filter
    }

    /// Takes one input and emits the events that follow from it.
    ///
    /// At most one step per input.
    ///
    /// # Errors
    /// Why the input was refused. A refused input changes only the counters.
    pub fn handle(&mut self, input: &Input, emit: &mut impl FnMut(&Event)) -> Result<(), Fault> {
        let result = match *input {
            Input::Configure(config) => self.configure(&config, emit),
            Input::Odometry { stamp_us, pose } => {
                let continuity = self.odometry.take_pose(stamp_us, pose);
                self.on_odometry(stamp_us, continuity, emit)
            }
            Input::Wheels { stamp_us, speeds } => {
                let drive = &self.config.drive;
                let continuity = self.odometry.take_wheels(drive, stamp_us, speeds);
                self.on_odometry(stamp_us, continuity, emit)
            }
            Input::Proximity { stamp_us, samples } => self.on_proximity(stamp_us, samples, emit),
            Input::Tick { .. } => self.on_tick(emit),
            Input::Limit {
                particles_per_sensor,
            } => self.limit(particles_per_sensor),
        };
        self.status.inputs = self.status.inputs.wrapping_add(1);
        if let Err(fault) = result {
            self.status.refused = self.status.refused.wrapping_add(1);
            self.status.last_fault = Some(fault);
        }
        result
    }

    /// Takes one input and returns the events that follow from it.
    ///
    /// # Errors
    /// As [`handle`](Self::handle).
    #[cfg(all(feature = "std", not(target_os = "none")))]
    pub fn events_of(&mut self, input: &Input) -> Result<std::vec::Vec<Event>, Fault> {
        let mut events = std::vec::Vec::new();
        self.handle(input, &mut |event| events.push(event.clone()))?;
        Ok(events)
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
        self.restart_steps();
        self.samples = SampleWindow::default();
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

    /// Removes the particles when the odometry lost its origin: the motion since their
    /// last step is unknown, so they cannot be propagated.
    fn on_odometry(
        &mut self,
        stamp_us: u64,
        continuity: Result<Continuity, Fault>,
        emit: &mut impl FnMut(&Event),
    ) -> Result<(), Fault> {
        if continuity? == Continuity::Reset {
            self.filter.forget();
            self.restart_steps();
            emit(&Event::OdometryReset { stamp_us });
        }
        Ok(())
    }

    /// Treats the next reading as the first one.
    fn restart_steps(&mut self) {
        self.trigger = StepTrigger::default();
        self.last_sampled = None;
        self.last_step = None;
    }

    fn limit(&mut self, particles_per_sensor: u16) -> Result<(), Fault> {
        if particles_per_sensor == 0 {
            return Err(Fault::BadParameter);
        }
        let sensors = self.config.sensors.len();
        self.filter
            .limit(usize::from(particles_per_sensor) * sensors);
        Ok(())
    }
}
