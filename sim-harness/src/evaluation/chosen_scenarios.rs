//! The scenarios of a comparison by name or file.

use std::collections::BTreeSet;
use std::path::Path;

use crate::world::{STANDARD, Scenario, ScenarioError, standard};

/// Why scenarios cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioChoiceError {
    /// One is no scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Scores are listed by name.
    #[error("two scenarios are named {0}")]
    SameName(String),
    /// Claims are found by name: another world must not be judged by those of the paper.
    #[error("{file}: named {name}, but not the paper's; rename it")]
    PaperName {
        /// The file.
        file: String,
        /// The name in it.
        name: String,
    },
}

/// The scenarios of the paper by their names, and others from their files; all of the
/// paper's if none is named.
///
/// # Errors
/// As [`Scenario::load`]; a name that another scenario has.
pub fn chosen_scenarios(wanted: &[String]) -> Result<Vec<Scenario>, ScenarioChoiceError> {
    let all = STANDARD.map(|(name, _)| name.to_owned());
    let wanted = if wanted.is_empty() { &all } else { wanted };
    let mut scenarios = Vec::new();
    let mut names = BTreeSet::new();
    for wanted in wanted {
        let scenario = scenario(wanted)?;
        if !names.insert(scenario.name.clone()) {
            return Err(ScenarioChoiceError::SameName(scenario.name));
        }
        scenarios.push(scenario);
    }
    Ok(scenarios)
}

fn scenario(wanted: &str) -> Result<Scenario, ScenarioChoiceError> {
    if let Some(known) = standard(wanted) {
        return Ok(known?);
    }
    let scenario = Scenario::load(Path::new(wanted))?;
    if let Some(known) = standard(&scenario.name)
        && known? != scenario
    {
        return Err(ScenarioChoiceError::PaperName {
            file: wanted.to_owned(),
            name: scenario.name,
        });
    }
    Ok(scenario)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_is_all_of_the_paper_and_a_name_counts_once() {
        assert_eq!(chosen_scenarios(&[]).unwrap().len(), STANDARD.len());
        let twice = ["msod".to_owned(), "msod".to_owned()];
        let error = chosen_scenarios(&twice).unwrap_err();
        assert_eq!(error.to_string(), "two scenarios are named msod");
    }
}
