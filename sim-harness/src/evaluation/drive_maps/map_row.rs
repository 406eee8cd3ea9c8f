//! A recording and a method, with the scores of the map.

use crate::evaluation::cell_truth::CellScores;
use serde::Serialize;

/// A recording and a method: a row of the table, and of the file of `--json`.
#[derive(Clone, Debug, Serialize)]
pub struct MapRow {
    /// The path of the recording.
    pub recording: String,
    /// Name of the method.
    pub method: &'static str,
    /// Which poses of the recording were used.
    pub poses: &'static str,
    /// Side of a cell, metres; `None` for a drive that was not read.
    pub cell_m: Option<f64>,
    /// `None` without a truth, or without a map.
    #[serde(flatten, serialize_with = "scores_or_nulls")]
    pub scores: Option<CellScores>,
    /// Occupied and free cells of the map.
    pub map_cells: Option<[usize; 2]>,
    /// Time of the pass over the recording and of the method, seconds.
    pub seconds: Option<f64>,
    /// Most memory on the heap, bytes; 0 in a program that does not count it.
    pub peak_bytes: Option<u64>,
    /// Whether even keyframes are mapped and odd ones are the truth.
    pub splits_keyframes: bool,
    /// Why there is no map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_applicable: Option<String>,
}

/// The scores, `null` where there are none.
fn scores_or_nulls<S: serde::Serializer>(
    scores: &Option<CellScores>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    scores.unwrap_or_default().serialize(serializer)
}

impl MapRow {
    /// A row without a map.
    #[must_use]
    pub fn new(recording: &str, method: &'static str) -> Self {
        Self {
            recording: recording.to_owned(),
            method,
            poses: "",
            cell_m: None,
            scores: None,
            map_cells: None,
            seconds: None,
            peak_bytes: None,
            splits_keyframes: false,
            not_applicable: None,
        }
    }

    /// Lines for a small picture of the map.
    #[must_use]
    pub fn label(&self) -> String {
        let even = if self.splits_keyframes { " (even)" } else { "" };
        let name = format!("{}{even}", self.method);
        let scores = self.scores.as_ref();
        scores.map_or_else(|| self.method.to_owned(), |scores| scores.label(&name))
    }
}
