//! The scene of four sonar echoes with tabulated maps, for tests.
//!
//! Cells of 0.1 m; three sonars look along x at a wall, the fourth echo is over-long.

use crate::drive::{RangeScan, Record, Return};
use crate::geometry::Pose2;
use crate::lattice::{Cell, Lattice};
use crate::rig::{Rig, SensorMount};
use crate::sensors::{Cone, Directivity, Sensor};

pub(super) const CELL_M: f64 = 0.1;

/// Place of the sensor and range, metres.
const ECHOES: [([f64; 2], f64); 4] = [
    ([0.51, 1.53], 1.52),
    ([0.51, 1.23], 1.52),
    ([0.51, 1.83], 1.52),
    ([0.51, 1.53], 2.61),
];

pub(super) fn lattice() -> Lattice {
    Lattice::new(CELL_M)
}

/// A robot with one cone of 25 degrees, which looks forward.
pub(super) fn rig(directivity: Directivity) -> Rig {
    Rig {
        name: "one".to_owned(),
        about: "One sensor that looks forward.".to_owned(),
        radius_m: 0.1,
        track_m: None,
        mounts: vec![SensorMount {
            name: "sonar".to_owned(),
            body_from_sensor: Pose2::new(0.0, 0.0, 0.0),
            sensor: Sensor::Cone(Cone {
                half_angle_rad: 12.5_f64.to_radians(),
                range_m: [0.1, 5.0],
                sigma_m: 0.0,
                directivity,
            }),
        }],
    }
}

/// A scan of one return, at a place with a heading of 0.
pub(super) fn scan(stamp_us: u64, place: [f64; 2], measured: Return) -> Record {
    let [x, y] = place;
    Record::Scan(RangeScan {
        stamp_us,
        world_from_body: Pose2::new(x, y, 0.0),
        mounts: 0..1,
        returns: vec![measured],
        signals: Vec::new(),
    })
}

pub(super) fn echo(range_m: f64) -> Return {
    Return::Echo {
        range_m,
        sigma_m: 0.0,
    }
}

/// The four echoes.
pub(super) fn records() -> Vec<Record> {
    let scans = ECHOES.iter().zip(0..);
    scans
        .map(|((place, range_m), stamp_us)| scan(stamp_us, *place, echo(*range_m)))
        .collect()
}

/// The cells of columns and rows.
pub(super) fn block(
    columns: core::ops::RangeInclusive<i32>,
    rows: core::ops::RangeInclusive<i32>,
) -> Vec<Cell> {
    let cells = rows.flat_map(|row| columns.clone().map(move |column| Cell { row, column }));
    cells.collect()
}
