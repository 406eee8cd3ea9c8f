//! What single readings do to the costs.

use super::*;
use crate::mapping::Occupancy;
use crate::mapping::test_drives::{echo, forward, no_echo, scan_of, sonar};
use crate::sensors::Scanner;

const NAV2: RangeLayerParameters = RangeLayerParameters::NAV2;

fn mapped(sensor: Sensor, parameters: RangeLayerParameters, returns: &[Return]) -> Map {
    let rig = forward(sensor);
    let mut mapper = RangeLayerMapper::new(0.1, &rig, parameters);
    for measured in returns {
        mapper.take(&scan_of(&rig, (0.0, 0.05, 0.0), vec![*measured]));
    }
    mapper.finish(&mut |_| {});
    mapper.map()
}

fn beam() -> Sensor {
    Sensor::Scanner(Scanner {
        beams: 1,
        first_rad: 0.0,
        step_rad: 0.01,
        range_m: [0.05, 20.0],
        sigma_m: 0.01,
    })
}

#[test]
fn the_model_leans_to_free_before_a_reading_and_to_occupied_at_it() {
    let at = |range_m, share| NAV2.occupancy(range_m, share, 1.0, 0.1);
    // At 0.2 m: q = 1 / (1 + e^-4).
    let trust = 1.0 / (1.0 + libm::exp(-4.0));
    assert!((at(0.2, 0.0) - 0.5 * (1.0 - trust)).abs() < 1e-9);
    assert!((at(0.2, 0.5) - 0.5 * (1.0 - 0.75 * trust)).abs() < 1e-9);
    let trust = 1.0 / (1.0 + libm::exp(-0.8));
    assert!((at(1.0, 0.0) - 0.5 * (1.0 + trust)).abs() < 1e-9);
    // On the borders of the band nothing is said.
    for range_m in [0.9, 1.1, 1.5] {
        assert!((at(range_m, 0.0) - 0.5).abs() < 1e-9, "{range_m}");
    }
    assert!((at(0.3, 1.0) - 0.5).abs() < 1e-12, "the cone's edge");
}

#[test]
fn one_reading_marks_the_end_of_its_axis_and_clears_only_what_is_near() {
    let map = mapped(sonar(), NAV2, &[echo(2.05)]);
    assert_eq!(map.count(Occupancy::Occupied), 1);
    assert_eq!(map.occupancy_at(2.05, 0.05), Occupancy::Occupied);
    assert_eq!(map.occupancy_at(0.25, 0.05), Occupancy::Free);
    assert_eq!(map.occupancy_at(1.65, 0.05), Occupancy::Unknown);
}

#[test]
fn costs_are_rounded_down_so_that_zero_stays_and_weak_evidence_clears() {
    assert_eq!(updated(127, 0.5), 127);
    assert_eq!(updated(127, 0.499_999), 126);
    assert_eq!(updated(0, 0.99), 0);
    assert_eq!(updated(254, 0.01), 254);
    assert_eq!(updated(0, 1.0), 0, "no answer");
}

#[test]
fn a_return_without_an_echo_clears_only_if_that_is_wanted() {
    let map = mapped(sonar(), NAV2, &[no_echo(5.0)]);
    assert_eq!(map.count(Occupancy::Free), 0);
    let clearing = NAV2.with(Some(NoEcho::Free));
    let map = mapped(sonar(), clearing, &[echo(2.05), no_echo(5.0)]);
    assert_eq!(map.count(Occupancy::Occupied), 0);
    assert_eq!(map.occupancy_at(4.05, 0.05), Occupancy::Free);
}

#[test]
fn a_beam_is_a_ray_on_the_axis() {
    let map = mapped(beam(), NAV2, &[echo(1.0); 3]);
    assert_eq!(map.occupancy_at(1.0, 0.05), Occupancy::Occupied);
    assert_eq!(map.occupancy_at(0.45, 0.05), Occupancy::Free);
    assert_eq!(map.occupancy_at(0.45, 0.15), Occupancy::Unknown);
}

#[test]
fn a_robot_absurdly_far_away_is_counted_as_refused() {
    for sensor in [sonar(), beam()] {
        let rig = forward(sensor);
        let mut mapper = RangeLayerMapper::new(0.1, &rig, NAV2);
        mapper.take(&scan_of(&rig, (1e30, 0.0, 0.0), vec![echo(1.0)]));
        assert_eq!(mapper.map().refused(), 1);
    }
}
