//! The paper's five scenarios, built into the program.

use super::{Scenario, ScenarioError};

/// Name and text of each, in the paper's order.
pub const STANDARD: [(&str, &str); 5] = [
    ("ssso", include_str!("../../../scenarios/ssso.toml")),
    ("msso", include_str!("../../../scenarios/msso.toml")),
    ("msod", include_str!("../../../scenarios/msod.toml")),
    ("msm_l", include_str!("../../../scenarios/msm_l.toml")),
    ("msm_t", include_str!("../../../scenarios/msm_t.toml")),
];

/// The paper's scenarios in its order.
///
/// # Errors
/// As [`Scenario::parse`]; a test holds that there are none.
pub fn standard_scenarios() -> Result<Vec<Scenario>, ScenarioError> {
    let scenarios = STANDARD.iter().map(|(_, text)| Scenario::parse(text));
    scenarios.collect()
}

/// The scenario of the paper with a name; `None` for other names.
///
/// # Errors
/// As [`Scenario::parse`]; a test holds that there are none.
pub fn standard(name: &str) -> Option<Result<Scenario, ScenarioError>> {
    let found = STANDARD.into_iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| Scenario::parse(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_standard_scenario_is_found_by_the_name_it_has() {
        for (name, _) in STANDARD {
            assert_eq!(standard(name).unwrap().unwrap().name, name);
        }
        assert!(standard("nowhere").is_none());
    }
}
