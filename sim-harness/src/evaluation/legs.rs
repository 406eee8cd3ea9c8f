//! The nearly straight legs of a path.

use core::ops::Range;

use crate::world::Vector;

/// How far a leg may stray from the straight line between its ends, metres: the
/// robot's radius. A straight wall cannot follow a path that strays further.
const STRAY_M: f64 = 0.050;

/// Splits a path at its bends; each leg is a range of segments, in order.
///
/// By Douglas and Peucker (1973): a leg that strays too far is split at the place
/// that strays furthest. A path without a segment has no leg.
pub(super) fn legs(path: &[Vector]) -> Vec<Range<usize>> {
    let mut legs = Vec::new();
    let whole = 0..path.len().saturating_sub(1);
    let mut rest = Vec::from([whole]);
    while let Some(leg) = rest.pop() {
        match bend(path, &leg) {
            // The later half waits while the earlier is looked at: legs stay in order.
            Some(bend) => rest.extend([bend..leg.end, leg.start..bend]),
            None if leg.is_empty() => {}
            None => legs.push(leg),
        }
    }
    legs
}

/// The inner place of a leg that strays furthest, if it strays too far.
fn bend(path: &[Vector], leg: &Range<usize>) -> Option<usize> {
    let (from, to) = (*path.get(leg.start)?, *path.get(leg.end)?);
    let (place, stray_m) = (leg.start + 1..leg.end)
        .filter_map(|place| Some((place, path.get(place)?.distance_from_segment(from, to))))
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (stray_m > STRAY_M).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(places: &[(f64, f64)]) -> Vec<Vector> {
        places.iter().map(|(x, y)| Vector::new(*x, *y)).collect()
    }

    #[test]
    fn a_corner_splits_a_path_and_a_wobble_does_not() {
        let corner = path(&[(0.0, 0.0), (0.3, 0.01), (0.6, 0.0), (0.6, 0.3), (0.61, 0.6)]);
        assert_eq!(legs(&corner), [0..2, 2..4]);
        let wobble = path(&[(0.0, 0.0), (0.2, 0.049), (0.4, -0.049), (0.6, 0.0)]);
        assert_eq!(legs(&wobble).len(), 1);
    }

    #[test]
    fn there_and_back_are_two_legs() {
        assert_eq!(
            legs(&path(&[(0.0, 0.0), (0.5, 0.0), (0.0, 0.0)])),
            [0..1, 1..2]
        );
    }

    #[test]
    fn a_place_is_no_path() {
        assert!(legs(&path(&[(0.0, 0.0)])).is_empty());
        assert!(legs(&[]).is_empty());
    }
}
