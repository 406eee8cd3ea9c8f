//! Filtered and batch methods of sonar echoes on the committed drive, by the cells and
//! likelihoods of an independent implementation, to all printed digits.

use proptest::prelude::*;
use sim_harness::datasets::{DriveFile, Kcma, PoseSource};
use sim_harness::drive::{Keyframes, RangeScan, Record, Return};
use sim_harness::geometry::Pose2;
use sim_harness::mapping::{
    ApproximateLikelihoodMapper, ConsistentEchoMapper, EchoFilter, InverseSensorMapper,
    InverseSensorParameters, LikelihoodMapper, LikelihoodParameters, Map, Mapper, Method, NoEcho,
    Objective, Occupancy, Setup,
};
use sim_harness::pipeline::{self, DriveOptions, KeyframeShare};
use sim_harness::rig::Rig;

use crate::common::root;

const CELL_M: f64 = 0.1;

const METHODS: [Method; 7] = [
    Method::ISM_CESP,
    Method::ISM_DECAY_CESP,
    Method::FSM,
    Method::FSM_HARD,
    Method::FSM_CESP,
    Method::MAL,
    Method::CEMAL,
];

fn kcma() -> Rig {
    Rig::load(&root().join("rigs/kcma.toml")).unwrap()
}

/// The robot with its sonars where the published numbers have them, on rays from the origin.
/// The file rounds their places to a micrometre: that moves one cell of one echo over the
/// edge of its cone.
fn unrounded() -> Rig {
    let mut rig = kcma();
    let from_origin_m = [0.18, 0.06, 0.03, 0.01, 0.01, 0.03, 0.06, 0.18];
    for (mount, distance_m) in rig.mounts.iter_mut().zip(from_origin_m) {
        let place = &mut mount.body_from_sensor;
        let exact = place.heading.direction().scaled(distance_m);
        assert!((exact - place.position).norm() < 1e-6, "{}", mount.name);
        place.position = exact;
    }
    rig
}

