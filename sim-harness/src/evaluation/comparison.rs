//! Whole comparisons: every method on the same drives, over scenarios and seeds.

use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use super::{DriveJudge, DriveScores, Truth};
use crate::drive::{Record, RingCalibration};
use crate::mapping::{Method, Setup};
use crate::rig::Rig;
use crate::world::{Options, Scenario, simulate_with};
use crate::{RunError, RunOutcome, pipeline};

/// The methods to compare, and the drives to compare them on.
#[derive(Clone, Debug)]
pub struct MethodComparison {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// The methods.
    pub methods: Vec<Method>,
    /// Seeds of the sensors' noise and of the filters alike; the end is excluded.
    pub seeds: Range<u64>,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
    /// Differences of the drives from the filter's model.
    pub options: Options,
    /// Gain of the filters' and the ISM's model, counts m^2; `None` is the sensor's own.
    pub alpha_counts_m2: Option<f32>,
    /// Alpha and gains of the sensors in the model of filters and methods; `None` is the
    /// sensor's own alpha and equal gains. `alpha_counts_m2` wins.
    pub calibration: Option<RingCalibration>,
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
    /// A filter refused readings of its own simulation: the maps are not comparable.
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

impl MethodComparison {
    /// Checks the configuration of every filter, before the first drive.
    ///
    /// # Errors
    /// [`ComparisonError::Run`] for the first that is not legal or does not fit.
    pub fn check(&self) -> Result<(), ComparisonError> {
        for scenario in &self.scenarios {
            let config = self.config(scenario, 0, Profile::Paper);
            crate::check(&config).map_err(|source| ComparisonError::Run {
                scenario: scenario.name.clone(),
                source,
            })?;
        }
        Ok(())
    }

    /// Drives, maps and judges everything; by scenario, then seed, then method, each
    /// in the order given.
    ///
    /// The same trials, bit for bit, however many threads there are: a drive depends
    /// on its seed only, and none on another.
    ///
    /// # Errors
    /// The first of [`ComparisonError`] in this order.
    pub fn run(&self) -> Result<Vec<Trial>, ComparisonError> {
        self.run_with_progress(&|_, _| {})
    }

    /// As [`run`](Self::run); `progress` is called with the number of maps that are made,
    /// and of those to be made, after each map, by any thread.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_with_progress(
        &self,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Vec<Trial>, ComparisonError> {
        let drives: Vec<(&Scenario, u64)> = self
            .scenarios
            .iter()
            .flat_map(|scenario| self.seeds.clone().map(move |seed| (scenario, seed)))
            .collect();
        let pool = ThreadPoolBuilder::new().num_threads(self.threads).build()?;
        let drives: Vec<_> = pool.install(|| {
            let maps = drives.len() * self.methods.len();
            let made = AtomicUsize::new(0);
            let trials = drives.par_iter().map(|(scenario, seed)| {
                self.drive(scenario, *seed, &|| {
                    progress(1 + made.fetch_add(1, Ordering::Relaxed), maps);
                })
            });
            trials.collect()
        });
        let drives: Result<Vec<_>, _> = drives.into_iter().collect();
        Ok(drives?.into_iter().flatten().collect())
    }

    /// All methods on one drive.
    fn drive(
        &self,
        scenario: &Scenario,
        seed: u64,
        on_map: &dyn Fn(),
    ) -> Result<Vec<Trial>, ComparisonError> {
        let inputs = simulate_with(scenario, seed, &self.options).inputs;
        let mut steps: Vec<Record> = Vec::new();
        let config = self.config(scenario, seed, Profile::Paper);
        let outcome = pipeline::step_records(&config, &inputs, &mut |record| {
            steps.push(record.clone());
        });
        checked(scenario, seed, outcome)?;
        let poses: Vec<_> = steps.iter().filter_map(Record::pose).collect();
        let truth = Truth::of(scenario, &poses);
        let trial = |method: &Method| {
            let config = self.config(scenario, seed, method.profile.unwrap_or(Profile::Paper));
            let mut mapper = method.mapper(&Setup {
                rig: &Rig::from(&config),
                lattice: scenario.cell_m.into(),
                footprint: self.footprint,
                no_echo: None,
                extent: Some(scenario.extent),
            });
            let mut judge = DriveJudge::new(scenario, &truth, &poses);
            let records = |take: &mut dyn FnMut(&Record)| match method.profile {
                Some(_) => pipeline::filter_records(&config, &inputs, take),
                None => {
                    steps.iter().for_each(take);
                    Ok(RunOutcome::default())
                }
            };
            let outcome = pipeline::run(records, &mut mapper, &mut |record, mapper| {
                judge.take(record, mapper);
            });
            checked(scenario, seed, outcome)?;
            on_map();
            Ok(Trial {
                scenario: scenario.name.clone(),
                method: *method,
                seed,
                scores: judge.finish(&mapper),
            })
        };
        self.methods.iter().map(trial).collect()
    }

    /// The configuration of a filter with a profile.
    fn config(&self, scenario: &Scenario, seed: u64, profile: Profile) -> Config {
        let mut config = Config {
            seed,
            particles_per_sensor: self.particles_per_sensor,
            ..scenario.config(profile)
        };
        if let Some(calibration) = &self.calibration {
            calibration.apply(&mut config);
        }
        if let Some(alpha) = self.alpha_counts_m2 {
            config.photometry.alpha_counts_m2 = alpha;
        }
        config
    }
}

/// A run of which no input was refused.
fn checked(
    scenario: &Scenario,
    seed: u64,
    run: Result<RunOutcome, RunError>,
) -> Result<(), ComparisonError> {
    let outcome = run.map_err(|source| ComparisonError::Run {
        scenario: scenario.name.clone(),
        source,
    })?;
    match outcome.faults().map(|(_, count)| count).sum() {
        0 => Ok(()),
        refused => Err(ComparisonError::Refused {
            scenario: scenario.name.clone(),
            seed,
            refused,
        }),
    }
}
