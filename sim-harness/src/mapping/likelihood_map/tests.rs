//! The search on the toy scene against tabulated likelihoods.

use super::search::FlipTrial;
use super::*;
use crate::drive::Return;
use crate::lattice::Cell;
use crate::mapping::Occupancy;
use crate::mapping::toy_scene::{self, CELL_M};
use crate::sensors::Directivity;

const STANDARD: LikelihoodParameters = LikelihoodParameters::STANDARD;

fn mapper(parameters: LikelihoodParameters, records: &[Record]) -> LikelihoodMapper {
    let rig = toy_scene::rig(Directivity::Piston);
    let mut mapper = LikelihoodMapper::new(CELL_M, &rig, EchoFilter::None, parameters);
    records.iter().for_each(|record| mapper.take(record));
    mapper
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
}

/// Checks start, sweeps and occupied cells of the toy scene, twice.
fn assert_searched(objective: Objective, flips: &[usize], values: &[f64], occupied: usize) {
    let mut mapper = mapper(STANDARD.with(objective), &toy_scene::records());
    assert_eq!(mapper.map().iter().count(), 0, "before the end");
    for _ in 0..2 {
        mapper.finish(&mut |_| {});
        near(mapper.start(), -18.420_680_744);
        let found: Vec<usize> = mapper.sweeps().iter().map(|sweep| sweep.flips).collect();
        assert_eq!(found, flips, "{:?}", mapper.sweeps());
        for (sweep, expected) in mapper.sweeps().iter().zip(values) {
            near(sweep.log_likelihood, *expected);
        }
        let map = mapper.map();
        assert_eq!(map.count(Occupancy::Occupied), occupied);
        // 55 + 55 + 55 + 159 pairs are of 233 cells, all known.
        assert_eq!(map.count(Occupancy::Free), 233 - occupied);
    }
}

#[test]
fn g15_the_soft_search_climbs_as_tabulated() {
    let values = [
        0.528_516_682,
        2.509_400_975,
        2.611_964_966,
        2.861_345_053,
        2.892_271_738,
        2.892_271_738,
    ];
    assert_searched(Objective::Soft, &[43, 13, 3, 4, 1, 0], &values, 40);
}

#[test]
fn g15_the_hard_search_climbs_as_tabulated() {
    let values = [2.149_398_447, 2.565_065_894, 2.673_189_177, 2.673_189_177];
    assert_searched(Objective::Hard, &[24, 2, 2, 0], &values, 22);
}

/// The cells of a block that are occupied in the best of all its maps, and its likelihood.
/// Cells of the block that are in no cone change nothing.
fn best_of_block(readings: &ConeReadings, block: &[Cell]) -> (Vec<Cell>, f64) {
    let is_used = vec![true; readings.readings().len()];
    let cells = readings.cells();
    let numbers: Vec<usize> = (0..cells.len())
        .filter(|number| block.contains(&cells[*number]))
        .collect();
    let mut best = (Vec::new(), f64::NEG_INFINITY);
    for map in 0..1_usize << numbers.len() {
        let mut search = Search::new(readings, &is_used, &STANDARD);
        let is_occupied = |place: &usize| map >> place & 1 == 1;
        let occupied = (0..numbers.len()).filter(is_occupied);
        let occupied: Vec<usize> = occupied.map(|place| numbers[place]).collect();
        occupied.iter().for_each(|cell| search.set_occupied(*cell));
        let value = search.log_likelihood();
        if value > best.1 {
            best = (occupied, value);
        }
    }
    let mut occupied: Vec<Cell> = best.0.into_iter().map(|number| cells[number]).collect();
    occupied.sort_unstable();
    (occupied, best.1)
}

#[test]
fn g15_the_search_is_at_least_as_good_as_the_best_map_of_a_block() {
    let records = &toy_scene::records()[..2];
    let mut mapper = mapper(STANDARD, records);
    mapper.finish(&mut |_| {});
    near(mapper.start(), -9.210_340_372);
    let last = mapper.sweeps().last().unwrap().log_likelihood;
    near(last, 2.219_364_756);
    let block = toy_scene::block(19..=21, 13..=15);
    let (cells, value) = best_of_block(&mapper.readings, &block);
    near(value, 1.232_461_073);
    assert_eq!(cells, toy_scene::block(19..=20, 13..=15));
    assert!(last >= value);
}

#[test]
fn the_likelihood_never_decreases_and_is_that_of_the_map() {
    let scans = (0..30_u32).map(|number| {
        let x = 0.07 * f64::from(number);
        let range_m = 2.5 - x + if number % 4 == 0 { 1.1 } else { 0.0 };
        let y = 0.11 * f64::from(number % 7);
        toy_scene::scan(u64::from(number), [x, y], toy_scene::echo(range_m))
    });
    let records: Vec<Record> = scans.collect();
    for objective in [Objective::Soft, Objective::Hard] {
        let parameters = STANDARD.with(objective);
        let mapper = mapper(parameters, &records);
        let is_used = vec![true; records.len()];
        let mut search = Search::new(&mapper.readings, &is_used, &parameters);
        let mut trial = FlipTrial::default();
        let mut last = search.log_likelihood();
        for cell in (0..mapper.readings.cells().len()).chain(0..mapper.readings.cells().len()) {
            let is_flipped = search.try_flip(cell, &mut trial);
            let value = search.log_likelihood();
            assert!(value >= last - 1e-12, "{cell}: {last} to {value}");
            assert_eq!(is_flipped, value > last, "{cell}");
            last = value;
        }
        // From nothing, without the lists that the flips have kept.
        let mut fresh = Search::new(&mapper.readings, &is_used, &parameters);
        for (cell, is_occupied) in search.cells().into_iter().enumerate() {
            if is_occupied == Some(true) {
                fresh.set_occupied(cell);
            }
        }
        near(fresh.log_likelihood(), last);
    }
}

#[test]
fn the_order_of_scans_of_different_stamps_does_not_matter() {
    let mut records = toy_scene::records();
    let map = |records: &[Record]| {
        let mut mapper = mapper(STANDARD, records);
        mapper.finish(&mut |_| {});
        mapper
            .map()
            .cells_of(Occupancy::Occupied)
            .collect::<Vec<_>>()
    };
    let expected = map(&records);
    records.reverse();
    assert_eq!(map(&records), expected);
}

#[test]
fn a_longer_reach_knows_cells_behind_the_echo() {
    let known = |reach| {
        let parameters = LikelihoodParameters { reach, ..STANDARD };
        let mut mapper = mapper(parameters, &toy_scene::records()[..1]);
        mapper.finish(&mut |_| {});
        let map = mapper.map();
        map.count(Occupancy::Occupied) + map.count(Occupancy::Free)
    };
    assert_eq!(known(Reach::Cell), 55);
    assert!(known(Reach::Sigmas(3.0)) > 65);
}

#[test]
fn maximum_readings_free_their_cone_only_as_evidence() {
    let silent = Return::NoEcho {
        limit_m: 5.0,
        sigma_m: 0.0,
    };
    let mut records = toy_scene::records();
    let silent_scans = (4..12).map(|stamp_us| toy_scene::scan(stamp_us, [0.51, 1.53], silent));
    records.extend(silent_scans);
    let occupied = |maximum| {
        let parameters = LikelihoodParameters {
            maximum,
            ..STANDARD
        };
        let mut mapper = mapper(parameters, &records);
        mapper.finish(&mut |_| {});
        mapper.map().count(Occupancy::Occupied)
    };
    assert_eq!(occupied(MaximumReading::Dropped), 40);
    let left = occupied(MaximumReading::Evidence);
    assert!(left < 20, "{left}");
}
