//! Filtered and batch methods of sonar echoes on the committed drive, by the cells and
//! likelihoods of an independent implementation.

use sim_harness::datasets::{DriveFile, Kcma, PoseSource};
use sim_harness::drive::{Keyframes, Record};
use sim_harness::mapping::{
    ApproximateLikelihoodMapper, ConsistentEchoMapper, EchoFilter, InverseSensorMapper,
    InverseSensorParameters, LikelihoodMapper, LikelihoodParameters, Map, Mapper, Method,
    Objective, Occupancy, Setup,
};
use sim_harness::pipeline::{self, DriveOptions};
use sim_harness::rig::Rig;

use crate::common::root;

const CELL_M: f64 = 0.1;

fn kcma() -> Rig {
    Rig::load(&root().join("rigs/kcma.toml")).unwrap()
}

/// The keyframes of the drive, by its raw odometry.
fn records() -> Vec<Record> {
    let rig = kcma();
    let drive = DriveFile {
        path: &root().join("sim-harness/tests/data/robond"),
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
    };
    let options = DriveOptions {
        keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
        mounts: vec!["sonar".to_owned()],
    };
    let mut records = Vec::new();
    let mut take = |record: &Record| records.push(record.clone());
    pipeline::dataset_records(&Kcma, &drive, &options, &mut |_, _| {}, &mut take).unwrap();
    records
}

fn fill(mapper: &mut dyn Mapper, records: &[Record]) -> Map {
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper.map()
}

fn counts(map: &Map) -> (usize, usize) {
    (map.count(Occupancy::Occupied), map.count(Occupancy::Free))
}

#[test]
fn g18_filtered_and_approximate_maps_have_the_published_number_of_cells() {
    let (rig, records) = (kcma(), records());
    for (name, expected) in [
        ("ism-cesp", (1576, 7220)),
        ("mal", (947, 12_990)),
        ("cemal", (1217, 7751)),
    ] {
        let method: Method = name.parse().unwrap();
        let mut mapper = method.mapper(&Setup::new(&rig, CELL_M));
        assert!(!mapper.is_online());
        let map = fill(&mut mapper, &records);
        assert_eq!(counts(&map), expected, "{name}");
        assert_eq!(map.refused(), 0);
    }
}

#[test]
fn g18_the_filter_keeps_539_of_1038_echoes() {
    let (rig, records) = (kcma(), records());
    let ism = InverseSensorMapper::new(CELL_M, &rig, InverseSensorParameters::RANGE);
    let mut filtered = ConsistentEchoMapper::new(ism, CELL_M, &rig, CELL_M);
    fill(&mut filtered, &records);
    let mut cemal =
        ApproximateLikelihoodMapper::new(CELL_M, &rig, EchoFilter::Consistent, CELL_M, false);
    fill(&mut cemal, &records);
    for judgement in [filtered.judgement(), cemal.judgement()] {
        assert_eq!(judgement.kept, 539);
        assert_eq!(judgement.removed_arcs, 128);
        assert_eq!(judgement.removed_wedges, 371);
        assert_eq!(judgement.rounds, 2);
    }
}

#[test]
fn the_map_without_a_filter_is_that_of_the_scans_in_any_order() {
    let (rig, mut records) = (kcma(), records());
    let map = |name: &str, records: &[Record]| {
        let method: Method = name.parse().unwrap();
        let map = fill(&mut method.mapper(&Setup::new(&rig, CELL_M)), records);
        let cells = |class| map.cells_of(class).collect::<Vec<_>>();
        (cells(Occupancy::Occupied), cells(Occupancy::Free))
    };
    let expected = ["mal", "cemal"].map(|name| map(name, &records));
    // A permutation: the step has no factor in common with their number.
    let count = records.len();
    assert_eq!(count, 2 * 187);
    records = (0..count)
        .map(|it| records[it * 35 % count].clone())
        .collect();
    assert_eq!(["mal", "cemal"].map(|name| map(name, &records)), expected);
}

/// A search that follows thousands of decisions: rounding may flip one.
fn assert_near(found: usize, expected: usize, what: &str) {
    let most = expected / 50;
    assert!(
        found.abs_diff(expected) <= most,
        "{what}: {found}, not {expected}"
    );
}

#[test]
fn g18_searches_climb_to_the_published_likelihoods() {
    let (rig, records) = (kcma(), records());
    let (soft, hard) = (Objective::Soft, Objective::Hard);
    let all = EchoFilter::None;
    for (objective, filter, start, values, cells) in [
        (
            soft,
            all,
            -4780.167,
            vec![-1244.880, 300.925, 340.063, 347.036, 348.170, 348.566],
            Some((1603, 12_334)),
        ),
        (
            soft,
            EchoFilter::Consistent,
            -2482.187,
            vec![169.168, 467.472, 474.200, 475.047, 475.047],
            Some((1287, 7681)),
        ),
        (hard, all, -4780.167, vec![-10.062], None),
    ] {
        let parameters = LikelihoodParameters::STANDARD.with(objective);
        let mut mapper = LikelihoodMapper::new(CELL_M, &rig, filter, parameters);
        let map = fill(&mut mapper, &records);
        let what = format!("{objective:?}, {filter:?}: {:?}", mapper.sweeps());
        assert!((mapper.start() - start).abs() < 1e-3, "{what}");
        let found = mapper.sweeps().iter().map(|sweep| sweep.log_likelihood);
        let found: Vec<f64> = found.collect();
        assert!(found.is_sorted(), "{what}");
        if let Some((occupied, free)) = cells {
            assert_near(map.count(Occupancy::Occupied), occupied, &what);
            assert_near(map.count(Occupancy::Free), free, &what);
            assert_eq!(found.len(), values.len(), "{what}");
            for (found, expected) in found.iter().zip(&values) {
                assert!((found - expected).abs() < 1.0, "{what}");
            }
        } else {
            assert_near(map.count(Occupancy::Occupied), 1089, &what);
            let (last, expected) = (found.last(), values.last());
            assert!(
                last.zip(expected).is_some_and(|(a, b)| (a - b).abs() < 1.0),
                "{what}"
            );
        }
    }
}
