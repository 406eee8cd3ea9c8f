//! Runs a node on the host over the inputs of a recording, as a board would.

use amiro_ipf::filter::{ParameterError, ParticleSet};
use amiro_ipf::node::{Config, Event, Input, InputError, Node};

/// Particles that fit: twice the paper's 1000 for each of eight sensors.
pub const CAPACITY: usize = 16_000;

/// The outcome of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunOutcome {
    /// Steps of the filter.
    pub steps: u32,
    /// Number of refused inputs, by error in the order of [`InputError::ALL`].
    pub refused: [u64; InputError::ALL.len()],
    /// Which inputs were refused and why: their numbers from 0, ascending. Empty for a run
    /// that is [streamed](run_streamed).
    pub refusals: Vec<(usize, InputError)>,
}

impl RunOutcome {
    /// The errors that occurred, with their counts.
    pub fn faults(&self) -> impl Iterator<Item = (InputError, u64)> {
        let counted = InputError::ALL.into_iter().zip(self.refused);
        counted.filter(|(_, count)| *count > 0)
    }

    /// Counts a refused input and keeps its number.
    pub(crate) fn refuse(&mut self, input: usize, fault: InputError) {
        self.count(fault);
        self.refusals.push((input, fault));
    }

    /// Counts a refused input.
    pub(crate) fn count(&mut self, fault: InputError) {
        let counters = InputError::ALL.into_iter().zip(&mut self.refused);
        for (_, counter) in counters.filter(|(word, _)| *word == fault) {
            *counter += 1;
        }
    }
}

/// Why a run did not begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The configuration has more particles than fit.
    #[error("{wanted} particles, at most {capacity} fit")]
    TooManyParticles {
        /// Particles of the configuration.
        wanted: usize,
        /// Particles that fit, on this host or on the board.
        capacity: usize,
    },
    /// The node refused the configuration for another reason.
    #[error("configuration refused: {0}")]
    Refused(InputError),
}

/// Whether the particles of a configuration fit into a set of so many.
///
/// # Errors
/// [`RunError::TooManyParticles`] with both numbers.
pub fn check_capacity(config: &Config, capacity: usize) -> Result<(), RunError> {
    let wanted = config.particles();
    if wanted > capacity {
        return Err(RunError::TooManyParticles { wanted, capacity });
    }
    Ok(())
}

/// Checks a configuration before the work that [`run`] would do with it.
///
/// # Errors
/// It is not legal or does not fit into [`CAPACITY`].
pub fn check(config: &Config) -> Result<(), RunError> {
    config.validate()?;
    check_capacity(config, CAPACITY)
}

/// Configures a node, gives it all inputs and passes on all events.
///
/// A refused input changes nothing but its counter; the run continues.
///
/// # Errors
/// The configuration is not legal or does not fit into [`CAPACITY`].
pub fn run(
    config: &Config,
    inputs: &[Input],
    on_event: impl FnMut(&Event),
) -> Result<RunOutcome, RunError> {
    let mut refusals = Vec::new();
    let inputs = inputs.iter().copied();
    let on_refusal = |input, fault| refusals.push((input, fault));
    let outcome = run_streamed(config, inputs, on_event, on_refusal)?;
    Ok(RunOutcome {
        refusals,
        ..outcome
    })
}

/// As [`run`], for inputs of any number: in bounded memory.
///
/// `on_refusal` gets the number of a refused input, from 0, and why it was refused.
///
/// # Errors
/// As [`run`].
pub fn run_streamed(
    config: &Config,
    inputs: impl IntoIterator<Item = Input>,
    mut on_event: impl FnMut(&Event),
    mut on_refusal: impl FnMut(usize, InputError),
) -> Result<RunOutcome, RunError> {
    check(config)?;
    let mut particles = Box::new(ParticleSet::<CAPACITY>::new());
    let mut node = Node::new(&mut particles);
    let mut outcome = RunOutcome::default();
    let mut steps = 0;
    let mut emit = |event: &Event| {
        steps += u32::from(matches!(event, Event::StepDone(_)));
        on_event(event);
    };
    node.handle(&Input::Configure(*config), &mut emit)
        .map_err(RunError::Refused)?;
    for (index, input) in inputs.into_iter().enumerate() {
        if let Err(fault) = node.handle(&input, &mut emit) {
            outcome.count(fault);
            on_refusal(index, fault);
        }
    }
    outcome.steps = steps;
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::filter::Profile;
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::{SENSORS, Sample};

    fn reading(stamp_us: u64) -> Input {
        Input::Proximity {
            stamp_us,
            samples: [Sample::Counts(0); SENSORS],
        }
    }

    #[test]
    fn refused_inputs_are_counted_by_their_fault() {
        let pose = Pose::default();
        let inputs = [
            reading(0),
            Input::Odometry { stamp_us: 10, pose },
            Input::Odometry { stamp_us: 5, pose },
            Input::Odometry { stamp_us: 6, pose },
            reading(10),
        ];
        let mut events = 0;
        let config = Config::amiro(Profile::Paper);
        let outcome = run(&config, &inputs, |_| events += 1).unwrap();
        assert_eq!(outcome.steps, 1);
        let faults: Vec<_> = outcome.faults().collect();
        assert_eq!(
            faults,
            [(InputError::StampBackward, 2), (InputError::NoPose, 1)]
        );
        // Configured, begun and done; an empty set has no outcomes in its first step.
        assert_eq!(events, 3);
    }

    #[test]
    fn illegal_configurations_are_refused_by_name() {
        let mut config = Config::amiro(Profile::Paper);
        config.particles_per_sensor = 2001;
        let error = run(&config, &[], |_| {}).unwrap_err();
        assert_eq!(error.to_string(), "16008 particles, at most 16000 fit");
        config.particles_per_sensor = 0;
        let error = run(&config, &[], |_| {}).unwrap_err();
        assert!(error.to_string().starts_with("particles_per_sensor"));
    }
}
