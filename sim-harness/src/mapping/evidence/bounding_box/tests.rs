//! The box against tabulated numbers, and which sensors make its sides.

use super::*;
use crate::geometry::Pose2;
use crate::mapping::test_drives::{echo, no_echo, rig_of, scan_of};
use crate::sensors::{Cone, Directivity, Scanner};

/// Keeps the scans that it is given.
#[derive(Default)]
struct Kept(Vec<RangeScan>);

impl Mapper for Kept {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.0.push(scan.clone());
        }
    }

    fn map(&self) -> Map {
        Map::unknown(0.1)
    }
}

fn cone(heading_deg: f64, at: (f64, f64)) -> (Sensor, Pose2) {
    let sensor = Sensor::Cone(Cone {
        half_angle_rad: 0.2,
        range_m: [0.05, 5.0],
        sigma_m: 0.0,
        directivity: Directivity::Piston,
    });
    (sensor, Pose2::new(at.0, at.1, heading_deg.to_radians()))
}

/// What a box makes of one cycle.
fn boxed(rig: &Rig, returns: Vec<Return>) -> (Vec<Return>, u64) {
    let mut mapper = BoxMapper::new(Kept::default(), rig, |_| true);
    mapper.take(&scan_of(rig, (0.0, 0.0, 0.3), returns));
    assert!(mapper.mapper().0.is_empty(), "the cycle has not ended");
    mapper.finish(&mut |_| {});
    mapper.finish(&mut |_| {});
    let [scan] = mapper.mapper().0.as_slice() else {
        panic!("one scan was given");
    };
    (scan.returns.clone(), mapper.shortened())
}

fn range_m(measured: Return) -> f64 {
    match measured {
        Return::Echo { range_m, .. } => range_m,
        other => panic!("no echo: {other:?}"),
    }
}

#[test]
fn g13_a_reading_is_shortened_to_where_its_axis_leaves_the_box() {
    let rig = rig_of(vec![
        cone(0.0, (0.0, 0.0)),
        cone(30.0, (0.15, 0.08)),
        cone(90.0, (0.0, 0.0)),
    ]);
    // The front at 0.30 m, the left side open.
    let (found, shortened) = boxed(&rig, vec![echo(0.3), echo(2.0), no_echo(5.0)]);
    assert!((range_m(found[1]) - 0.173_205_081).abs() < 1e-9);
    assert_eq!(shortened, 1);
    assert_eq!([found[0], found[2]], [echo(0.3), no_echo(5.0)]);
    let (found, shortened) = boxed(&rig, vec![echo(0.3), echo(0.1), no_echo(5.0)]);
    assert_eq!((found[1], shortened), (echo(0.1), 0));
    // The left side at 0.2 m lies 0.24 m along the axis.
    let (found, _) = boxed(&rig, vec![echo(0.3), echo(2.0), echo(0.2)]);
    assert!((range_m(found[1]) - 0.173_205_081).abs() < 1e-9);
    let (found, _) = boxed(&rig, vec![no_echo(5.0), echo(2.0), echo(0.2)]);
    assert!((range_m(found[1]) - 0.24).abs() < 1e-9);
}

#[test]
fn a_reading_without_an_echo_becomes_one_at_the_box_and_far_sides_are_open() {
    let rig = rig_of(vec![cone(0.0, (0.0, 0.0)), cone(45.0, (0.0, 0.0))]);
    let (found, _) = boxed(&rig, vec![echo(1.0), no_echo(5.0)]);
    assert!((range_m(found[1]) - f64::sqrt(2.0)).abs() < 1e-9);
    let (found, shortened) = boxed(&rig, vec![echo(3.0), no_echo(5.0)]);
    assert_eq!((found[1], shortened), (no_echo(5.0), 0));
    for silent in [Return::TooClose, Return::Invalid] {
        let (found, shortened) = boxed(&rig, vec![echo(1.0), silent]);
        assert_eq!((found[1], shortened), (silent, 0));
    }
    // Nearer than the sensor measures: 0.02 m before it.
    let (found, shortened) = boxed(&rig, vec![echo(0.01), echo(2.0)]);
    assert_eq!((found[1], shortened), (echo(2.0), 0));
}

#[test]
fn the_sides_follow_from_the_rig() {
    let sides = |rig: &Rig| -> Vec<Vec<Option<Side>>> {
        let axes = |mount| Axis::of(mount).iter().map(|axis| axis.side).collect();
        rig.mounts.iter().map(axes).collect()
    };
    use Side::{Front, Left, Rear, Right};
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../rigs");
    let kcma = sides(&Rig::load(&root.join("kcma.toml")).unwrap());
    let expected = [Some(Right), None, None, Some(Front), Some(Front)];
    let mut expected = Vec::from(expected);
    expected.extend([None, None, Some(Left)]);
    assert_eq!(kcma[..8].concat(), expected);
    let pioneer = sides(&Rig::load(&root.join("pioneer2dx.toml")).unwrap()).concat();
    let count = |wanted| pioneer.iter().filter(|side| **side == Some(wanted)).count();
    assert_eq!([Front, Left, Rear, Right].map(count), [2, 2, 2, 2]);
    // Eight columns of a time-of-flight row, 5.6 degrees apart: the two in the middle.
    let step_rad = -(45.0_f64 / 8.0).to_radians();
    let row = Sensor::Scanner(Scanner {
        beams: 8,
        first_rad: -3.5 * step_rad,
        step_rad,
        range_m: [0.02, 2.0],
        sigma_m: 0.0,
    });
    let row = sides(&rig_of(vec![(
        row,
        Pose2::new(-0.02, 0.0, 180_f64.to_radians()),
    )]));
    let expected = [None, None, None, Some(Rear), Some(Rear), None, None, None];
    assert_eq!(row.concat(), expected);
    let ring = sides(&Rig::load(&root.join("amiro.toml")).unwrap());
    assert!(ring.concat().iter().all(Option::is_none));
}

#[test]
fn scans_of_one_stamp_are_one_cycle_and_mounts_that_are_not_mapped_make_no_side() {
    let rig = rig_of(vec![cone(0.0, (0.0, 0.0)), cone(45.0, (0.0, 0.0))]);
    let part = |index: usize, measured| match scan_of(&rig, (0.0, 0.0, 0.0), vec![measured]) {
        Record::Scan(scan) => Record::Scan(RangeScan {
            mounts: index..index + 1,
            ..scan
        }),
        other => other,
    };
    // The scan that makes the side comes last.
    let mut mapper = BoxMapper::new(Kept::default(), &rig, |_| true);
    mapper.take(&part(1, echo(2.0)));
    mapper.take(&part(0, echo(1.0)));
    mapper.take(&Record::OdometryReset { stamp_us: 0 });
    assert_eq!(mapper.mapper().0.len(), 2);
    assert_eq!(mapper.shortened(), 1);
    let mut mapper = BoxMapper::new(Kept::default(), &rig, |it| it.name != "sensor 0");
    mapper.take(&part(1, echo(2.0)));
    mapper.take(&part(0, echo(1.0)));
    mapper.finish(&mut |_| {});
    assert_eq!(mapper.shortened(), 0);
}
