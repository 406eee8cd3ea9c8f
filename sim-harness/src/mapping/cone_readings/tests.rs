//! Cells of readings against the toy scene, and readings that no store can hold.

use super::*;
use crate::drive::Record;
use crate::mapping::toy_scene::{self, CELL_M, echo};
use crate::sensors::Directivity;

const SELECTION: ReadingSelection = ReadingSelection {
    tolerance_m: CELL_M,
    reach_m: 0.0,
    takes_no_echo: false,
};

fn empty(selection: ReadingSelection) -> ConeReadings {
    let rig = toy_scene::rig(Directivity::Piston);
    ConeReadings::new(toy_scene::lattice(), &rig, selection)
}

fn add(store: &mut ConeReadings, records: &[Record]) {
    for record in records {
        if let Record::Scan(scan) = record {
            store.add(scan);
        }
    }
}

fn filled(records: &[Record]) -> ConeReadings {
    let mut store = empty(SELECTION);
    add(&mut store, records);
    store
}

#[test]
fn g15_readings_of_the_toy_scene_hold_the_tabulated_cells() {
    let store = filled(&toy_scene::records());
    let counts = store.readings().iter().map(|reading| {
        let (all, arc, wedge) = (reading.pairs(), reading.at_echo(), reading.before());
        [all.len(), arc.len(), wedge.len()]
    });
    let short = [55, 13, 42];
    assert_eq!(
        counts.collect::<Vec<_>>(),
        [short, short, short, [159, 23, 136]]
    );
    let arc = store.readings()[0].at_echo();
    let mut arc: Vec<Cell> = arc.map(|pair| store.cells()[store.cell(pair)]).collect();
    arc.sort_unstable();
    let mut expected = toy_scene::block(19..=19, 12..=17);
    expected.extend(toy_scene::block(20..=20, 12..=18));
    expected.sort_unstable();
    assert_eq!(arc, expected);
}

#[test]
fn pairs_of_a_reading_are_sorted_by_distance_and_the_index_has_each_once() {
    let store = filled(&toy_scene::records());
    for reading in store.readings() {
        let ranges: Vec<f64> = reading.pairs().map(|pair| store.range_m(pair)).collect();
        assert!(ranges.is_sorted());
        for pair in reading.pairs() {
            let bearing_rad = store.bearing_rad(reading, pair);
            assert!(bearing_rad.abs() <= reading.cone.half_angle_rad + 1e-12);
        }
    }
    let index = store.index(|number| number != 1);
    let mut seen = vec![0; store.pairs()];
    for cell in 0..store.cells().len() {
        for (number, pair) in index.of_cell(cell) {
            assert_eq!(store.cell(pair), cell);
            assert!(store.readings()[number].pairs().contains(&pair));
            seen[pair] += 1;
        }
    }
    let unused = store.readings()[1].pairs();
    for (pair, count) in seen.into_iter().enumerate() {
        assert_eq!(count, i32::from(!unused.contains(&pair)), "{pair}");
    }
}

#[test]
fn readings_that_are_no_numbers_or_too_large_are_refused_and_counted() {
    let mut refused = 0;
    let mut store = empty(SELECTION);
    for (place, range_m) in [
        ([0.0, 0.0], f64::NAN),
        ([0.0, 0.0], f64::INFINITY),
        ([0.0, 0.0], -1.0),
        ([f64::NAN, 0.0], 1.0),
        ([1e30, 0.0], 1.0),
        // 16 000 x 16 000 cells around the sensor.
        ([0.0, 0.0], 800.0),
    ] {
        add(&mut store, &[toy_scene::scan(0, place, echo(range_m))]);
        refused += 1;
        assert_eq!(store.refused(), refused, "{place:?}, {range_m}");
        assert_eq!((store.readings().len(), store.pairs()), (0, 0));
    }
    add(&mut store, &toy_scene::records());
    assert_eq!((store.readings().len(), store.refused()), (4, refused));
    // A kilometre away is no place of the same grid.
    let far = toy_scene::scan(0, [1e6, 1e6], echo(1.0));
    let pairs = store.pairs();
    add(&mut store, &[far]);
    assert_eq!((store.pairs(), store.refused()), (pairs, refused + 1));
    assert_eq!(store.blank_map().refused(), refused + 1);
}

#[test]
fn a_full_store_refuses_more_pairs_and_takes_readings_that_still_fit() {
    let mut store = empty(SELECTION);
    // 55, 55 and 55 fit; 159 do not, nor do another 55.
    store.max_pairs = 3 * 55 + 20;
    add(&mut store, &toy_scene::records());
    assert_eq!((store.pairs(), store.refused()), (165, 1));
    add(&mut store, &toy_scene::records());
    assert_eq!((store.pairs(), store.refused()), (165, 5));
    add(&mut store, &[toy_scene::scan(0, [0.5, 1.5], echo(0.5))]);
    assert_eq!((store.readings().len(), store.refused()), (4, 5));
}

#[test]
fn readings_without_an_echo_are_stored_only_where_they_are_wanted() {
    let silent = Return::NoEcho {
        limit_m: 5.0,
        sigma_m: 0.0,
    };
    let records = [silent, Return::TooClose, Return::Invalid];
    let records = records.map(|measured| toy_scene::scan(0, [0.5, 1.5], measured));
    assert_eq!(filled(&records).readings().len(), 0);
    let mut store = empty(ReadingSelection {
        takes_no_echo: true,
        ..SELECTION
    });
    add(&mut store, &records);
    let reading = store.readings()[0];
    assert_eq!(store.readings().len(), 1);
    assert!(!reading.is_echo && reading.at_echo().is_empty());
    assert!((reading.range_m - 5.0).abs() < 1e-12);
    assert!(reading.before().len() > 400);
}

#[test]
fn readings_go_by_stamp_and_keep_their_order_within_one() {
    let at = |stamp_us| toy_scene::scan(stamp_us, [0.5, 1.5], echo(1.0));
    let store = filled(&[at(7), at(3), at(7), at(1)]);
    assert_eq!(store.by_time(), [3, 1, 0, 2]);
}
