//! The record of a trial in a file.

use serde::Serialize;

use super::{DriveScores, Trial};

/// A drive's scores as a file has them: one flat object, `null` for what is undefined.
///
/// Of several openings the falsely occupied cells are summed and the frontier cells
/// are those of the one with the fewest: each time the worse value for a filter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoreRecord {
    oe: Option<f64>,
    oe_unexpanded: Option<f64>,
    tpr: Option<f64>,
    fpr: Option<f64>,
    j: Option<f64>,
    surface_recall: Option<f64>,
    coverage: Option<f64>,
    surface_bias_m: Option<f64>,
    surface_rms_m: Option<f64>,
    cells: u64,
    unknown: u64,
    cells_refused: u64,
    oe_path_mean: Option<f64>,
    opening_false_occupied: Option<u64>,
    opening_frontier: Option<u64>,
}

impl From<&DriveScores> for ScoreRecord {
    fn from(scores: &DriveScores) -> Self {
        let last = &scores.last;
        Self {
            oe: last.oe,
            oe_unexpanded: last.oe_unexpanded,
            tpr: last.tpr,
            fpr: last.fpr,
            j: last.j,
            surface_recall: last.surface_recall,
            coverage: last.coverage,
            surface_bias_m: scores.offset.bias_m,
            surface_rms_m: scores.offset.rms_m,
            cells: last.cells,
            unknown: last.unknown,
            cells_refused: last.cells_refused,
            oe_path_mean: scores.oe_path_mean,
            opening_false_occupied: scores.opening_false_occupied(),
            opening_frontier: scores.opening_frontier(),
        }
    }
}

/// A trial as a file has it: its name and the scores in one flat object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialRecord<'t> {
    scenario: &'t str,
    method: &'static str,
    seed: u64,
    #[serde(flatten)]
    scores: ScoreRecord,
}

impl<'t> From<&'t Trial> for TrialRecord<'t> {
    fn from(trial: &'t Trial) -> Self {
        Self {
            scenario: &trial.scenario,
            method: trial.method.name,
            seed: trial.seed,
            scores: ScoreRecord::from(&trial.scores),
        }
    }
}

/// The trials as a JSON array, one [`TrialRecord`] a line, so that files compare by line.
///
/// # Errors
/// As `serde_json` has it for any value; a record gives it no reason.
pub fn json(trials: &[Trial]) -> Result<String, serde_json::Error> {
    json_lines(trials.iter().map(TrialRecord::from))
}

/// Rows as a JSON array, a row per line.
///
/// # Errors
/// As `serde_json` has it for any value.
pub fn json_lines<T: Serialize>(
    rows: impl IntoIterator<Item = T>,
) -> Result<String, serde_json::Error> {
    let rows = rows.into_iter().map(|row| serde_json::to_string(&row));
    let rows: Vec<String> = rows.collect::<Result<_, _>>()?;
    Ok(format!("[\n{}\n]\n", rows.join(",\n")))
}
