//! What single readings count, and the score of a cell.

use super::*;
use crate::mapping::Occupancy;
use crate::mapping::test_drives::{echo, forward, no_echo, robond, scan_of, sonar};

const SONAR: BearingBinParameters = BearingBinParameters::SONAR;

fn mapped(returns: &[Return]) -> BearingBinMapper {
    let rig = forward(sonar());
    let mut mapper = BearingBinMapper::new(0.1, &rig);
    for measured in returns {
        mapper.take(&scan_of(&rig, (0.0, 0.05, 0.0), vec![*measured]));
    }
    mapper.finish(&mut |_| {});
    mapper
}

/// The bins of the cell on the axis about a distance.
fn at(mapper: &BearingBinMapper, x: f64) -> Option<&[Bin]> {
    let cell = mapper.cells.cell_at(x, 0.05).unwrap();
    mapper.cells.get(cell).and_then(Option::as_deref)
}

#[test]
fn hits_and_passes_weigh_the_trust_in_their_distance_in_the_bin_of_their_bearing() {
    let mapper = mapped(&[echo(0.55)]);
    let hit = at(&mapper, 0.55).unwrap();
    assert!((f64::from(hit[0].hits) - SONAR.trust(0.55)).abs() < 1e-6);
    assert!(hit[0].passes.abs() < 1e-9 && hit[1..].iter().all(|bin| *bin == Bin::default()));
    let pass = at(&mapper, 0.25).unwrap();
    assert!((f64::from(pass[0].passes) - SONAR.trust(0.25)).abs() < 1e-6);
    assert!((SONAR.trust(SONAR.trust_range_m) - 0.5).abs() < 1e-12);
    // Known a margin beyond the reading, without a count there.
    assert!(at(&mapper, 0.65).is_some() && at(&mapper, 0.85).is_none());
}

#[test]
fn bins_go_around_the_circle() {
    for (degrees, bin) in [
        (0.0, 0),
        (14.9, 0),
        (15.1, 1),
        (-0.1, 23),
        (180.1, 12),
        (360.0, 0),
    ] {
        assert_eq!(SONAR.bin(f64::to_radians(degrees)), bin, "{degrees}");
    }
    assert_eq!(SONAR.bin(-1e-18), 0, "rounding to a whole turn");
}

#[test]
fn the_score_follows_the_closed_form() {
    let mut bins = [Bin::default(); 24];
    let score = |bins: &[Bin]| SONAR.score(bins);
    bins[3].hits = 0.2;
    assert!((score(&bins) - 0.2).abs() < 1e-6);
    bins[3].hits = 5.0;
    assert!(
        (score(&bins) - 0.329).abs() < 1e-6,
        "hits count up to a limit"
    );
    // A pass from the other side, and one from where the hits were.
    bins[15].passes = 0.1;
    assert!((score(&bins) - (0.329 - 0.512 * 0.1)).abs() < 1e-6);
    bins[15].passes = 0.0;
    bins[3].passes = 0.1;
    assert!((score(&bins) - (0.329 - 1.747 * 0.1)).abs() < 1e-6);
    // From beside them: half of the hits support it, across the circle's end too.
    bins = [Bin::default(); 24];
    bins[0].hits = 0.2;
    bins[23].passes = 0.1;
    let weight = 0.512 + (1.747 - 0.512) * 0.1 / 0.608;
    assert!((score(&bins) - (0.2 - weight * 0.1)).abs() < 1e-6);
}

#[test]
fn a_return_without_an_echo_passes_up_to_three_metres() {
    let mapper = mapped(&[no_echo(5.0)]);
    assert!(at(&mapper, 2.85).is_some() && at(&mapper, 3.05).is_none());
    let map = mapper.map();
    assert_eq!(map.count(Occupancy::Occupied), 0);
    assert!(map.count(Occupancy::Free) > 100);
    for silent in [Return::TooClose, Return::Invalid] {
        assert_eq!(mapped(&[silent]).map().iter().count(), 0, "{silent:?}");
    }
}

#[test]
fn repeated_readings_of_a_wall_make_it_occupied_and_those_beyond_it_free() {
    let map = mapped(&[echo(0.55); 10]).map();
    assert_eq!(map.occupancy_at(0.55, 0.05), Occupancy::Occupied);
    assert_eq!(map.occupancy_at(0.25, 0.05), Occupancy::Free);
    let mut returns = vec![echo(0.55)];
    returns.extend([echo(1.55); 10]);
    let map = mapped(&returns).map();
    assert_eq!(map.occupancy_at(0.55, 0.05), Occupancy::Free);
}

#[test]
fn the_order_of_the_records_does_not_matter_but_for_rounding() {
    let (rig, mut records) = robond();
    let mut maps = Vec::new();
    for _ in 0..2 {
        let mut mapper = BearingBinMapper::new(0.1, &rig);
        records.iter().for_each(|record| mapper.take(record));
        maps.push(mapper.map());
        records.reverse();
    }
    for (cell, belief) in maps[0].iter() {
        let other = maps[1].get(cell).map_or(0.5, Belief::p_occ);
        assert!((belief.p_occ() - other).abs() < 1e-5, "{cell:?}");
    }
}
