//! The table of the methods that mapped a recording.

use serde::Serialize;
use sim_harness::console;
use sim_harness::evaluation::cell_truth::{CELL_SCORES_IN_WORDS, CellScores};

/// A recording and a method: a row of the table, and of the file of `--json`.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MapRow {
    pub(super) recording: String,
    pub(super) method: &'static str,
    /// `None` without a truth, or without a map.
    #[serde(flatten, serialize_with = "scores_or_nulls")]
    pub(super) scores: Option<CellScores>,
    /// Time of the pass over the recording and of the method.
    pub(super) seconds: Option<f64>,
    /// Most memory on the heap.
    pub(super) peak_bytes: Option<u64>,
    /// Whether even keyframes are mapped and odd ones are the truth.
    pub(super) splits_keyframes: bool,
    /// Why there is no map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) not_applicable: Option<String>,
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
    pub(super) fn new(recording: &str, method: &'static str) -> Self {
        Self {
            recording: recording.to_owned(),
            method,
            scores: None,
            seconds: None,
            peak_bytes: None,
            splits_keyframes: false,
            not_applicable: None,
        }
    }

    /// Lines for a small picture of the map.
    pub(super) fn label(&self) -> String {
        let number = |value: Option<f64>| short(value, 3);
        match &self.scores {
            None => self.method.to_owned(),
            Some(scores) => format!(
                "{}{}\nOE {} AUC {}\nTPR {} FPR {}",
                self.method,
                if self.splits_keyframes { " (even)" } else { "" },
                number(scores.oe),
                number(scores.auc),
                number(scores.tpr),
                number(scores.fpr)
            ),
        }
    }
}

/// A number of fixed decimals, a dash for none.
fn short(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

const HEAD: &str =
    "method             OE   OEc    TPR    FPR    AUC  cover   TPR1   FPR1   cells       s     MB";

/// Prints the rows: those of one set of scored cells first, each set with its all-free map.
pub(super) fn print(
    rows: &[MapRow],
    all_free: Option<CellScores>,
    all_free_of_split: Option<CellScores>,
) {
    let made = |splits: bool| {
        let made = rows.iter().filter(|row| row.seconds.is_some());
        made.filter(move |row| row.splits_keyframes == splits)
    };
    if let Some(all_free) = &all_free {
        console::print(HEAD);
        if !rows.iter().any(|row| row.method == "all-free") {
            console::print(line("all-free", Some(all_free), None));
        }
        made(false).for_each(|row| console::print(of_row(row)));
        if let Some(all_free) = &all_free_of_split {
            console::print(
                "Layers of the even keyframes, judged by the scanner in the odd ones, in the cells \
                 that a layer knows:",
            );
            console::print(line("all-free", Some(all_free), None));
            made(true).for_each(|row| console::print(of_row(row)));
        }
        console::print_text(CELL_SCORES_IN_WORDS);
    } else if rows.len() > 1 {
        console::print("There is no truth to score the maps with: --walls gives it.");
        made(false).for_each(|row| console::print(of_row(row)));
    }
    for row in rows {
        if let Some(reason) = &row.not_applicable {
            console::print(format_args!("{}: not applicable: {reason}", row.method));
        }
    }
}

fn of_row(row: &MapRow) -> String {
    let cost = row.seconds.zip(row.peak_bytes);
    line(row.method, row.scores.as_ref(), cost)
}

fn line(name: &str, scores: Option<&CellScores>, cost: Option<(f64, u64)>) -> String {
    let number = |of: fn(&CellScores) -> Option<f64>| short(scores.and_then(of), 3);
    let cells = scores.map_or_else(|| "-".to_owned(), |scores| scores.mask_cells.to_string());
    let (seconds, megabytes) = cost.map_or_else(
        || ("-".to_owned(), "-".to_owned()),
        |(seconds, bytes)| {
            (
                format!("{seconds:.2}"),
                format!("{:.1}", 1e-6 * bytes as f64),
            )
        },
    );
    format!(
        "{name:14} {:>6} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {cells:>7} {seconds:>7} {megabytes:>6}",
        number(|it| it.oe),
        number(|it| it.oe_classified),
        number(|it| it.tpr),
        number(|it| it.fpr),
        number(|it| it.auc),
        number(|it| it.coverage),
        number(|it| it.tpr1),
        number(|it| it.fpr1)
    )
}
