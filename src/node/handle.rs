//! The node and its answer to each kind of input.

use super::{Config, Event, Input, InputError, NodeStatus, Scheduled, StepRule, StepScheduler};
use crate::filter::{InverseParticleFilter, Model, ParticleSet};
use crate::model::SENSORS;

/// The program of odometry, step trigger and filter, for up to N particles.
#[derive(Debug)]
pub struct Node<'a, const N: usize> {
    pub(super) config: Config,
    pub(super) model: Model,
    pub(super) filter: InverseParticleFilter<'a, N>,
    pub(super) scheduler: StepScheduler,
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
            scheduler: StepScheduler::default(),
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
    pub fn handle(
        &mut self,
        input: &Input,
        emit: &mut impl FnMut(&Event),
    ) -> Result<(), InputError> {
        let result = match *input {
            Input::Configure(config) => self.configure(&config, emit),
            Input::Limit {
                particles_per_sensor,
            } => self.limit(particles_per_sensor),
            Input::Odometry { .. }
            | Input::Wheels { .. }
            | Input::Proximity { .. }
            | Input::Tick { .. } => self.advance(input, emit),
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
    pub fn events_of(&mut self, input: &Input) -> Result<std::vec::Vec<Event>, InputError> {
        let mut events = std::vec::Vec::new();
        self.handle(input, &mut |event| events.push(event.clone()))?;
        Ok(events)
    }

    fn configure(
        &mut self,
        config: &Config,
        emit: &mut impl FnMut(&Event),
    ) -> Result<(), InputError> {
        config.validate().map_err(|_| InputError::BadParameter)?;
        if config.particles() > N {
            return Err(InputError::TooManyParticles);
        }
        self.config = *config;
        self.model = config.model();
        self.filter.restart(config.particles(), config.seed);
        self.scheduler = StepScheduler::default();
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

    /// Steps the filter if a step is due.
    ///
    /// A reset of the odometry removes the particles: the motion since their last step is
    /// unknown, so they cannot be propagated.
    fn advance(&mut self, input: &Input, emit: &mut impl FnMut(&Event)) -> Result<(), InputError> {
        let scheduled = self.scheduler.take(&self.config, input);
        self.status.without = self.scheduler.without().0;
        match scheduled? {
            Scheduled::Nothing => {}
            Scheduled::Step(step) => self.step(&step, emit),
            Scheduled::OdometryReset { stamp_us } => {
                self.filter.forget();
                emit(&Event::OdometryReset { stamp_us });
            }
        }
        Ok(())
    }

    fn limit(&mut self, particles_per_sensor: u16) -> Result<(), InputError> {
        if particles_per_sensor == 0 {
            return Err(InputError::BadParameter);
        }
        let sensors = self.config.sensors.len();
        self.filter
            .limit(usize::from(particles_per_sensor) * sensors);
        Ok(())
    }
}
