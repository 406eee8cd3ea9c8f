//! Trials, looked at by scenario and method.

use super::comparison::Trial;
use super::{MeanStd, Metric};
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

    /// Those of `all` with the given method, of all scenarios; `None` if there are none.
    #[must_use]
    pub fn of_method(all: &'t [Trial], method: Method) -> Option<Self> {
        let trials: Vec<_> = all.iter().filter(|trial| trial.method == method).collect();
        (!trials.is_empty()).then_some(Self { trials })
    }

    /// A metric's mean over the drives in which it is defined, and their number.
    #[must_use]
    pub fn mean_of_defined(&self, metric: Metric) -> (Option<f64>, usize) {
        let values: Vec<Option<f64>> = self.defined(metric).map(|(value, _)| Some(value)).collect();
        (MeanStd::of(&values).mean, values.len())
    }

    /// Mean and standard deviation of a metric over the seeds.
    #[must_use]
    pub fn mean_std(&self, metric: Metric) -> MeanStd {
        let values = self.trials.iter().map(|trial| metric.of(&trial.scores));
        MeanStd::of(&values.collect::<Vec<_>>())
    }

    /// A metric's mean over the seeds.
    #[must_use]
    pub fn mean(&self, metric: Metric) -> Option<f64> {
        self.mean_std(metric).mean
    }

    /// The largest value of a metric, and its seed.
    #[must_use]
    pub fn largest(&self, metric: Metric) -> Option<(f64, u64)> {
        self.defined(metric).max_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// The smallest value of a metric, and its seed.
    #[must_use]
    pub fn smallest(&self, metric: Metric) -> Option<(f64, u64)> {
        self.defined(metric).min_by(|(a, _), (b, _)| a.total_cmp(b))
    }

    /// A metric less another method's on the same drives, by seed.
    #[must_use]
    pub fn less(&self, other: &Self, metric: Metric) -> Vec<Option<f64>> {
        let pairs = self.trials.iter().filter_map(|trial| {
            let same = other.trials.iter().find(|other| other.seed == trial.seed)?;
            Some((metric.of(&trial.scores), metric.of(&same.scores)))
        });
        pairs.map(|(mine, its)| Some(mine? - its?)).collect()
    }

    fn defined(&self, metric: Metric) -> impl Iterator<Item = (f64, u64)> {
        let trials = self.trials.iter();
        trials.filter_map(move |trial| Some((metric.of(&trial.scores)?, trial.seed)))
    }
}
