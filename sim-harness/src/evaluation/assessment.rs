//! A comparison that ran, and what the claims say of it.

use super::{
    Claim, ClaimVerdict, Claims, ComparisonError, MethodComparison, OdometryLoss, Over, Trial,
};
use crate::world::{OdometryModel, Options, Physics};

/// The trials of a comparison with the verdicts on them.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// Every method on every drive.
    pub trials: Vec<Trial>,
    /// Verdicts on the claims of the paper.
    pub paper: Vec<ClaimVerdict>,
    /// Verdicts on the thresholds that are for the simulated world.
    pub thresholds: Vec<ClaimVerdict>,
    /// What the AMiRo's odometry costs; empty where another one was simulated.
    pub odometry: Vec<OdometryLoss>,
}

impl Assessment {
    /// Runs a comparison and judges it by the claims.
    ///
    /// # Errors
    /// As [`MethodComparison::run`].
    pub fn of(comparison: &MethodComparison, claims: &Claims) -> Result<Self, ComparisonError> {
        let trials = comparison.run()?;
        let options = &comparison.options;
        let thresholds = claims.thresholds.iter();
        let odometry = if options.odometry == OdometryModel::Amiro {
            OdometryLoss::of(comparison, &trials, claims.odometry_loss_at_most)?
        } else {
            Vec::new()
        };
        Ok(Self {
            paper: verdicts(claims.paper.iter(), &trials),
            thresholds: verdicts(thresholds.filter(|claim| applies(claim, options)), &trials),
            odometry,
            trials,
        })
    }

    /// Whether every claim and threshold holds; `None` if none is about these trials.
    #[must_use]
    pub fn holds(&self) -> Option<bool> {
        let mut judged = self.paper.iter().chain(&self.thresholds).peekable();
        judged.peek()?;
        Some(judged.all(ClaimVerdict::holds) && self.odometry.iter().all(OdometryLoss::holds))
    }
}

/// Whether a threshold is for a simulated world: ratios between methods are for every
/// world, the others for the matched sensor and exact poses.
fn applies(threshold: &Claim, options: &Options) -> bool {
    let is_reference =
        options.physics == Physics::Matched && options.odometry == OdometryModel::Truth;
    is_reference || matches!(threshold.over, Over::MeanShareOf(_))
}

fn verdicts<'c>(claims: impl Iterator<Item = &'c Claim>, trials: &[Trial]) -> Vec<ClaimVerdict> {
    claims.filter_map(|claim| claim.judge(trials)).collect()
}
