//! Claims about metrics, and verdicts on them.

use core::fmt;

use super::comparison::Trial;
use super::{Metric, Number, Trials};
use crate::mapping::Method;
use crate::world::{OdometryModel, Options, Physics};

/// A bound on a metric of a method's maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The scenario's name.
    pub scenario: String,
    /// The method.
    pub method: Method,
    /// The metric.
    pub metric: Metric,
    /// How the values of the seeds are combined.
    pub over: Over,
    /// The relation of the measured value to the bound.
    pub relation: Relation,
    /// The bound.
    pub bound: f64,
    /// The physics of the world that it is about, with exact poses. `None` for one that is
    /// about every world if it is a share of another method's, else about `matched`.
    pub physics: Option<Physics>,
}

/// How the values of the seeds are combined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Over {
    /// Their mean.
    Mean,
    /// The smallest of them.
    Smallest,
    /// The largest of them.
    Largest,
    /// Their mean as a share of that of another method.
    MeanShareOf(Method),
    /// Their mean less that of another method.
    MeanLess(Method),
}

/// The relation of a measured value to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// Below it.
    Below,
    /// At most as large.
    AtMost,
    /// At least as large.
    AtLeast,
}

/// A claim and the measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimVerdict {
    /// The claim.
    pub claim: Claim,
    /// The measured value; `None` where it is undefined, which never holds.
    pub measured: Option<f64>,
}

impl Claim {
    /// Whether the claim is about a simulated world.
    #[must_use]
    pub fn is_about(&self, options: &Options) -> bool {
        let is_exact = options.odometry == OdometryModel::Truth;
        match (self.physics, self.over) {
            (Some(physics), _) => is_exact && options.physics == physics,
            (None, Over::MeanShareOf(_)) => true,
            (None, _) => is_exact && options.physics == Physics::Matched,
        }
    }

    /// The verdict by trials; `None` if they lack the scenario or a method.
    #[must_use]
    pub fn judge(&self, trials: &[Trial]) -> Option<ClaimVerdict> {
        let of = |method| Trials::of(trials, &self.scenario, method);
        let (mine, metric) = (of(self.method)?, self.metric);
        let measured = match self.over {
            Over::Mean => mine.mean(metric),
            Over::Smallest => mine.smallest(metric).map(|(value, _)| value),
            Over::Largest => mine.largest(metric).map(|(value, _)| value),
            Over::MeanShareOf(other) => {
                let its = of(other)?.mean(metric).filter(|its| *its > 0.0);
                mine.mean(metric).zip(its).map(|(mine, its)| mine / its)
            }
            Over::MeanLess(other) => {
                let its = of(other)?.mean(metric);
                mine.mean(metric).zip(its).map(|(mine, its)| mine - its)
            }
        };
        Some(ClaimVerdict {
            claim: self.clone(),
            measured,
        })
    }
}

impl ClaimVerdict {
    /// Whether the claim holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        let bound = self.claim.bound;
        self.measured
            .is_some_and(|measured| match self.claim.relation {
                Relation::Below => measured < bound,
                Relation::AtMost => measured <= bound,
                Relation::AtLeast => measured >= bound,
            })
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (method, metric) = (self.method, self.metric.name());
        match self.over {
            Over::Mean => write!(f, "{method}: {metric}"),
            Over::Smallest | Over::Largest => write!(f, "{method}: {metric}, every seed"),
            Over::MeanShareOf(other) => write!(f, "{method}: {metric} / that of {other}"),
            Over::MeanLess(other) => write!(f, "{method}: {metric} - that of {other}"),
        }
    }
}

impl fmt::Display for ClaimVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_share = matches!(self.claim.over, Over::MeanShareOf(_));
        let decimals = match self.claim.metric {
            Metric::OpeningFalse
            | Metric::OpeningFalseLeast
            | Metric::OpeningFrontier
            | Metric::OpeningFrontierMost
                if !is_share =>
            {
                1
            }
            _ => 3,
        };
        let number = |value| Number { value, decimals };
        let relation = match self.claim.relation {
            Relation::Below => "< ",
            Relation::AtMost => "<=",
            Relation::AtLeast => ">=",
        };
        write!(
            f,
            "{}  {:6} {:60} {:7} {relation} {:7}",
            if self.holds() { "PASS" } else { "FAIL" },
            self.claim.scenario,
            self.claim.to_string(),
            number(self.measured),
            number(Some(self.claim.bound)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(measured: Option<f64>, relation: Relation) -> ClaimVerdict {
        let claim = Claim {
            scenario: "msod".to_owned(),
            method: Method::PAPER,
            metric: Metric::Oe,
            over: Over::Mean,
            relation,
            bound: 0.035,
            physics: None,
        };
        ClaimVerdict { claim, measured }
    }

    #[test]
    fn equal_to_the_bound_is_not_below_it() {
        assert!(verdict(Some(0.035), Relation::AtMost).holds());
        assert!(verdict(Some(0.035), Relation::AtLeast).holds());
        assert!(!verdict(Some(0.035), Relation::Below).holds());
    }

    #[test]
    fn the_undefined_never_holds() {
        for relation in [Relation::Below, Relation::AtMost, Relation::AtLeast] {
            assert!(!verdict(None, relation).holds());
            assert!(!verdict(Some(f64::NAN), relation).holds());
        }
        let line = verdict(None, Relation::AtMost).to_string();
        assert!(line.starts_with("FAIL  msod   paper: OE  "), "{line}");
        assert!(line.ends_with("n/a <=   0.035"), "{line}");
    }

    #[test]
    fn a_claim_is_about_its_physics_and_a_ratio_about_every_world_if_it_names_none() {
        let about = |physics, over| {
            let claim = Claim {
                physics,
                over,
                ..verdict(None, Relation::AtMost).claim
            };
            [
                (Physics::Matched, OdometryModel::Truth),
                (Physics::Patch, OdometryModel::Truth),
                (Physics::Patch, OdometryModel::Amiro),
            ]
            .map(|(physics, odometry)| {
                claim.is_about(&Options {
                    physics,
                    odometry,
                    ..Options::default()
                })
            })
        };
        let share = Over::MeanShareOf(Method::PLUS);
        assert_eq!(about(None, Over::Mean), [true, false, false]);
        assert_eq!(about(None, share), [true, true, true]);
        assert_eq!(
            about(Some(Physics::Patch), Over::Mean),
            [false, true, false]
        );
        assert_eq!(about(Some(Physics::Patch), share), [false, true, false]);
    }

    #[test]
    fn what_was_not_run_is_not_judged() {
        assert_eq!(verdict(None, Relation::AtMost).claim.judge(&[]), None);
    }
}
