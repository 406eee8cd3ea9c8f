//! Trials, looked at by scenario and method.

use super::comparison::Trial;
use super::{Measure, Spread};
use crate::mapping::Method;

/// The trials of one method in one scenario, by seed.
#[derive(Clone, Debug)]
pub struct Trials<'t> {
    trials: Vec<&'t Trial>,
}

impl<'t> Trials<'t> {
    /// Those of `all` with the given scenario and method; `None` if there are none.
    #[must_use]
    pub fn of(all: &'t [Trial], scenario: &str, method: Method) -> Option<Self> {
        let is_one = |trial: &&Trial| trial.scenario == scenario && trial.method == method;
        let trials: Vec<_> = all.iter().filter(is_one).collect();
        (!trials.is_empty()).then_some(Self { trials })
    }

    /// A figure over the seeds.
    #[must_use]
    pub fn spread(&self, measure: Measure) -> Spread {
        let values = self.trials.iter().map(|trial| measure.of(&trial.scores));
        Spread::of(&values.collect::<Vec<_>>())
    }

    /// A figure's mean over the seeds.
    #[must_use]
    pub fn mean(&self, measure: Measure) -> Option<f64> {
        self.spread(measure).mean
    }

    /// The largest value of a figure, and its seed.
    #[must_use]
    pub fn largest(&self, measure: Measure) -> Option<(f64, u64)> {
        self.defined(measure)
            .max_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// The smallest value of a figure, and its seed.
    #[must_use]
    pub fn smallest(&self, measure: Measure) -> Option<(f64, u64)> {
        self.defined(measure)
            .min_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// A figure less another method's on the same drives, by seed.
    #[must_use]
    pub fn less(&self, other: &Self, measure: Measure) -> Vec<Option<f64>> {
        let pairs = self.trials.iter().filter_map(|trial| {
            let same = other.trials.iter().find(|other| other.seed == trial.seed)?;
            Some((measure.of(&trial.scores), measure.of(&same.scores)))
        });
        pairs.map(|(mine, its)| Some(mine? - its?)).collect()
    }

    fn defined(&self, measure: Measure) -> impl Iterator<Item = (f64, u64)> {
        let trials = self.trials.iter();
        trials.filter_map(move |trial| Some((measure.of(&trial.scores)?, trial.seed)))
    }
}
