//! Scores of a method's maps over seeds, and their means in percent.

use super::FigureError;
use super::scenario_maps::{Conditions, ScenarioMaps};
use crate::evaluation::{MeanStd, Scores, Truth};
use crate::mapping::Method;
use crate::world::Scenario;

/// A score with the name of its column.
pub(super) type Score = (&'static str, fn(&Scores) -> Option<f64>);

/// Overall error at the best wall expansion.
pub(super) const OE: Score = ("OE, %", |scores| scores.oe);
/// Overall error without wall expansion.
pub(super) const OE_PLAIN: Score = ("plain OE, %", |scores| scores.oe_unexpanded);
/// True positive rate.
pub(super) const TPR: Score = ("TPR, %", |scores| scores.tpr);
/// Share of the visible surface that is found.
pub(super) const RECALL: Score = ("surface recall, %", |scores| scores.surface_recall);
/// Share of the visible free space that is classified.
pub(super) const COVERAGE: Score = ("coverage, %", |scores| scores.coverage);

/// The scores of a table, in the order of its columns.
pub(super) const COLUMNS: [Score; 6] = [
    OE,
    OE_PLAIN,
    TPR,
    ("FPR, %", |scores| scores.fpr),
    RECALL,
    COVERAGE,
];

/// Drives through a scenario under each of the conditions; gives for each method the
/// scores of its maps, one per drive.
pub(super) fn judged(
    scenario: &Scenario,
    methods: &[Method],
    conditions: impl Iterator<Item = Conditions>,
) -> Result<Vec<Vec<Scores>>, FigureError> {
    let mut truth = None;
    let mut scores = vec![Vec::new(); methods.len()];
    for conditions in conditions {
        let drive = ScenarioMaps::new(scenario, methods, &conditions)?;
        // The path is the same for every seed.
        let truth = truth.get_or_insert_with(|| Truth::of(scenario, &drive.poses));
        for (scores, map) in scores.iter_mut().zip(&drive.maps) {
            scores.push(Scores::of(map, truth));
        }
    }
    Ok(scores)
}

/// Mean and standard deviation of a score over the drives where it is defined, percent;
/// 0 if there are too few of them.
pub(super) fn percent(scores: &[Scores], (_, value): Score) -> (f64, f64) {
    let defined: Vec<_> = scores.iter().map(value).filter(Option::is_some).collect();
    let MeanStd { mean, std, .. } = MeanStd::of(&defined);
    (100.0 * mean.unwrap_or(0.0), 100.0 * std.unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undefined_scores_do_not_count() {
        let map = crate::mapping::Map::unknown(0.01);
        let scenario = crate::world::standard("ssso").unwrap().unwrap();
        let undefined = Scores::of(&map, &Truth::of(&scenario, &[]));
        let with = |oe| Scores { oe, ..undefined };
        let (mean, std) = percent(&[with(Some(1.0)), with(None), with(Some(3.0))], OE);
        assert!((mean - 200.0).abs() < 1e-9, "{mean}");
        assert!((std - 100.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{std}");
        assert_eq!(percent(&[with(None)], OE), (0.0, 0.0));
        assert!(percent(&[with(Some(0.05))], OE).1.abs() < 1e-12);
    }
}
