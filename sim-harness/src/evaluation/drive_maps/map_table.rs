//! The rows of a recording as text.

use core::fmt;

use super::MapRow;
use crate::evaluation::cell_truth::{CELL_SCORES_IN_WORDS, CellScores};

/// The rows of a recording as text of fixed columns: those of one set of scored cells first,
/// each set with its all-free map; then what the scores mean, and what is not applicable.
#[derive(Clone, Copy, Debug)]
pub struct MapTable<'a> {
    /// The rows.
    pub rows: &'a [MapRow],
    /// Scores of the all-free map, if there is a truth.
    pub all_free: Option<CellScores>,
    /// The same in the cells of the layers, if they are judged apart.
    pub all_free_of_split: Option<CellScores>,
}

const HEAD: &str =
    "method             OE   OEc    TPR    FPR    AUC  cover   TPR1   FPR1   cells       s     MB";

/// A number of fixed decimals, a dash for none.
fn short(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

impl MapTable<'_> {
    fn made(&self, splits: bool) -> impl Iterator<Item = &MapRow> {
        let made = self.rows.iter().filter(|row| row.seconds.is_some());
        made.filter(move |row| row.splits_keyframes == splits)
    }
}

impl fmt::Display for MapTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(all_free) = &self.all_free {
            writeln!(f, "{HEAD}")?;
            if !self.rows.iter().any(|row| row.method == "all-free") {
                write_line(f, "all-free", Some(all_free), None)?;
            }
            self.made(false).try_for_each(|row| write_row(f, row))?;
            if let Some(all_free) = &self.all_free_of_split {
                writeln!(
                    f,
                    "Layers of the even keyframes, judged by the scanner in the odd ones, in the cells \
                     that a layer knows:"
                )?;
                write_line(f, "all-free", Some(all_free), None)?;
                self.made(true).try_for_each(|row| write_row(f, row))?;
            }
            writeln!(f, "{CELL_SCORES_IN_WORDS}")?;
        } else if self.rows.len() > 1 {
            writeln!(
                f,
                "There is no truth to score the maps with: --walls gives it."
            )?;
            writeln!(f, "method         occupied    free       s     MB")?;
            self.made(false).try_for_each(|row| write_cells(f, row))?;
        }
        for row in self.rows {
            if let Some(reason) = &row.not_applicable {
                writeln!(f, "{}: not applicable: {reason}", row.method)?;
            }
        }
        Ok(())
    }
}

/// A map without a truth: its cells.
fn write_cells(f: &mut fmt::Formatter<'_>, row: &MapRow) -> fmt::Result {
    let [occupied, free] = row.map_cells.unwrap_or_default();
    let (seconds, bytes) = row.seconds.zip(row.peak_bytes).unwrap_or_default();
    let (name, megabytes) = (row.method, 1e-6 * bytes as f64);
    writeln!(
        f,
        "{name:14} {occupied:>8} {free:>7} {seconds:>7.2} {megabytes:>6.1}"
    )
}

fn write_row(f: &mut fmt::Formatter<'_>, row: &MapRow) -> fmt::Result {
    let cost = row.seconds.zip(row.peak_bytes);
    write_line(f, row.method, row.scores.as_ref(), cost)
}

fn write_line(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    scores: Option<&CellScores>,
    cost: Option<(f64, u64)>,
) -> fmt::Result {
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
    writeln!(
        f,
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
