use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;

use super::*;
use crate::drive::RangeScan;
use crate::geometry::{Pose2, Vector};
use crate::mapping::Occupancy;
use crate::sensors::{Sensor, WallLaw, WallSegment};

const CELL_M: f64 = 0.01;

fn rig() -> Rig {
    Rig::from(&Config::amiro(Profile::Paper))
}

fn wall(from: (f64, f64), to: (f64, f64)) -> WallSegment {
    WallSegment::new(Vector::new(from.0, from.1), Vector::new(to.0, to.1))
}

/// The signals of all sensors at a pose among walls, each sensor's multiplied by its gain.
fn scan(rig: &Rig, pose: Pose2, walls: &[WallSegment], gain: impl Fn(usize) -> f64) -> Record {
    let signal = |(index, mount): (usize, &crate::rig::SensorMount)| {
        let Sensor::Infrared(sensor) = &mount.sensor else {
            return None;
        };
        let world_from_sensor = pose * mount.body_from_sensor;
        let views: Vec<_> = walls
            .iter()
            .map(|wall| wall.viewed_from(&world_from_sensor))
            .collect();
        Some(gain(index) * WallLaw::new(sensor.photometry()).signal(&views))
    };
    Record::Scan(RangeScan {
        stamp_us: 0,
        world_from_body: pose,
        mounts: 0..rig.mounts.len(),
        returns: Vec::new(),
        signals: rig.mounts.iter().enumerate().map(signal).collect(),
    })
}

/// A drive along x from 0 to 0.6 m in steps of 10 mm.
fn drive(walls: &[WallSegment], gain: impl Fn(usize) -> f64) -> Vec<Record> {
    let pose = |step: u32| Pose2::new(f64::from(step) * 0.01, 0.0, 0.0);
    (0..=60)
        .map(|step| scan(&rig(), pose(step), walls, &gain))
        .collect()
}

fn mapped(parameters: WallMapParameters, records: &[Record]) -> WallMapper {
    let mut mapper = WallMapper::new(CELL_M, &rig(), parameters);
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper
}

/// Greatest distance between the ends of two walls, in the order that fits.
fn apart_m(one: &WallSegment, other: &WallSegment) -> f64 {
    let worst = |from: Vector, to: Vector| (one.from - from).norm().max((one.to - to).norm());
    worst(other.from, other.to).min(worst(other.to, other.from))
}

const FACE: ((f64, f64), (f64, f64)) = ((0.2, 0.13), (0.4, 0.15));

#[test]
fn ends_of_a_wall_are_found_from_signals_without_noise() {
    let truth = wall(FACE.0, FACE.1);
    let mapper = mapped(WallMapParameters::STANDARD, &drive(&[truth], |_| 1.0));
    let [found] = mapper.walls() else {
        panic!("{:?}", mapper.walls());
    };
    // The prior of the length pulls at the ends: less than their standard deviation.
    assert!(apart_m(&found.segment, &truth) < 1e-3, "{found:?}");
    for (line, row) in found.covariance_m2.iter().enumerate() {
        let sigma_m = row[line].sqrt();
        assert!((1e-5..5e-3).contains(&sigma_m), "{found:?}");
    }
    assert!(found.gain > 1000.0, "{found:?}");
}

#[test]
fn two_walls_of_a_corner_are_told_apart() {
    let truth = [
        wall((0.1, 0.15), (0.75, 0.15)),
        wall((0.75, 0.15), (0.75, -0.2)),
    ];
    let mapper = mapped(WallMapParameters::STANDARD, &drive(&truth, |_| 1.0));
    let walls = mapper.walls();
    for wall in &truth {
        let nearest = walls.iter().map(|found| {
            // The far ends lie beyond what the sensors see.
            let middle = wall.at(0.5);
            middle.distance_from_segment(found.segment.from, found.segment.to)
        });
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 2e-3, "{wall:?}: {walls:?}");
    }
}

#[test]
fn the_map_is_occupied_at_the_wall_free_before_it_and_unknown_behind() {
    let mapper = mapped(
        WallMapParameters::STANDARD,
        &drive(&[wall((0.1, 0.155), (0.5, 0.155))], |_| 1.0),
    );
    let map = mapper.map();
    for step in 0..30 {
        let x = 0.155 + 0.01 * f64::from(step);
        assert_eq!(map.occupancy_at(x, 0.155), Occupancy::Occupied, "{x}");
        assert_eq!(map.occupancy_at(x, 0.105), Occupancy::Free, "{x}");
        assert_eq!(map.occupancy_at(x, 0.195), Occupancy::Unknown, "{x}");
        assert_eq!(map.occupancy_at(x, -0.105), Occupancy::Free, "{x}");
    }
    assert!(map.count(Occupancy::Occupied) < 45, "only the wall");
}

