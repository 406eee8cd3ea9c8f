//! Maps of the three calculi against tabulated numbers.

use std::cell::Cell as Shared;

use super::*;
use crate::drive::{Record, Return};
use crate::mapping::test_drives::{echo, forward, no_echo, robond, scan_of, sonar, toy_scene};
use crate::mapping::{Belief, Calculus, Map, Mapper, Method, Occupancy, Setup};
use crate::rig::Rig;

fn counts(map: &Map) -> [usize; 2] {
    [Occupancy::Occupied, Occupancy::Free].map(|class| map.count(class))
}

fn mapped<M: Mapper>(mut mapper: M, records: &[Record]) -> M {
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper
}

fn bayes(rig: &Rig) -> ConeEvidenceMapper<Bayes> {
    ConeEvidenceMapper::new(0.1, rig, Bayes, SonarModel::occupancy)
}

fn dempster_shafer(rig: &Rig) -> ConeEvidenceMapper<DempsterShafer> {
    ConeEvidenceMapper::new(0.1, rig, DempsterShafer, SonarModel::masses)
}

fn fuzzy(rig: &Rig) -> ConeEvidenceMapper<Fuzzy> {
    ConeEvidenceMapper::new(0.1, rig, Fuzzy, SonarModel::memberships)
}

#[test]
fn g15_four_sonar_echoes_give_the_tabulated_evidence_and_classes() {
    let rig = forward(sonar());
    let scans = toy_scene(&rig);
    let at = |cell: &dyn Fn(f64, f64) -> f64, expected: f64| {
        let found = cell(2.05, 1.55);
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    };
    let map = mapped(bayes(&rig), &scans);
    let cells = map.cells();
    at(
        &|x, y| *cells.get(cells.cell_at(x, y).unwrap()).unwrap(),
        0.140_161_079,
    );
    assert_eq!(counts(&map.map()), [66, 179]);
    let map = mapped(dempster_shafer(&rig), &scans);
    let cells = map.cells();
    let masses = |x, y| *cells.get(cells.cell_at(x, y).unwrap()).unwrap();
    at(&|x, y| masses(x, y).occupied, 0.199_364_784);
    at(&|x, y| masses(x, y).empty, 0.146_587_720);
    assert_eq!(counts(&map.map()), [66, 179]);
    let map = mapped(fuzzy(&rig), &scans);
    let cells = map.cells();
    let memberships = |x, y| {
        cells
            .get(cells.cell_at(x, y).unwrap())
            .unwrap()
            .memberships()
    };
    at(&|x, y| memberships(x, y).occupied, 0.067_418_899);
    at(&|x, y| memberships(x, y).empty, 0.020_343_253);
    assert_eq!(counts(&map.map()), [68, 177]);
}

#[test]
fn g18_maps_of_the_recording_have_the_tabulated_counts() {
    let (rig, records) = robond();
    for (name, expected) in [
        ("bayes", [2132, 6593]),
        ("ds", [2129, 6596]),
        ("fuzzy", [2186, 6532]),
        ("bayes-box", [2628, 7368]),
        ("ds-box", [2630, 7366]),
        ("fuzzy-box", [2713, 7277]),
    ] {
        let method: Method = name.parse().unwrap();
        let mapper = mapped(method.mapper(&Setup::new(&rig, 0.1)), &records);
        assert_eq!(counts(&mapper.map()), expected, "{name}");
    }
}

#[test]
fn g18_the_box_shortens_369_readings() {
    let (rig, records) = robond();
    let mapper = mapped(BoxMapper::new(bayes(&rig), &rig, |_| true), &records);
    assert_eq!(mapper.shortened(), 369);
}

/// [`DempsterShafer`], with the largest conflict that it has met.
struct Watched(Shared<f64>);

impl Calculus for Watched {
    type Evidence = Masses;
    type Held = Masses;

    fn blank(&self) -> Masses {
        DempsterShafer.blank()
    }

    fn update(&self, held: &mut Masses, reading: Masses) {
        self.0.set(self.0.get().max(held.conflict(&reading)));
        DempsterShafer.update(held, reading);
    }

    fn belief(&self, held: &Masses) -> Belief {
        DempsterShafer.belief(held)
    }
}

#[test]
fn g18_the_largest_conflict_is_the_tabulated_one() {
    let (rig, records) = robond();
    let watched = Watched(Shared::new(0.0));
    let mapper = ConeEvidenceMapper::new(0.1, &rig, watched, SonarModel::masses);
    let largest = mapped(mapper, &records).calculus.0.get();
    assert!((largest - 0.697_553).abs() < 1e-6, "{largest}");
}

#[test]
fn the_order_of_the_scans_does_not_matter() {
    let (rig, mut records) = robond();
    let setup = Setup::new(&rig, 0.1);
    for method in [Method::BAYES, Method::DS, Method::FUZZY] {
        let forward = mapped(method.mapper(&setup), &records).map();
        // A fixed shuffle: every 89th record of their number.
        let count = records.len();
        let shuffled: Vec<_> = (0..count)
            .map(|index| records[index * 89 % count].clone())
            .collect();
        assert_ne!(count % 89, 0);
        let other = mapped(method.mapper(&setup), &shuffled).map();
        for (cell, belief) in forward.iter() {
            let [p_occ, other] = [belief.p_occ(), other.get(cell).map_or(0.5, Belief::p_occ)];
            assert!((p_occ - other).abs() < 1e-5, "{method}: {cell:?}");
        }
        records.reverse();
    }
}

#[test]
fn readings_that_are_rejected_or_no_echo_are_no_evidence() {
    let rig = forward(sonar());
    for measured in [
        echo(3.0),
        echo(4.2),
        no_echo(5.0),
        Return::TooClose,
        Return::Invalid,
    ] {
        let scan = scan_of(&rig, (0.0, 0.0, 0.0), vec![measured]);
        let map = mapped(bayes(&rig), &[scan]).map();
        assert_eq!(map.iter().count(), 0, "{measured:?}");
    }
}

#[test]
fn a_robot_absurdly_far_away_is_counted_as_refused() {
    let rig = forward(sonar());
    for x in [1e30, f64::NAN] {
        let scan = scan_of(&rig, (x, 0.0, 0.0), vec![echo(1.0)]);
        assert_eq!(mapped(fuzzy(&rig), &[scan]).map().refused(), 1, "{x}");
    }
}
