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
    points(
        cells
            .map(|(cell, is_occupied)| (p_occ(cell), is_occupied))
            .collect(),
    )
}

fn points(mut ranked: Vec<(f32, bool)>) -> Vec<(f64, f64)> {
    ranked.sort_by(|one, other| other.0.total_cmp(&one.0));
    let of = |cells: &[(f32, bool)]| {
        let occupied = cells.iter().filter(|(_, is_occupied)| *is_occupied).count();
        (occupied as f64, (cells.len() - occupied) as f64)
    };
    let (occupied, free) = of(&ranked);
    if occupied * free < 0.5 {
        return Vec::new();
    }
    let (mut hits, mut false_hits) = (0.0, 0.0);
    let mut points = vec![(0.0, 0.0)];
    for tied in ranked.chunk_by(|one, other| one.0.total_cmp(&other.0).is_eq()) {
        let (more, more_false) = of(tied);
        hits += more;
        false_hits += more_false;
        points.push((false_hits / free, hits / occupied));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_probability_is_one_point_and_the_last_is_everything() {
        let ranked = vec![(0.9, true), (0.9, false), (0.7, true), (0.1, false)];
        let expected = [(0.0, 0.0), (0.5, 0.5), (0.5, 1.0), (1.0, 1.0)];
        assert_eq!(points(ranked), expected);
        assert!(points(vec![(0.3, true)]).is_empty());
    }
}
