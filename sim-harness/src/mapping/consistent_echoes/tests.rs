//! The filter on the toy scene: what is removed, and that nothing is left to remove.

use super::*;
use crate::drive::{Record, Return};
use crate::mapping::cone_readings::ReadingSelection;
use crate::mapping::toy_scene::{self, CELL_M};
use crate::mapping::{
    InverseSensorMapper, InverseSensorParameters, Mapper, Occupancy, consistent_echoes,
};
use crate::sensors::Directivity;

fn store(records: &[Record], directivity: Directivity) -> ConeReadings {
    let rig = toy_scene::rig(directivity);
    let selection = ReadingSelection {
        tolerance_m: CELL_M,
        reach_m: 0.0,
        takes_no_echo: false,
    };
    let mut readings = ConeReadings::new(toy_scene::lattice(), &rig, selection);
    for record in records {
        if let Record::Scan(scan) = record {
            readings.add(scan);
        }
    }
    readings
}

/// Echoes of a robot that drives along x, some of them over-long.
fn corridor() -> Vec<Record> {
    let scans = (0..40_u32).map(|number| {
        let x = 0.05 * f64::from(number);
        let over_long = if number % 3 == 0 { 0.9 } else { 0.0 };
        let side = 0.15 * f64::from(number % 5);
        let range_m = 3.0 - x + over_long;
        toy_scene::scan(u64::from(number), [x, side], toy_scene::echo(range_m))
    });
    scans.collect()
}

#[test]
fn g15_the_over_long_echo_is_removed_in_two_rounds() {
    for directivity in [Directivity::Piston, Directivity::Flat] {
        let judgement = judge(&store(&toy_scene::records(), directivity));
        assert_eq!(judgement.is_kept, [true, true, true, false]);
        let counts = (judgement.removed_arcs, judgement.removed_wedges);
        assert_eq!((judgement.kept, counts), (3, (0, 1)), "{directivity:?}");
        assert_eq!(judgement.rounds, 2);
    }
}

#[test]
fn no_arc_is_covered_afterwards_and_the_filter_changes_nothing_twice() {
    for directivity in [Directivity::Piston, Directivity::Flat] {
        let records = corridor();
        let readings = store(&records, directivity);
        let judgement = judge(&readings);
        let removed = judgement.removed_arcs + judgement.removed_wedges;
        assert!(removed > 0, "{judgement:?}");
        assert_eq!(judgement.kept + removed, records.len());
        let mut trial = Trial::new(&readings);
        for (number, is_kept) in judgement.is_kept.iter().enumerate() {
            if !is_kept {
                trial.remove(number);
            }
        }
        assert!((0..records.len()).all(|number| !trial.is_covered(number)));
        let kept = records.into_iter().zip(&judgement.is_kept);
        let kept = kept.filter_map(|(record, is_kept)| is_kept.then_some(record));
        let again = judge(&store(&kept.collect::<Vec<_>>(), directivity));
        assert_eq!((again.kept, again.rounds), (judgement.kept, 1));
    }
}

#[test]
fn wedges_of_one_reading_never_cover_its_own_arc() {
    let readings = store(&toy_scene::records()[..1], Directivity::Piston);
    let judgement = judge(&readings);
    assert_eq!((judgement.kept, judgement.rounds), (1, 1));
}

#[test]
fn the_map_behind_the_filter_is_that_of_the_kept_echoes() {
    let rig = toy_scene::rig(Directivity::Piston);
    let ism = InverseSensorMapper::new(CELL_M, &rig, InverseSensorParameters::RANGE);
    let mut expected = ism.clone();
    let records = toy_scene::records();
    records[..3].iter().for_each(|it| expected.take(it));
    let mut mapper = consistent_echoes::ConsistentEchoMapper::new(ism, CELL_M, &rig, CELL_M);
    records.iter().for_each(|it| mapper.take(it));
    assert_eq!(mapper.map().count(Occupancy::Free), 0, "before the end");
    for _ in 0..2 {
        mapper.finish(&mut |_| {});
        assert_eq!(mapper.map(), expected.map());
    }
    assert_eq!(mapper.judgement().kept, 3);
}

#[test]
fn returns_that_are_no_echoes_pass_the_filter_and_scanners_do_not() {
    use crate::sensors::{Scanner, Sensor};
    let mut rig = toy_scene::rig(Directivity::Piston);
    let mut laser = rig.mounts[0].clone();
    laser.sensor = Sensor::Scanner(Scanner {
        beams: 2,
        first_rad: 0.0,
        step_rad: 0.1,
        range_m: [0.05, 80.0],
        sigma_m: 0.01,
    });
    rig.mounts.push(laser);
    let silent = Return::NoEcho {
        limit_m: 5.0,
        sigma_m: 0.0,
    };
    let ism = InverseSensorMapper::new(CELL_M, &rig, InverseSensorParameters::RANGE);
    let mut mapper = consistent_echoes::ConsistentEchoMapper::new(ism, CELL_M, &rig, CELL_M);
    let echo = toy_scene::echo(1.5);
    for (mounts, returns) in [
        (0..2, vec![silent, echo, echo]),
        (0..2, vec![echo, echo, Return::TooClose]),
        (1..2, vec![echo, echo]),
    ] {
        let Record::Scan(mut scan) = toy_scene::scan(0, [0.5, 1.5], echo) else {
            panic!("a scan");
        };
        scan.mounts = mounts;
        scan.returns = returns;
        mapper.take(&Record::Scan(scan));
    }
    mapper.finish(&mut |_| {});
    let kept: Vec<Vec<Return>> = mapper
        .kept_scans()
        .into_iter()
        .map(|scan| scan.returns)
        .collect();
    let invalid = Return::Invalid;
    assert_eq!(kept[0], [silent, invalid, invalid]);
    assert_eq!(kept[1], [echo, invalid, Return::TooClose]);
    assert_eq!(kept[2], [invalid, invalid]);
}
