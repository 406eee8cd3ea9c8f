//! The scores of a map in the cells that the sensors looked at.

use serde::Serialize;

use super::roc::steps;
use super::{ScoredCells, TrueCell, TrueCells};
use crate::lattice::Cell;
use crate::mapping::{Map, Occupancy};

/// How well a map fits the truth, cell by cell.
///
/// P and N are the truly occupied and free cells that are scored; TP and FP those of P and N
/// that the map has as occupied, FN and TN as free; U is unknown in the map. Ratios are
/// `None` where their denominator is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CellScores {
    /// (FP + P - TP) / (P + N): unknown counts as not occupied.
    pub oe: Option<f64>,
    /// (FP + FN) / (TP + FP + FN + TN): unknown is left out.
    pub oe_classified: Option<f64>,
    /// TP / P.
    pub tpr: Option<f64>,
    /// FP / N.
    pub fpr: Option<f64>,
    /// Probability that a cell of P has a higher p_occ than one of N, ties half (Mann and
    /// Whitney 1947); unknown has 0.5. For a map of two values it is one point of the curve.
    pub auc: Option<f64>,
    /// 1 - U / (P + N).
    pub coverage: Option<f64>,
    /// Share of P with an occupied cell among itself and its eight neighbours.
    pub tpr1: Option<f64>,
    /// Share of N that is occupied in the map, with no truly occupied cell next to it.
    pub fpr1: Option<f64>,
    /// P + N.
    pub mask_cells: u64,
}

/// The meaning of the scores, one line each.
pub const CELL_SCORES_IN_WORDS: &str = "\
OE: share of the scored cells that are wrong; unknown counts as not occupied. OEc: the same of
    the classified cells alone. Scored are the cells in the footprint of an echo, the same for
    all methods, whose truth is known.
TPR, FPR: share of the truly occupied, and of the truly free cells, that are occupied.
AUC: probability that an occupied cell has the higher p_occ than a free one; 0.5 is chance.
Cover: share of the scored cells that is classified. TPR1, FPR1: with one cell of tolerance.
all-free: the map that is free everywhere. Its error is low: no error says much alone.";

impl CellScores {
    /// Lines for a small picture of the map of a name.
    #[must_use]
    pub fn label(&self, name: &str) -> String {
        let number = |share: Option<f64>| {
            share.map_or_else(|| "-".to_owned(), |share| format!("{share:.3}"))
        };
        format!(
            "{name}\nOE {} AUC {}\nTPR {} FPR {}",
            number(self.oe),
            number(self.auc),
            number(self.tpr),
            number(self.fpr)
        )
    }

    /// Scores a map.
    #[must_use]
    pub fn of(map: &Map, truth: &TrueCells, scored: &ScoredCells) -> Self {
        let class = |cell| map.occupancy(cell);
        let p_occ = |cell| map.get(cell).map_or(0.5, |belief| belief.p_occ());
        Self::count(truth, scored, class, p_occ)
    }

    /// Scores the map that is free in every cell.
    #[must_use]
    pub fn of_all_free(truth: &TrueCells, scored: &ScoredCells) -> Self {
        Self::count(truth, scored, |_| Occupancy::Free, |_| 0.0)
    }

    fn count(
        truth: &TrueCells,
        scored: &ScoredCells,
        class: impl Fn(Cell) -> Occupancy,
        p_occ: impl Fn(Cell) -> f32,
    ) -> Self {
        let mut counts = CellCounts::default();
        let mut ranked = Vec::new();
        for (cell, is_occupied) in scored.with_truth(truth) {
            let found = class(cell);
            counts.add(is_occupied, found);
            ranked.push((p_occ(cell), is_occupied));
            let is_hit = |cell| class(cell) == Occupancy::Occupied;
            let is_true = |cell| truth.get(cell) == Some(&TrueCell::Occupied);
            if is_occupied {
                counts.near_hits += u64::from(with_neighbours(cell).any(is_hit));
            } else if found == Occupancy::Occupied {
                counts.ghosts += u64::from(!with_neighbours(cell).any(is_true));
            }
        }
        Self {
            auc: auc(ranked),
            ..counts.scores()
        }
    }
}

