//! Maps of single returns against closed forms and tabulated numbers.

use super::*;
use crate::drive::Return;
use crate::geometry::Pose2;
use crate::mapping::Occupancy;
use crate::rig::SensorMount;
use crate::sensors::{Cone, Infrared, Scanner, Sensor};
use amiro_ipf::model::Photometry;

const STANDARD: InverseSensorParameters = InverseSensorParameters::STANDARD;
const RANGE: InverseSensorParameters = InverseSensorParameters::RANGE;

/// A robot with one sensor, which looks forward.
fn rig(sensor: Sensor) -> Rig {
    Rig {
        name: "one".to_owned(),
        about: "One sensor that looks forward.".to_owned(),
        radius_m: 0.1,
        track_m: None,
        mounts: vec![SensorMount {
            name: "sensor".to_owned(),
            body_from_sensor: Pose2::new(0.0, 0.0, 0.0),
            sensor,
        }],
    }
}

fn infrared() -> Rig {
    rig(Sensor::Infrared(Infrared::new(Photometry::VCNL4020)))
}

fn cone() -> Rig {
    rig(Sensor::Cone(Cone {
        half_angle_rad: 12.5_f64.to_radians(),
        range_m: [0.1, 5.0],
        sigma_m: 0.0,
        directivity: crate::sensors::Directivity::Piston,
    }))
}

/// The mapper after one scan at each place.
fn mapped(
    rig: &Rig,
    cell_m: f64,
    parameters: InverseSensorParameters,
    scans: &[((f64, f64), Return)],
) -> InverseSensorMapper {
    let mut mapper = InverseSensorMapper::new(cell_m, rig, parameters);
    for ((x, y), measured) in scans {
        mapper.take(&Record::Scan(RangeScan {
            stamp_us: 0,
            world_from_body: Pose2::new(*x, *y, 0.0),
            mounts: 0..1,
            returns: vec![*measured],
            signals: Vec::new(),
        }));
    }
    mapper
}

fn echo(range_m: f64) -> Return {
    Return::Echo {
        range_m,
        sigma_m: 0.0,
    }
}

/// Map of an infrared sensor at the origin after a number of equal returns; the axis
/// passes through the centres of a row of cells.
fn infrared_map(parameters: InverseSensorParameters, measured: Return, returns: usize) -> Map {
    let scans = vec![((0.0, 0.005), measured); returns];
    mapped(&infrared(), 0.01, parameters, &scans).map()
}

/// p_occ on the axis, so many millimetres before the sensor.
fn on_axis(map: &Map, millimetres: u32) -> f32 {
    let x = 0.001 * f64::from(millimetres);
    let cell = map.cell_at(x, 0.005).unwrap();
    map.get(cell).map_or(0.5, Belief::p_occ)
}

fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

#[test]
fn profile_on_the_axis_is_free_then_peaks_at_the_object_then_unknown() {
    for parameters in [STANDARD, InverseSensorParameters::TUNED] {
        let map = infrared_map(parameters, echo(0.05), 1);
        let free = probability(-parameters.free);
        let occupied = probability(parameters.occupied);
        for millimetres in [5, 15, 25, 35] {
            let p = f64::from(on_axis(&map, millimetres));
            assert!((p - free).abs() < 1e-3, "{millimetres} mm: {p}");
        }
        for millimetres in [45, 55] {
            let p = f64::from(on_axis(&map, millimetres));
            assert!((p - occupied).abs() < 1e-3, "{millimetres} mm: {p}");
        }
        for millimetres in (65..300).step_by(10) {
            let p = on_axis(&map, millimetres);
            assert_eq!(p.to_bits(), 0.5_f32.to_bits(), "{millimetres} mm");
        }
    }
}

