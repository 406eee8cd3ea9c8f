//! A comparison that ran, and what the claims say of it.

use super::{Claim, ClaimVerdict, Claims, ComparisonError, MethodComparison, OdometryLoss, Trial};
use crate::world::{OdometryModel, Options};

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
    /// Runs a comparison and judges it by the claims; `progress` is that of
    /// [`MethodComparison::run_with_progress`].
    ///
    /// # Errors
    /// As [`MethodComparison::run`].
    pub fn of(
        comparison: &MethodComparison,
        claims: &Claims,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, ComparisonError> {
        let trials = comparison.run_with_progress(progress)?;
        let odometry = if comparison.options.odometry == OdometryModel::Amiro {
            OdometryLoss::of(comparison, &trials, claims.odometry_loss_at_most)?
        } else {
            Vec::new()
        };
        Ok(Self::judged(trials, odometry, &comparison.options, claims))
    }

    /// Judges trials in a simulated world by the claims.
    fn judged(
        trials: Vec<Trial>,
        odometry: Vec<OdometryLoss>,
        options: &Options,
        claims: &Claims,
    ) -> Self {
        let thresholds = claims.thresholds.iter();
        Self {
            paper: verdicts(claims.paper.iter(), &trials),
            thresholds: verdicts(thresholds.filter(|it| it.is_about(options)), &trials),
            odometry,
            trials,
        }
    }

    /// Whether every claim and threshold holds; `None` if none is about these trials.
    #[must_use]
    pub fn holds(&self) -> Option<bool> {
        let mut judged = self.paper.iter().chain(&self.thresholds).peekable();
        judged.peek()?;
        Some(judged.all(ClaimVerdict::holds) && self.odometry.iter().all(OdometryLoss::holds))
    }
}

fn verdicts<'c>(claims: impl Iterator<Item = &'c Claim>, trials: &[Trial]) -> Vec<ClaimVerdict> {
    claims.filter_map(|claim| claim.judge(trials)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::{DriveScores, Scores, SurfaceOffset};
    use crate::mapping::Method;
    use crate::world::Physics;

    /// Thresholds for two methods under `patch`, of recall, coverage and openings.
    const CLAIMS: &str = r#"
        odometry_loss_at_most = 0.005
        paper = []
        [[threshold]]
        scenarios = ["msm_l"]
        physics = "patch"
        claims = [
            { method = "wall-map", metric = "surface_recall", at_least = 0.9 },
            { method = "plus", metric = "coverage", at_least = 0.9 },
            { method = "plus", metric = "opening_false", at_most = 5 },
        ]
    "#;

    fn trial(method: Method, recall: f64, coverage: f64, openings: &[u64]) -> Trial {
        let last = Scores {
            oe: Some(0.01),
            best_expansion_m: 0.0,
            oe_unexpanded: Some(0.01),
            tpr: Some(0.9),
            fpr: Some(0.0),
            j: Some(0.9),
            surface_recall: Some(recall),
            coverage: Some(coverage),
            cells: 100,
            unknown: 0,
            cells_refused: 0,
        };
        let opening = |cells: &u64| crate::evaluation::OpeningScores {
            false_occupied: *cells,
            frontier: 0,
        };
        Trial {
            scenario: "msm_l".to_owned(),
            method,
            seed: 1,
            scores: DriveScores {
                last,
                offset: SurfaceOffset::default(),
                oe_path_mean: None,
                openings: openings.iter().map(opening).collect(),
                detected_at_m: None,
            },
        }
    }

    fn holds(trials: Vec<Trial>, physics: Physics) -> Option<bool> {
        let claims: Claims = toml::from_str(CLAIMS).unwrap();
        let options = Options {
            physics,
            ..Options::default()
        };
        Assessment::judged(trials, Vec::new(), &options, &claims).holds()
    }

    #[test]
    fn a_method_is_judged_by_its_own_thresholds_under_their_physics() {
        let walls = |recall| vec![trial(Method::WALL_MAP, recall, 0.5, &[])];
        assert_eq!(holds(walls(0.95), Physics::Patch), Some(true));
        assert_eq!(holds(walls(0.85), Physics::Patch), Some(false));
        assert_eq!(holds(walls(0.85), Physics::Matched), None);
        let plus = |coverage, openings: &[u64]| vec![trial(Method::PLUS, 0.5, coverage, openings)];
        assert_eq!(holds(plus(0.95, &[2, 3]), Physics::Patch), Some(true));
        assert_eq!(holds(plus(0.95, &[3, 3]), Physics::Patch), Some(false));
        assert_eq!(holds(plus(0.85, &[2, 3]), Physics::Patch), Some(false));
        // Without a map during the drive there are no figures of openings.
        assert_eq!(holds(plus(0.95, &[]), Physics::Patch), Some(false));
        let ism = vec![trial(Method::ISM_TUNED, 0.5, 0.5, &[])];
        assert_eq!(holds(ism, Physics::Patch), None);
    }
}
