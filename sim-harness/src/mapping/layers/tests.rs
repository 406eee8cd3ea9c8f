//! Layers and their fusion over scans.

use super::*;
use crate::drive::{Record, Return};
use crate::geometry::Pose2;
use crate::lattice::{Cell, Lattice};
use crate::mapping::test_drives::{echo, forward, no_echo, rig_of, scan_of, sonar, toy_scene};
use crate::mapping::{Belief, Mapper, Method, NoEcho, Occupancy, Setup};
use crate::rig::Rig;
use crate::sensors::{Scanner, Sensor, SensorKind};

fn laser(beams: u16, step_deg: f64) -> Sensor {
    Sensor::Scanner(Scanner {
        beams,
        first_rad: 0.0,
        step_rad: step_deg.to_radians(),
        range_m: [0.05, 20.0],
        sigma_m: 0.01,
    })
}

fn layer_of(rig: &Rig, kind: SensorKind, records: &[Record]) -> LayerMapper {
    mapped(rig, &[kind], Fusion::MinMax, records)
}

fn mapped(rig: &Rig, kinds: &[SensorKind], fusion: Fusion, records: &[Record]) -> LayerMapper {
    let mut mapper = LayerMapper::new(0.1, rig, kinds, fusion, LayerParameters::LEE);
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper
}

/// Columns and rows of the cells of a layer above or below 0.
fn cells(mapper: &LayerMapper, sign: f64) -> Vec<(i32, i32)> {
    let cells = mapper.layers()[0].log_odds().iter();
    let mut cells: Vec<_> = cells
        .filter(|(_, log_odds)| **log_odds * sign > 0.0)
        .map(|(Cell { row, column }, _)| (column, row))
        .collect();
    cells.sort_unstable();
    cells
}

#[test]
fn g16_two_beams_hit_and_pass_the_tabulated_cells() {
    let rig = forward(laser(2, 45.0));
    let scan = scan_of(&rig, (0.55, 0.55, 0.0), vec![echo(1.0); 2]);
    let mapper = layer_of(&rig, SensorKind::Scanner, &[scan]);
    assert_eq!(cells(&mapper, 1.0), [(12, 12), (15, 5)]);
    let mut passes: Vec<_> = (5..=14).map(|column| (column, 5)).collect();
    passes.extend((6..=11).map(|place| (place, place)));
    passes.sort_unstable();
    assert_eq!(cells(&mapper, -1.0), passes);
}

#[test]
fn a_scan_counts_a_cell_once_however_many_beams_meet_it() {
    // Nine beams within a degree, through the same cells; the last one is longer.
    let rig = forward(laser(9, 0.1));
    let mut returns = vec![echo(1.0); 8];
    returns.push(echo(1.6));
    let scan = scan_of(&rig, (0.05, 0.05, 0.0), returns);
    let mapper = layer_of(&rig, SensorKind::Scanner, &[scan.clone(), scan]);
    let hit = LayerParameters::LEE.hit;
    let layer = mapper.layers()[0].log_odds();
    let at = |column| *layer.get(Cell { row: 0, column }).unwrap();
    for (column, expected) in [(0, -2.0), (5, -2.0), (10, 2.0), (12, -2.0), (16, 2.0)] {
        assert!((at(column) - expected * hit).abs() < 1e-12, "{column}");
    }
}

#[test]
fn a_beam_without_an_echo_or_beyond_the_reach_passes_up_to_the_reach() {
    let rig = forward(laser(1, 1.0));
    for measured in [no_echo(20.0), echo(12.0)] {
        let scan = scan_of(&rig, (0.05, 0.05, 0.0), vec![measured]);
        let mapper = layer_of(&rig, SensorKind::Scanner, &[scan]);
        assert_eq!(cells(&mapper, 1.0), []);
        assert_eq!(cells(&mapper, -1.0).last(), Some(&(80, 0)), "{measured:?}");
    }
    let setup = Setup {
        no_echo: Some(NoEcho::Dropped),
        ..Setup::new(&rig, 0.1)
    };
    let mut mapper = Method::LASER.mapper(&setup);
    mapper.take(&scan_of(&rig, (0.05, 0.05, 0.0), vec![no_echo(20.0)]));
    assert_eq!(mapper.map().count(Occupancy::Free), 0);
}