#[test]
fn finish_changes_nothing_the_second_time_and_takes_what_came_after_it() {
    let records = drive(&[wall(FACE.0, FACE.1)], |_| 1.0);
    let (first, rest) = records.split_at(25);
    let mut mapper = WallMapper::new(CELL_M, &rig(), WallMapParameters::STANDARD);
    first.iter().for_each(|record| mapper.take(record));
    assert_eq!(mapper.map().count(Occupancy::Free), 0, "before finish");
    mapper.finish(&mut |_| {});
    let half = (mapper.map(), mapper.walls().to_vec());
    mapper.finish(&mut |_| {});
    assert_eq!((mapper.map(), mapper.walls().to_vec()), half);
    rest.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    let whole = mapped(WallMapParameters::STANDARD, &records);
    assert_eq!(mapper.walls(), whole.walls());
    assert_eq!(mapper.map(), whole.map());
}

#[test]
fn finish_reports_each_stage_up_to_its_end() {
    let records = drive(&[wall(FACE.0, FACE.1)], |_| 1.0);
    let mut mapper = WallMapper::new(CELL_M, &rig(), WallMapParameters::STANDARD);
    records.iter().for_each(|record| mapper.take(record));
    let mut reports: Vec<FinishProgress> = Vec::new();
    mapper.finish(&mut |progress| reports.push(progress));
    for pair in reports.windows(2) {
        let is_next = pair[0].stage != pair[1].stage || pair[0].done <= pair[1].done;
        assert!(is_next && pair[1].done <= pair[1].of, "{pair:?}");
    }
    let mut searched = reports.iter().filter(|it| it.stage == "places searched");
    let last = searched.next_back().unwrap();
    assert_eq!((last.done, last.of), (61, 61));
    assert_eq!(reports.last().unwrap().stage, "rows drawn");
}

#[test]
fn gains_of_sensors_are_found_where_they_are_asked_for() {
    let truth = [
        wall((-0.1, 0.11), (0.8, 0.11)),
        wall((-0.1, -0.12), (0.8, -0.12)),
    ];
    let gains = [1.1, 0.95, 1.0, 1.05, 0.9, 1.1, 0.9, 1.0];
    let records = drive(&truth, |index| gains[index]);
    let parameters = WallMapParameters {
        gain_sigma: 0.1,
        ..WallMapParameters::STANDARD
    };
    let mapper = mapped(parameters, &records);
    // All gains together and the distance of the walls are hard to tell apart: each is held
    // against its own standard deviation, which has that in it.
    for (truth, found) in gains.iter().zip(mapper.gains()) {
        let error = (found.ratio.ln() - f64::ln(*truth)).abs();
        assert!(
            error < 2.0 * found.sigma && found.sigma < 0.1,
            "{truth}: {found:?}"
        );
    }
    let held = mapped(WallMapParameters::STANDARD, &records);
    assert!(held.gains().is_empty());
}

#[test]
fn readings_that_a_recorder_clipped_are_bounds() {
    let dark = 16.0;
    let clipped = drive(&[wall(FACE.0, FACE.1)], |_| 1.0)
        .into_iter()
        .map(|record| {
            let Record::Scan(mut scan) = record else {
                return record;
            };
            for signal in scan.signals.iter_mut().flatten() {
                *signal = signal.max(dark);
            }
            Record::Scan(scan)
        });
    let mapper = mapped(WallMapParameters::STANDARD, &clipped.collect::<Vec<_>>());
    let [found] = mapper.walls() else {
        panic!("dark readings are explained by walls: {:?}", mapper.walls());
    };
    assert!(
        apart_m(&found.segment, &wall(FACE.0, FACE.1)) < 3e-3,
        "{found:?}"
    );
}

#[test]
fn records_without_signals_give_an_empty_map() {
    let scan = |world_from_body, signals| {
        Record::Scan(RangeScan {
            stamp_us: 0,
            world_from_body,
            mounts: 0..8,
            returns: Vec::new(),
            signals,
        })
    };
    let here = Pose2::new(0.0, 0.0, 0.0);
    let records = [
        Record::OdometryReset { stamp_us: 0 },
        scan(here, Vec::new()),
        scan(here, vec![None; 8]),
        scan(here, vec![Some(f64::NAN); 20]),
        scan(Pose2::new(f64::NAN, 0.0, 0.0), vec![Some(100.0); 8]),
        scan(Pose2::new(1e300, 0.0, 0.0), vec![Some(100.0); 8]),
    ];
    let mapper = mapped(WallMapParameters::STANDARD, &records);
    assert_eq!(mapper.walls(), []);
    assert_eq!(mapper.map().count(Occupancy::Occupied), 0);
}

#[test]
fn a_robot_that_drives_to_and_fro_for_long_is_bounded_work() {
    let walls = [wall(FACE.0, FACE.1)];
    let once = drive(&walls, |_| 1.0);
    let mut mapper = WallMapper::new(CELL_M, &rig(), WallMapParameters::STANDARD);
    for _ in 0..200 {
        once.iter().for_each(|record| mapper.take(record));
    }
    // 8 of each square of 20 mm and direction; 61 places lie in 31 squares.
    assert_eq!(mapper.left_out(), 200 * 61 - 8 * 31);
    mapper.finish(&mut |_| {});
    assert_eq!(mapper.walls().len(), 1);
}
