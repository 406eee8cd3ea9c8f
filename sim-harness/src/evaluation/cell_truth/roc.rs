//! The receiver operating characteristic of a map.

use super::{ScoredCells, TrueCells};
use crate::mapping::Map;

/// False and true positive rate of a map whose cells are occupied above a probability, for
/// every probability that the map has, from the highest down: from (0, 0) to (1, 1).
///
/// Unknown cells have 0.5. The area below the points, joined by lines, is the AUC of
/// [`CellScores`](super::CellScores). Empty without an occupied or without a free cell.
#[must_use]
pub fn receiver_operating_characteristic(
    map: &Map,
    truth: &TrueCells,
    scored: &ScoredCells,
) -> Vec<(f64, f64)> {
    let p_occ = |cell| map.get(cell).map_or(0.5, |belief| belief.p_occ());
    let cells = scored.with_truth(truth);
    let ranked = cells.map(|(cell, is_occupied)| (p_occ(cell), is_occupied));
    points(&steps(ranked.collect()))
}

/// Free and occupied cells above each probability, from the highest down: from (0, 0) to all.
pub(super) fn steps(mut ranked: Vec<(f32, bool)>) -> Vec<(f64, f64)> {
    ranked.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut above = (0.0, 0.0);
    let mut steps = vec![above];
    for tied in ranked.chunk_by(|one, other| one.0.total_cmp(&other.0).is_eq()) {
        let occupied = tied.iter().filter(|(_, is_occupied)| *is_occupied).count();
        above.0 += (tied.len() - occupied) as f64;
        above.1 += occupied as f64;
        steps.push(above);
    }
    steps
}

fn points(steps: &[(f64, f64)]) -> Vec<(f64, f64)> {
    match steps.last() {
        Some(&(free, occupied)) if free * occupied > 0.5 => {
            let share = |&(false_hits, hits): &(f64, f64)| (false_hits / free, hits / occupied);
            steps.iter().map(share).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_probability_is_one_point_and_the_last_is_everything() {
        let ranked = vec![(0.9, true), (0.9, false), (0.7, true), (0.1, false)];
        let expected = [(0.0, 0.0), (0.5, 0.5), (0.5, 1.0), (1.0, 1.0)];
        assert_eq!(points(&steps(ranked)), expected);
        assert!(points(&steps(vec![(0.3, true)])).is_empty());
    }
}