#[test]
fn infrared_evidence_weakens_off_the_axis() {
    let map = infrared_map(STANDARD, echo(0.05), 1);
    let off_axis = map.cell_at(0.025, 0.005 + 0.020).unwrap();
    let p = f64::from(map.get(off_axis).unwrap().p_occ());
    // 25 mm ahead and 20 mm aside are 38.66 degrees: cos(1.2365 x 38.66 deg) = 0.6717.
    assert!((p - probability(-0.40 * 0.6717)).abs() < 1e-3, "{p}");
    // 10 mm aside of 5 mm ahead are 63 degrees: out of view.
    let out_of_view = map.cell_at(0.005, 0.015).unwrap();
    assert_eq!(map.occupancy(out_of_view), Occupancy::Unknown);
}

#[test]
fn adding_log_odds_is_the_rule_of_bayes() {
    // From an even prior each reading multiplies the odds: p' = p q / (p q + (1-p)(1-q)).
    for millimetres in [15, 45] {
        let single = on_axis(&infrared_map(STANDARD, echo(0.05), 1), millimetres);
        let mut p = single;
        for returns in 2..=8 {
            let (yes, no) = (p * single, (1.0 - p) * (1.0 - single));
            p = yes / (yes + no);
            let summed = on_axis(&infrared_map(STANDARD, echo(0.05), returns), millimetres);
            assert!(
                (summed - p).abs() < 2e-6,
                "{returns} returns: {summed}, {p}"
            );
        }
    }
}

#[test]
fn nothing_in_range_is_free_or_nothing_or_an_object_by_rule() {
    let limit = Return::NoEcho {
        limit_m: 0.2,
        sigma_m: 0.0194,
    };
    let rules = [NoEcho::Free, NoEcho::Dropped, NoEcho::Object];
    let maps = rules.map(|rule| infrared_map(STANDARD.with(rule), limit, 1));
    let classes = |millimetres: u32| {
        let x = 1e-3 * f64::from(millimetres);
        let class = |map: &Map| map.occupancy(map.cell_at(x, 0.005).unwrap());
        maps.each_ref().map(class)
    };
    use Occupancy::{Free, Occupied, Unknown};
    assert_eq!(classes(105), [Free, Unknown, Free]);
    assert_eq!(classes(175), [Free, Unknown, Free]);
    assert_eq!(classes(195), [Unknown, Unknown, Occupied]);
    assert_eq!(classes(215), [Unknown, Unknown, Occupied]);
    assert_eq!(classes(225), [Unknown, Unknown, Unknown]);
    // An object in range is the same to all three.
    let [free, dropped, object] = rules.map(|rule| infrared_map(STANDARD.with(rule), echo(0.1), 3));
    assert_eq!(free, dropped);
    assert_eq!(free, object);
}

#[test]
fn returns_without_a_range_are_no_evidence() {
    for rig in [infrared(), cone()] {
        for silent in [Return::TooClose, Return::Invalid] {
            let map = mapped(&rig, 0.1, RANGE, &[((0.0, 0.0), silent)]).map();
            assert_eq!(map.iter().count(), 0, "{silent:?}");
        }
    }
}

#[test]
fn a_robot_absurdly_far_away_is_counted_as_refused() {
    for rig in [infrared(), cone()] {
        let far = [((1e30, 0.0), echo(0.1))];
        assert_eq!(mapped(&rig, 0.01, RANGE, &far).map().refused(), 1);
    }
}

#[test]
fn g15_four_sonar_echoes_give_the_tabulated_cells_and_log_odds() {
    let scans = [
        ((0.51, 1.53), echo(1.52)),
        ((0.51, 1.23), echo(1.52)),
        ((0.51, 1.83), echo(1.52)),
        ((0.51, 1.53), echo(2.61)),
    ];
    let mapper = mapped(&cone(), 0.1, RANGE, &scans);
    let map = mapper.map();
    assert_eq!(map.count(Occupancy::Occupied), 48);
    assert_eq!(map.count(Occupancy::Free), 185);
    let sum: f64 = mapper.log_odds.iter().map(|(_, l)| l).sum();
    assert!((sum + 169.459_572_077).abs() < 1e-8, "{sum}");
    let cell = map.cell_at(2.05, 1.55).unwrap();
    let l = mapper.log_odds.get(cell).unwrap();
    assert!((l - 1.694_595_721).abs() < 1e-9, "{l}");
}

