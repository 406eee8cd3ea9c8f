//! Maps of scans at random: ranges of every kind, and poses everywhere.

use proptest::prelude::*;

use super::test_drives::rig_named;
use super::{Belief, ConeEvidenceMapper, DempsterShafer, Map, Mapper, Method, Setup, SonarModel};
use crate::drive::{RangeScan, Record, Return};
use crate::geometry::Pose2;
use crate::rig::Rig;

/// The methods whose mappers are tried.
const METHODS: [Method; 13] = [
    Method::BAYES,
    Method::DS,
    Method::FUZZY,
    Method::BAYES_BOX,
    Method::DS_BOX,
    Method::FUZZY_BOX,
    Method::LASER,
    Method::SONAR,
    Method::PESSIMISTIC,
    Method::MINMAX,
    Method::ISM_NEAR,
    Method::PGC,
    Method::NAV2_RANGE,
];

/// A range from a millimetre to numbers that are none.
fn range_m() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => 0.001..6.0,
        1 => 6.0..1e6,
        1 => prop_oneof![Just(f64::INFINITY), Just(f64::NAN), Just(-1.0), Just(0.0), Just(1e300)],
    ]
}

fn measured() -> impl Strategy<Value = Return> {
    let sigma_m = 0.0..0.3;
    let echo = (range_m(), sigma_m.clone());
    let no_echo = (range_m(), sigma_m);
    prop_oneof![
        6 => echo.prop_map(|(range_m, sigma_m)| Return::Echo { range_m, sigma_m }),
        2 => no_echo.prop_map(|(limit_m, sigma_m)| Return::NoEcho { limit_m, sigma_m }),
        1 => Just(Return::TooClose),
        1 => Just(Return::Invalid),
    ]
}

/// A pose of an ordinary drive, rarely one that is far away or no pose.
fn pose() -> impl Strategy<Value = Pose2> {
    let near = (-2.0..2.0, -2.0..2.0, -4.0..4.0);
    prop_oneof![
        12 => near.prop_map(|(x, y, heading)| Pose2::new(x, y, heading)),
        1 => prop_oneof![Just(1e30), Just(f64::NAN), Just(-1e7)].prop_map(|x| Pose2::new(x, 0.0, 1.0)),
    ]
}

/// The sonars and the first beams of the laser of the rig `kcma`, at one stamp.
fn scan(stamp_us: u64) -> impl Strategy<Value = Record> {
    (pose(), prop::collection::vec(measured(), 8 + 20)).prop_map(
        move |(world_from_body, returns)| {
            Record::Scan(RangeScan {
                stamp_us,
                world_from_body,
                mounts: 0..9,
                returns,
                signals: Vec::new(),
            })
        },
    )
}

fn scans() -> impl Strategy<Value = Vec<Record>> {
    prop::collection::vec((0_u64..4).prop_flat_map(scan), 1..6)
}

fn mapped(method: &Method, rig: &Rig, records: &[Record]) -> [Map; 2] {
    let mut mapper = method.mapper(&Setup::new(rig, 0.1));
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    let once = mapper.map();
    mapper.finish(&mut |_| {});
    [once, mapper.map()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn beliefs_of_random_scans_are_probabilities_and_finish_changes_nothing_again(records in scans()) {
        let rig = rig_named("kcma.toml");
        for method in METHODS {
            let [once, twice] = mapped(&method, &rig, &records);
            prop_assert!(once == twice, "{} differs after the second finish", method);
            for (cell, belief) in once.iter() {
                let p_occ = belief.p_occ();
                prop_assert!((0.0..=1.0).contains(&p_occ), "{}: {:?}: {}", method, cell, p_occ);
                let Belief { occupied, free, unknown, conflict } = *belief;
                for part in [occupied, free, unknown, conflict] {
                    prop_assert!((0.0..=1.0).contains(&part), "{}: {:?}", method, belief);
                }
            }
        }
    }

    #[test]
    fn masses_of_random_scans_sum_to_one_at_most(records in scans()) {
        let rig = rig_named("kcma.toml");
        let mut mapper = ConeEvidenceMapper::new(0.1, &rig, DempsterShafer, SonarModel::masses);
        records.iter().for_each(|record| mapper.take(record));
        for (cell, masses) in mapper.cells().iter() {
            for mass in [masses.occupied, masses.empty, masses.open()] {
                prop_assert!((0.0..=1.0).contains(&mass), "{:?}: {:?}", cell, masses);
            }
            let sum = masses.occupied + masses.empty;
            prop_assert!(sum <= 1.0, "{:?}: {}", cell, sum);
        }
    }
}

/// Methods that only add: the order of the scans is nothing to them.
#[test]
fn methods_that_add_do_not_depend_on_the_order_of_the_scans() {
    let (rig, records) = super::test_drives::robond();
    let count = records.len();
    assert_ne!(count % 89, 0);
    let shuffled: Vec<Record> = (0..count)
        .map(|index| records[index * 89 % count].clone())
        .collect();
    for name in ["sonar", "ism-near", "pgc", "bayes-box"] {
        let method: Method = name.parse().unwrap();
        let [one, other] =
            [&records, &shuffled].map(|records| mapped(&method, &rig, records)[0].clone());
        for (cell, belief) in one.iter() {
            let difference = belief.p_occ() - other.get(cell).map_or(0.5, Belief::p_occ);
            assert!(difference.abs() < 1e-5, "{name}: {cell:?}: {difference}");
        }
    }
}