/// The keyframes of the drive, by its raw odometry.
fn records() -> Vec<Record> {
    let rig = kcma();
    let drive = DriveFile {
        path: &root().join("sim-harness/tests/data/robond"),
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let options = DriveOptions {
        keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
        share: KeyframeShare::All,
        mounts: rig
            .mounts
            .iter()
            .map(|it| it.name.starts_with("sonar"))
            .collect(),
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
    let records = records();
    for (name, (occupied, free), free_by_file) in [
        ("ism-cesp", (1576, 7220), 7221),
        ("mal", (947, 12_990), 12_990),
        ("cemal", (1217, 7751), 7752),
    ] {
        let method: Method = name.parse().unwrap();
        for (rig, free) in [(unrounded(), free), (kcma(), free_by_file)] {
            let mut mapper = method.mapper(&Setup::new(&rig, CELL_M));
            assert!(!mapper.is_online());
            let map = fill(&mut mapper, &records);
            assert_eq!(counts(&map), (occupied, free), "{name}");
            assert_eq!(map.refused(), 0);
        }
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

/// Start, flips, likelihoods and cells of a search; of `hard` only the last likelihood and
/// the occupied cells are published.
struct Published {
    objective: Objective,
    filter: EchoFilter,
    start: f64,
    flips: &'static [usize],
    values: &'static [f64],
    cells: (usize, usize),
}

const PUBLISHED: [Published; 3] = [
    Published {
        objective: Objective::Soft,
        filter: EchoFilter::None,
        start: -4780.167,
        flips: &[2546, 1322, 195, 66, 17, 5],
        values: &[-1244.880, 300.925, 340.063, 347.036, 348.170, 348.566],
        cells: (1603, 12_334),
    },
    Published {
        objective: Objective::Soft,
        filter: EchoFilter::Consistent,
        start: -2482.187,
        flips: &[1766, 551, 45, 3, 0],
        values: &[169.168, 467.472, 474.200, 475.047, 475.047],
        cells: (1287, 7681),
    },
    Published {
        objective: Objective::Hard,
        filter: EchoFilter::None,
        start: -4780.167,
        flips: &[1564, 790, 159, 55, 29, 14],
        values: &[-1209.052, -81.265, -34.651, -19.780, -13.012, -10.062],
        cells: (1089, 12_848),
    },
];

#[test]
fn g18_searches_climb_to_the_published_likelihoods() {
    let (rig, records) = (unrounded(), records());
    for published in &PUBLISHED {
        let parameters = LikelihoodParameters::STANDARD.with(published.objective);
        let mut mapper = LikelihoodMapper::new(CELL_M, &rig, published.filter, parameters);
        let map = fill(&mut mapper, &records);
        let what = format!("{:?}, {:?}", published.objective, published.filter);
        assert_eq!(counts(&map), published.cells, "{what}");
        assert!((mapper.start() - published.start).abs() < 1e-3, "{what}");
        let flips = mapper.sweeps().iter().map(|sweep| sweep.flips);
        assert_eq!(flips.collect::<Vec<_>>(), published.flips, "{what}");
        let values = mapper.sweeps().iter().map(|sweep| sweep.log_likelihood);
        let values: Vec<f64> = values.collect();
        assert!(values.is_sorted(), "{what}: {values:?}");
        for (value, expected) in values.iter().zip(published.values) {
            assert!((value - expected).abs() < 1e-3, "{what}: {values:?}");
        }
    }
}

#[test]
fn the_methods_of_the_table_give_the_maps_of_their_mappers() {
    let (rig, records) = (kcma(), records());
    for (name, occupied, free) in [
        ("fsm", 1603, 12_334),
        ("fsm-hard", 1089, 12_848),
        ("fsm-cesp", 1287, 7682),
    ] {
        let method: Method = name.parse().unwrap();
        let mut mapper = method.mapper(&Setup::new(&rig, CELL_M));
        assert_eq!(
            counts(&fill(&mut mapper, &records)),
            (occupied, free),
            "{name}"
        );
    }
}

fn any_return() -> impl Strategy<Value = Return> {
    let length = prop_oneof![
        8 => 0.0..6.0_f64,
        1 => prop_oneof![Just(1e9), Just(f64::MAX), Just(f64::INFINITY), Just(-1.0)],
        1 => Just(f64::NAN),
    ];
    prop_oneof![
        6 => (length.clone(), 0.0..0.3_f64)
            .prop_map(|(range_m, sigma_m)| Return::Echo { range_m, sigma_m }),
        2 => length.prop_map(|limit_m| Return::NoEcho { limit_m, sigma_m: 0.0 }),
        1 => Just(Return::TooClose),
        1 => Just(Return::Invalid),
    ]
}

fn any_scan() -> impl Strategy<Value = Record> {
    let along = prop_oneof![9 => -2.0..2.0_f64, 1 => prop_oneof![Just(1e12), Just(f64::NAN)]];
    let pose = (along, -2.0..2.0_f64, -4.0..4.0_f64);
    // More mounts than the rig has, fewer returns than the mounts have.
    let scan = (
        0..9_usize,
        0..9_usize,
        prop::collection::vec(any_return(), 0..9),
    );
    (0..50_u64, pose, scan).prop_map(|(stamp_us, (x, y, heading), (first, count, returns))| {
        Record::Scan(RangeScan {
            stamp_us,
            world_from_body: Pose2::new(x, y, heading),
            mounts: first..first + count,
            returns,
            signals: Vec::new(),
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_scans_give_probabilities_and_the_same_map_twice(
        scans in prop::collection::vec(any_scan(), 0..20),
        no_echo in prop_oneof![Just(None), Just(Some(NoEcho::Free))],
    ) {
        let rig = kcma();
        for method in METHODS {
            let setup = Setup { no_echo, ..Setup::new(&rig, CELL_M) };
            let mut mapper = method.mapper(&setup);
            let map = fill(&mut mapper, &scans);
            for (cell, belief) in map.iter() {
                let p_occ = belief.p_occ();
                prop_assert!((0.0..=1.0).contains(&p_occ), "{method}: {cell:?} {p_occ}");
            }
            mapper.finish(&mut |_| {});
            prop_assert!(mapper.map() == map, "{method} twice");
        }
    }
}
