//! The claims of `scenarios/claims.toml`, built into the program.

use serde::{Deserialize, Deserializer};

use super::{Claim, Metric, Over, Relation};
use crate::mapping::Method;
use crate::world::Physics;

/// The file, in the program itself: `evaluate --check` works in any folder.
const TEXT: &str = include_str!("../../../scenarios/claims.toml");

/// The claims and thresholds that judge a comparison.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(from = "File")]
pub struct Claims {
    /// What the paper reports of its filter and of the inverse sensor model.
    pub paper: Vec<Claim>,
    /// What the filters have to reach in the paper's scenarios.
    pub thresholds: Vec<Claim>,
    /// Greatest overall error that the AMiRo's odometry may cost, as a share.
    pub odometry_loss_at_most: f64,
}

impl Claims {
    /// The claims that ship.
    ///
    /// # Errors
    /// The line of the file that is no claim; a test proves that there is none.
    pub fn built_in() -> Result<Self, toml::de::Error> {
        toml::from_str(TEXT)
    }

    /// The bound of a threshold on the mean of a metric in the matched world; `None` if there
    /// is none.
    #[must_use]
    pub fn threshold(&self, scenario: &str, method: Method, metric: Metric) -> Option<f64> {
        let claim = self.thresholds.iter().find(|claim| {
            claim.scenario == scenario
                && (claim.method, claim.metric) == (method, metric)
                && (claim.over, claim.physics) == (Over::Mean, None)
        });
        claim.map(|claim| claim.bound)
    }
}

/// The keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    odometry_loss_at_most: f64,
    paper: Vec<Block>,
    threshold: Vec<Block>,
}

/// The same claims in several scenarios.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Block {
    scenarios: Vec<String>,
    /// The physics of the worlds that the claims are about.
    #[serde(default, deserialize_with = "physics")]
    physics: Option<Physics>,
    claims: Vec<Bound>,
}

/// The physics of this name.
fn physics<'d, D: Deserializer<'d>>(text: D) -> Result<Option<Physics>, D::Error> {
    let name = String::deserialize(text)?;
    name.parse().map(Some).map_err(serde::de::Error::custom)
}

/// A claim without its scenario.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "ClaimRow")]
struct Bound {
    method: Method,
    metric: Metric,
    over: Over,
    relation: Relation,
    bound: f64,
}

/// The keys of a claim.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimRow {
    method: String,
    metric: Metric,
    over: Option<String>,
    share_of: Option<String>,
    less: Option<String>,
    below: Option<f64>,
    at_most: Option<f64>,
    at_least: Option<f64>,
}

impl TryFrom<ClaimRow> for Bound {
    type Error = String;

    fn try_from(keys: ClaimRow) -> Result<Self, String> {
        let method = |name: &str| name.parse::<Method>().map_err(|error| error.to_string());
        let over = match (keys.over.as_deref(), &keys.share_of, &keys.less) {
            (None, None, None) => Over::Mean,
            (Some("smallest"), None, None) => Over::Smallest,
            (Some("largest"), None, None) => Over::Largest,
            (None, Some(other), None) => Over::MeanShareOf(method(other)?),
            (None, None, Some(other)) => Over::MeanLess(method(other)?),
            _ => return Err("one of over = smallest or largest, share_of, less".to_owned()),
        };
        let (relation, bound) = match (keys.below, keys.at_most, keys.at_least) {
            (Some(bound), None, None) => (Relation::Below, bound),
            (None, Some(bound), None) => (Relation::AtMost, bound),
            (None, None, Some(bound)) => (Relation::AtLeast, bound),
            _ => return Err("a claim has one of below, at_most, at_least".to_owned()),
        };
        Ok(Self {
            method: method(&keys.method)?,
            metric: keys.metric,
            over,
            relation,
            bound,
        })
    }
}

impl From<File> for Claims {
    fn from(file: File) -> Self {
        let claims = |blocks: Vec<Block>| blocks.into_iter().flat_map(Block::into_claims);
        Self {
            paper: claims(file.paper).collect(),
            thresholds: claims(file.threshold).collect(),
            odometry_loss_at_most: file.odometry_loss_at_most,
        }
    }
}

impl Block {
    /// Scenario by scenario, in the order of the file.
    fn into_claims(self) -> impl Iterator<Item = Claim> {
        self.scenarios.into_iter().flat_map(move |scenario| {
            let claim = |bound: &Bound| Claim {
                scenario: scenario.clone(),
                method: bound.method,
                metric: bound.metric,
                over: bound.over,
                relation: bound.relation,
                bound: bound.bound,
                physics: self.physics,
            };
            self.claims.iter().map(claim).collect::<Vec<_>>()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard;

    #[test]
    fn the_claims_that_ship_are_about_the_papers_scenarios() {
        let claims = Claims::built_in().unwrap();
        // 8 in each of three scenarios, 6 in each maze.
        assert_eq!(claims.paper.len(), 3 * 8 + 2 * 6);
        // 9 in each scenario, 7 of the openings of each maze.
        let (patch, other): (Vec<_>, Vec<_>) = claims
            .thresholds
            .iter()
            .partition(|claim| claim.physics == Some(Physics::Patch));
        assert_eq!(other.len(), 5 * 9 + 2 * 7);
        assert!(other.iter().all(|claim| claim.physics.is_none()));
        let of_walls = patch.iter().filter(|it| it.method == Method::WALL_MAP);
        assert_eq!(of_walls.count(), 3);
        for claim in claims.paper.iter().chain(&claims.thresholds) {
            assert!(standard(&claim.scenario).is_some(), "{claim:?}");
        }
        let bound = claims.threshold("msod", Method::PAPER, Metric::Oe);
        assert_eq!(bound, Some(0.035));
    }

    #[test]
    fn a_block_of_claims_may_name_the_physics_of_its_worlds() {
        let block = |physics: &str| {
            let text = format!(
                "scenarios = [\"msod\", \"msm_l\"]\n{physics}\n\
                 claims = [{{ method = \"plus\", metric = \"coverage\", at_least = 0.88 }}]"
            );
            toml::from_str::<Block>(&text).map_err(|error| error.to_string())
        };
        let claims: Vec<_> = block("physics = \"patch\"")
            .unwrap()
            .into_claims()
            .collect();
        assert_eq!(claims.len(), 2);
        assert!(claims.iter().all(|it| it.physics == Some(Physics::Patch)));
        let claims: Vec<_> = block("").unwrap().into_claims().collect();
        assert!(claims.iter().all(|it| it.physics.is_none()));
        let error = block("physics = \"lambert\"").unwrap_err();
        assert!(error.contains("lambert"), "{error}");
    }

    #[test]
    fn a_claim_without_one_bound_and_one_way_to_take_the_seeds_is_refused() {
        for (keys, part) in [
            ("metric = \"oe\"", "one of below"),
            ("metric = \"oe\"\nbelow = 1\nat_most = 1", "one of below"),
            ("metric = \"oe\"\nbelow = 1\nover = \"most\"", "smallest"),
            ("metric = \"oe\"\nbelow = 1\nless = \"none\"", "no method"),
            ("metric = \"o\"\nbelow = 1", "unknown variant"),
            ("metric = \"oe\"\nbelow = 1\nabove = 2", "unknown field"),
        ] {
            let text = format!("method = \"paper\"\n{keys}");
            let error = toml::from_str::<Bound>(&text).unwrap_err().to_string();
            assert!(error.contains(part), "no {part:?} in {error}");
        }
    }
}