#[test]
fn g2_cells_are_free_before_the_band_and_occupied_within_it() {
    // Centres at 1.80, 1.95 and 2.15 m from the sensor; a band of 0.10 m each way.
    let parameters = InverseSensorParameters {
        tolerance_cells: 2.0,
        ..RANGE
    };
    let mapper = mapped(&cone(), 0.05, parameters, &[((0.025, 0.025), echo(2.0))]);
    let map = mapper.map();
    let class = |range_m| map.occupancy(map.cell_at(0.025 + range_m, 0.025).unwrap());
    assert_eq!(class(1.80), Occupancy::Free);
    assert_eq!(class(1.95), Occupancy::Occupied);
    assert_eq!(class(2.15), Occupancy::Unknown);
}

#[test]
fn g2_decay_weighs_an_echo_by_what_is_left_of_the_range() {
    let parameters = InverseSensorParameters {
        decay_m: Some(5.0),
        ..RANGE
    };
    let mapper = mapped(&cone(), 0.1, parameters, &[((0.0, 0.05), echo(2.0))]);
    let at = |x| {
        let cell = mapper.log_odds.cell_at(x, 0.05).unwrap();
        mapper.log_odds.get(cell).copied().unwrap_or(0.0)
    };
    // 0.6 ln(0.7 / 0.3).
    assert!((at(1.95) - 0.508_378_716).abs() < 1e-9);
    assert!((at(1.75) + 0.508_378_716).abs() < 1e-9);
    assert!(at(2.15).abs() < 1e-12);
}

#[test]
fn the_order_of_the_scans_does_not_matter() {
    let mut scans = [
        ((0.51, 1.53), echo(1.52)),
        ((0.51, 1.23), echo(0.52)),
        ((0.31, 1.83), echo(2.61)),
    ];
    let forward = mapped(&cone(), 0.1, RANGE, &scans).map();
    scans.reverse();
    let backward = mapped(&cone(), 0.1, RANGE, &scans).map();
    for (cell, belief) in forward.iter() {
        let other = backward.get(cell).map_or(0.5, Belief::p_occ);
        let p_occ = belief.p_occ();
        assert!(
            (p_occ - other).abs() < 1e-6,
            "{cell:?}: {p_occ} and {other}"
        );
    }
}

#[test]
fn a_beam_frees_its_cells_once_and_hits_one() {
    let scanner = rig(Sensor::Scanner(Scanner {
        beams: 1,
        first_rad: 0.0,
        step_rad: 0.01,
        range_m: [0.05, 80.0],
        sigma_m: 0.0,
    }));
    let map = mapped(&scanner, 0.1, RANGE, &[((0.05, 0.05), echo(1.0))]).map();
    assert_eq!(map.count(Occupancy::Occupied), 1);
    // From the sensor's own cell to the one at 0.95 m, whose beginning is 0.05 m
    // nearer than the tolerance allows at its end.
    assert_eq!(map.count(Occupancy::Free), 10);
    let end = map.cell_at(1.05, 0.05).unwrap();
    assert_eq!(map.occupancy(end), Occupancy::Occupied);
}

#[test]
fn returns_without_an_echo_count_only_where_that_is_wanted() {
    let nothing = [(
        (0.0, 0.05),
        Return::NoEcho {
            limit_m: 3.0,
            sigma_m: 0.0,
        },
    )];
    let dropped = mapped(&cone(), 0.1, RANGE, &nothing).map();
    assert_eq!(dropped.count(Occupancy::Free), 0);
    let taken = mapped(&cone(), 0.1, RANGE.with(NoEcho::Free), &nothing).map();
    assert!(taken.count(Occupancy::Free) > 150);
    assert_eq!(taken.count(Occupancy::Occupied), 0);
}
