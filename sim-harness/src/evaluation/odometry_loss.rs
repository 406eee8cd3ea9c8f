//! What the AMiRo's odometry costs a filter.

use super::{ComparisonError, MethodComparison, Metric, Trial, Trials};
use crate::mapping::Method;
use crate::world::OdometryModel;

/// Overall errors of one filter in one scenario, as shares, under three odometries: exact
/// poses, as on the AMiRo's bus, and the same without prediction to the readings' time.
#[derive(Clone, Debug, PartialEq)]
pub struct OdometryLoss {
    /// The scenario's name.
    pub scenario: String,
    /// The filter.
    pub method: Method,
    /// With exact poses.
    pub exact: f64,
    /// As on the AMiRo's bus.
    pub amiro: f64,
    /// The same without prediction, where it was mapped.
    pub undated: Option<f64>,
    /// The plain overall error of the three, in this order.
    pub plain: [Option<f64>; 3],
    /// Greatest loss that holds.
    pub loss_at_most: f64,
}

impl OdometryLoss {
    /// What the AMiRo's odometry costs, as a share.
    #[must_use]
    pub fn loss(&self) -> f64 {
        self.amiro - self.exact
    }

    /// Whether the loss is within its bound.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.loss() <= self.loss_at_most
    }

    /// Compares the trials of a comparison under the AMiRo's odometry with exact poses and
    /// with no prediction, for which the drives run again.
    ///
    /// # Errors
    /// As [`MethodComparison::run`].
    pub fn of(
        comparison: &MethodComparison,
        trials: &[Trial],
        loss_at_most: f64,
    ) -> Result<Vec<Self>, ComparisonError> {
        let with = |odometry| {
            let mut other = comparison.clone();
            other.options.odometry = odometry;
            other.run()
        };
        let exact = with(OdometryModel::Truth)?;
        let undated = with(OdometryModel::AmiroUndated)?;
        let all = [&exact, trials, &undated];
        let mut losses = Vec::new();
        for scenario in &comparison.scenarios {
            for method in [Method::PAPER, Method::PLUS] {
                let mean = |metric| {
                    all.map(|trials| Trials::of(trials, &scenario.name, method)?.mean(metric))
                };
                let [Some(exact), Some(amiro), undated] = mean(Metric::Oe) else {
                    continue;
                };
                losses.push(Self {
                    scenario: scenario.name.clone(),
                    method,
                    exact,
                    amiro,
                    undated,
                    plain: mean(Metric::OePlain),
                    loss_at_most,
                });
            }
        }
        Ok(losses)
    }
}
