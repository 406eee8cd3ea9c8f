//! Whole comparisons: every method on the same drives, over scenarios and seeds.

use core::ops::Range;

use amiro_ipf::filter::Profile;
use amiro_ipf::node::{Config, Event};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use super::drive_scores::step_poses;
use super::{DriveScores, Method, Truth};
use crate::mapping::{FootprintMapper, hull_radius_m};
use crate::world::{Options, Scenario, Simulation, simulate_with};
use crate::{RunError, run};

/// What is to be compared on what.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// The methods.
    pub methods: Vec<Method>,
    /// Seeds of the sensors' noise and of the filters alike; the end is excluded.
    pub seeds: Range<u64>,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
    /// In what the drives differ from the filter's model.
    pub options: Options,
    /// Gain that filters and ISM believe in, counts m^2; `None` is the sensor's own.
    pub alpha_counts_m2: Option<f32>,
    /// Whether the robot's footprint is free in every method's map; not so in the paper.
    pub footprint: bool,
    /// Threads; 0 for one a processor. The results do not depend on it.
    pub threads: usize,
}

/// One method on one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The scenario's name.
    pub scenario: String,
    /// The method.
    pub method: Method,
    /// The drive's seed.
    pub seed: u64,
    /// How good the map was.
    pub scores: DriveScores,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// A filter did not run.
    #[error("{scenario}: {source}")]
    Run {
        /// The scenario's name.
        scenario: String,
        /// Why.
        source: RunError,
    },
    /// A filter refused readings of its own simulation: the maps would not compare.
    #[error("{scenario}, seed {seed}: {refused} inputs refused")]
    Refused {
        /// The scenario's name.
        scenario: String,
        /// The drive's seed.
        seed: u64,
        /// How many.
        refused: u64,
    },
    /// The system gave no threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl Comparison {
    /// Drives, maps and judges everything; by scenario, then seed, then method, each
    /// in the order given.
    ///
    /// The same trials, bit for bit, however many threads there are: a drive depends
    /// on its seed only, and none on another.
    ///
    /// # Errors
    /// The first of [`ComparisonError`] in this order.
    pub fn run(&self) -> Result<Vec<Trial>, ComparisonError> {
        let drives: Vec<(&Scenario, u64)> = self
            .scenarios
            .iter()
            .flat_map(|scenario| self.seeds.clone().map(move |seed| (scenario, seed)))
            .collect();
        let pool = ThreadPoolBuilder::new().num_threads(self.threads).build()?;
        let drives: Vec<_> = pool.install(|| {
            let trials = drives
                .par_iter()
                .map(|(scenario, seed)| self.drive(scenario, *seed));
            trials.collect()
        });
        let drives: Result<Vec<_>, _> = drives.into_iter().collect();
        Ok(drives?.into_iter().flatten().collect())
    }

    /// All methods on one drive: one simulation, one run of each profile.
    fn drive(&self, scenario: &Scenario, seed: u64) -> Result<Vec<Trial>, ComparisonError> {
        let simulation = simulate_with(scenario, seed, &self.options);
        let runs = self.profiles().into_iter().map(|(profile, particles)| {
            let mut config = Config {
                seed,
                particles_per_sensor: particles,
                ..scenario.config(profile)
            };
            if let Some(alpha) = self.alpha_counts_m2 {
                config.photometry.alpha_counts_m2 = alpha;
            }
            Run::of(profile, config, scenario, &simulation)
        });
        let runs: Vec<Run> = runs.collect::<Result<_, _>>()?;
        let poses = runs.first().map(|run| step_poses(&run.events));
        let truth = Truth::of(scenario, &poses.unwrap_or_default());
        let trial = |method: &Method| {
            let run = runs.iter().find(|run| run.serves(*method))?;
            let mut mapper = FootprintMapper::new(
                method.mapper(scenario, &run.config),
                scenario.cell_m,
                self.footprint.then(|| hull_radius_m(&run.config.ring)),
            );
            Some(Trial {
                scenario: scenario.name.clone(),
                method: *method,
                seed,
                scores: DriveScores::of(&mut mapper, &run.events, scenario, &truth),
            })
        };
        Ok(self.methods.iter().filter_map(trial).collect())
    }

    /// The profiles that the methods need, each once, with particles for each sensor.
    fn profiles(&self) -> Vec<(Profile, u16)> {
        let mut profiles = Vec::new();
        for profile in self.methods.iter().filter_map(|method| method.profile()) {
            if !profiles.contains(&(profile, self.particles_per_sensor)) {
                profiles.push((profile, self.particles_per_sensor));
            }
        }
        if profiles.is_empty() {
            // Only the readings at the steps are wanted: one particle will do.
            profiles.push((Profile::Paper, 1));
        }
        profiles
    }
}

/// One run of a filter through a drive.
struct Run {
    profile: Profile,
    config: Config,
    events: Vec<Event>,
}

impl Run {
    fn of(
        profile: Profile,
        config: Config,
        scenario: &Scenario,
        simulation: &Simulation,
    ) -> Result<Self, ComparisonError> {
        let mut events = Vec::new();
        let outcome = run(&config, &simulation.inputs, |event| {
            events.push(event.clone());
        });
        let outcome = outcome.map_err(|source| ComparisonError::Run {
            scenario: scenario.name.clone(),
            source,
        })?;
        match outcome.faults().map(|(_, count)| count).sum() {
            0 => Ok(Self {
                profile,
                config,
                events,
            }),
            refused => Err(ComparisonError::Refused {
                scenario: scenario.name.clone(),
                seed: config.seed,
                refused,
            }),
        }
    }

    /// Whether a method maps the events of this run; steps and readings are any run's.
    fn serves(&self, method: Method) -> bool {
        method
            .profile()
            .is_none_or(|profile| profile == self.profile)
    }
}
