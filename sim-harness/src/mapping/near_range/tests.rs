//! What single readings count.

use super::*;
use crate::mapping::Occupancy;
use crate::mapping::test_drives::{echo, forward, no_echo, scan_of, sonar};

fn mapped(returns: &[Return]) -> NearRangeMapper {
    let rig = forward(sonar());
    let mut mapper = NearRangeMapper::new(0.1, &rig);
    for measured in returns {
        mapper.take(&scan_of(&rig, (0.0, 0.05, 0.0), vec![*measured]));
    }
    mapper.finish(&mut |_| {});
    mapper
}

/// The score of the cell on the axis about a distance.
fn at(mapper: &NearRangeMapper, x: f64) -> Option<f64> {
    let cell = mapper.scores.cell_at(x, 0.05).unwrap();
    mapper.scores.get(cell).copied().flatten()
}

#[test]
fn a_near_reading_marks_its_arc_and_frees_the_way_to_it() {
    let mapper = mapped(&[echo(1.05)]);
    assert_eq!(at(&mapper, 1.05), Some(1.0));
    // On the axis a pass outweighs four hits.
    assert_eq!(at(&mapper, 0.55), Some(-4.0));
    assert_eq!(at(&mapper, 1.35), None);
    let off_axis = mapper.scores.cell_at(0.95, 0.15).unwrap();
    let share = libm::atan2(0.1, 0.95) / 12.5_f64.to_radians();
    let expected = -4.0 * libm::exp(-1.5 * share * share);
    let found = mapper.scores.get(off_axis).copied().flatten().unwrap();
    assert!((found - expected).abs() < 1e-12, "{found}");
}

#[test]
fn a_far_reading_marks_nothing_and_what_is_far_is_free_without_a_count() {
    let mapper = mapped(&[echo(2.05)]);
    assert_eq!(at(&mapper, 2.05), Some(0.0));
    assert_eq!(at(&mapper, 1.65), Some(0.0));
    assert_eq!(at(&mapper, 1.25), Some(-4.0));
    let map = mapper.map();
    assert_eq!(map.count(Occupancy::Occupied), 0);
    assert_eq!(map.occupancy_at(2.05, 0.05), Occupancy::Free);
}

#[test]
fn a_pass_outweighs_three_hits_and_five_outweigh_it() {
    for (hits, class) in [(3, Occupancy::Free), (5, Occupancy::Occupied)] {
        let mut returns = vec![echo(1.05); hits];
        returns.push(echo(1.45));
        let forward = mapped(&returns).map();
        assert_eq!(forward.occupancy_at(1.05, 0.05), class, "{hits}");
        returns.reverse();
        let backward = mapped(&returns).map();
        for (cell, belief) in forward.iter() {
            let other = backward.get(cell).map_or(0.5, Belief::p_occ);
            assert!(
                (belief.p_occ() - other).abs() < 1e-6,
                "{cell:?}: the order matters"
            );
        }
    }
}

#[test]
fn light_has_its_own_constants_and_returns_without_an_echo_are_passed_over() {
    let light = NearRangeParameters::of(Directivity::Flat);
    assert!((light.score(1.9, 0.9, 2.0) + 4.0).abs() < 1e-12);
    assert!((light.score(1.05, 0.9, 1.05) - 1.0).abs() < 1e-12);
    for silent in [no_echo(5.0), Return::TooClose, Return::Invalid] {
        assert_eq!(mapped(&[silent]).map().iter().count(), 0, "{silent:?}");
    }
}