/// Scored cells by truth and class.
#[derive(Clone, Copy, Debug, Default)]
struct CellCounts {
    true_positive: u64,
    false_negative: u64,
    unknown_occupied: u64,
    false_positive: u64,
    true_negative: u64,
    unknown_free: u64,
    near_hits: u64,
    ghosts: u64,
}

impl CellCounts {
    fn add(&mut self, is_occupied: bool, found: Occupancy) {
        *match (is_occupied, found) {
            (true, Occupancy::Occupied) => &mut self.true_positive,
            (true, Occupancy::Free) => &mut self.false_negative,
            (true, Occupancy::Unknown) => &mut self.unknown_occupied,
            (false, Occupancy::Occupied) => &mut self.false_positive,
            (false, Occupancy::Free) => &mut self.true_negative,
            (false, Occupancy::Unknown) => &mut self.unknown_free,
        } += 1;
    }

    fn scores(&self) -> CellScores {
        let occupied = self.true_positive + self.false_negative + self.unknown_occupied;
        let free = self.false_positive + self.true_negative + self.unknown_free;
        let all = occupied + free;
        let unknown = self.unknown_occupied + self.unknown_free;
        let ratio = |part: u64, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        CellScores {
            oe: ratio(self.false_positive + occupied - self.true_positive, all),
            oe_classified: ratio(self.false_positive + self.false_negative, all - unknown),
            tpr: ratio(self.true_positive, occupied),
            fpr: ratio(self.false_positive, free),
            auc: None,
            coverage: ratio(all - unknown, all),
            tpr1: ratio(self.near_hits, occupied),
            fpr1: ratio(self.ghosts, free),
            mask_cells: all,
        }
    }
}

/// A cell and its eight neighbours.
fn with_neighbours(cell: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |row| {
        (-1..=1).map(move |column| Cell {
            row: cell.row + row,
            column: cell.column + column,
        })
    })
}

/// The Mann-Whitney statistic over the number of pairs; `None` without a pair.
fn auc(ranked: Vec<(f32, bool)>) -> Option<f64> {
    let steps = steps(ranked);
    let &(free, occupied) = steps.last()?;
    // Of each step, the free cells beside the occupied ones above them, and half of those
    // beside them.
    let pairs = steps.iter().zip(steps.iter().skip(1));
    let in_order = pairs.map(|(before, after)| (after.0 - before.0) * (before.1 + after.1) / 2.0);
    (free * occupied > 0.0).then(|| in_order.sum::<f64>() / (free * occupied))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn g14_scores_of_twenty_cells() {
        let counts = CellCounts {
            true_positive: 3,
            false_positive: 2,
            false_negative: 1,
            true_negative: 10,
            unknown_occupied: 1,
            unknown_free: 3,
            ..CellCounts::default()
        };
        let scores = counts.scores();
        let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-9;
        assert!(near(scores.oe_classified, 0.1875));
        assert!(near(scores.oe, 0.2));
        assert!(near(scores.tpr, 0.6));
        assert!(near(scores.fpr, 0.133_333_333));
        assert!(near(scores.coverage, 0.8));
        // As paper 001 words it, the rate has the occupied cells that are called free above
        // the line and the free cells below: another number.
        let as_printed = counts.false_negative as f64 / 15.0;
        assert!((as_printed - 0.133_333_333).abs() > 0.05);
        assert_eq!(CellCounts::default().scores().oe, None);
    }

    #[test]
    fn auc_is_the_share_of_pairs_in_order_with_ties_half() {
        let perfect = [(0.1, false), (0.9, true), (0.2, false), (0.8, true)];
        assert_eq!(auc(perfect.to_vec()), Some(1.0));
        let tied = [(0.5, false), (0.5, true)];
        assert_eq!(auc(tied.to_vec()), Some(0.5));
        // Of 2 x 3 pairs: 0.4 above 0.1 and 0.3, 0.3 above 0.1 and tied with 0.3.
        let mixed = [
            (0.1, false),
            (0.3, false),
            (0.7, false),
            (0.4, true),
            (0.3, true),
        ];
        assert_eq!(auc(mixed.to_vec()), Some(3.5 / 6.0));
        assert_eq!(auc(vec![(0.3, true)]), None);
    }
}