#[test]
fn the_layer_of_the_sonars_has_the_classes_of_the_inverse_sensor_model() {
    let rig = forward(sonar());
    let map = layer_of(&rig, SensorKind::Cone, &toy_scene(&rig)).map();
    assert_eq!(map.count(Occupancy::Occupied), 48);
    assert_eq!(map.count(Occupancy::Free), 185);
    let nothing = scan_of(&rig, (0.0, 0.05, 0.0), vec![no_echo(3.0)]);
    let map = layer_of(&rig, SensorKind::Cone, std::slice::from_ref(&nothing)).map();
    assert_eq!(map.count(Occupancy::Free), 0);
    let setup = Setup {
        no_echo: Some(NoEcho::Free),
        ..Setup::new(&rig, 0.1)
    };
    let mut mapper = Method::SONAR.mapper(&setup);
    mapper.take(&nothing);
    assert!(mapper.map().count(Occupancy::Free) > 100);
}

/// A robot with a sonar and a laser beam, both forward, after a scan in which the laser
/// passes what the sonar hits.
fn contradicting(fusion: Fusion) -> LayerMapper {
    let at = Pose2::new(0.0, 0.0, 0.0);
    let rig = rig_of(vec![(sonar(), at), (laser(1, 1.0), at)]);
    let scan = scan_of(&rig, (0.05, 0.05, 0.0), vec![echo(1.0), echo(2.0)]);
    let kinds = [SensorKind::Scanner, SensorKind::Cone];
    mapped(&rig, &kinds, fusion, &[scan.clone(), scan])
}

#[test]
fn fused_cells_have_the_value_of_their_source() {
    let cell = |column| Cell { row: 0, column };
    let pessimistic = contradicting(Fusion::Pessimistic);
    let map = pessimistic.map();
    // The sonar's arc at 1 m wins, the laser's wall at 2 m too; between them only the laser
    // has passes, and the unknown sonar layer makes the cells unknown.
    assert_eq!(map.occupancy(cell(10)), Occupancy::Occupied);
    assert_eq!(pessimistic.source(cell(10)), Some(SensorKind::Cone));
    assert_eq!(map.occupancy(cell(20)), Occupancy::Occupied);
    assert_eq!(pessimistic.source(cell(20)), Some(SensorKind::Scanner));
    assert_eq!(map.occupancy(cell(15)), Occupancy::Unknown);
    assert_eq!(pessimistic.source(cell(15)), Some(SensorKind::Cone));
    assert_eq!(map.occupancy(cell(5)), Occupancy::Free);

    let known = contradicting(Fusion::PessimisticOfKnown);
    assert_eq!(known.map().occupancy(cell(15)), Occupancy::Free);
    assert_eq!(known.source(cell(15)), Some(SensorKind::Scanner));

    let min_max = contradicting(Fusion::MinMax);
    let map = min_max.map();
    assert_eq!(
        map.occupancy(cell(10)),
        Occupancy::Unknown,
        "one against one"
    );
    assert_eq!(min_max.source(cell(10)), None);
    assert_eq!(map.occupancy(cell(15)), Occupancy::Free);
    assert_eq!(map.occupancy(cell(20)), Occupancy::Occupied);
    assert_eq!(
        min_max.source(Cell {
            row: 900,
            column: 900
        }),
        None
    );
}

#[test]
fn the_order_of_the_scans_does_not_matter() {
    let rig = forward(sonar());
    let mut scans = toy_scene(&rig);
    let forward = layer_of(&rig, SensorKind::Cone, &scans).map();
    scans.rotate_left(1);
    scans.swap(0, 2);
    let other = layer_of(&rig, SensorKind::Cone, &scans).map();
    for (cell, belief) in forward.iter() {
        let difference = belief.p_occ() - other.get(cell).map_or(0.5, Belief::p_occ);
        assert!(difference.abs() < 1e-6, "{cell:?}");
    }
}

#[test]
fn a_robot_absurdly_far_away_is_counted_as_refused() {
    let at = Pose2::new(0.0, 0.0, 0.0);
    let rig = rig_of(vec![(sonar(), at), (laser(1, 1.0), at)]);
    for measured in [echo(1.0), Return::Invalid] {
        let scan = scan_of(&rig, (1e30, 0.0, 0.0), vec![measured; 2]);
        let kinds = [SensorKind::Scanner, SensorKind::Cone];
        let map = mapped(&rig, &kinds, Fusion::MinMax, &[scan]).map();
        let expected = if measured == Return::Invalid { 0 } else { 2 };
        assert_eq!(map.refused(), expected, "{measured:?}");
    }
}

#[test]
fn a_layer_is_that_of_its_lattice_without_a_scan() {
    let lattice = Lattice::new(0.05).moved_by_half_a_cell();
    let rig = forward(sonar());
    let kinds = [SensorKind::Cone];
    let mapper = LayerMapper::new(lattice, &rig, &kinds, Fusion::MinMax, LayerParameters::LEE);
    assert_eq!(mapper.map().lattice(), lattice);
}
