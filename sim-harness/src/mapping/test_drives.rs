//! Robots and scans for the tests of mappers.

use std::path::Path;

use crate::datasets::{Dataset, DriveFile, Kcma, PoseSource};
use crate::drive::{Keyframes, RangeScan, Record, Return};
use crate::geometry::Pose2;
use crate::rig::{Rig, SensorMount};
use crate::sensors::{Cone, Directivity, Sensor};

/// A robot with the given sensors, called `sensor 0`, `sensor 1`, ...
pub(super) fn rig_of(sensors: Vec<(Sensor, Pose2)>) -> Rig {
    let mount = |(number, (sensor, body_from_sensor))| SensorMount {
        name: format!("sensor {number}"),
        body_from_sensor,
        sensor,
    };
    Rig {
        name: "test".to_owned(),
        about: "Sensors of a test.".to_owned(),
        radius_m: 0.1,
        track_m: None,
        mounts: sensors.into_iter().enumerate().map(mount).collect(),
    }
}

/// A robot with one sensor at its origin, which looks forward.
pub(super) fn forward(sensor: Sensor) -> Rig {
    rig_of(vec![(sensor, Pose2::new(0.0, 0.0, 0.0))])
}

/// A sonar of 12.5 degrees to each side and 5 m.
pub(super) fn sonar() -> Sensor {
    Sensor::Cone(Cone {
        half_angle_rad: 12.5_f64.to_radians(),
        range_m: [0.1, 5.0],
        sigma_m: 0.0,
        directivity: Directivity::Piston,
    })
}

/// A scan of all mounts of a rig at a pose (x, y, heading).
pub(super) fn scan_of(rig: &Rig, (x, y, heading): (f64, f64, f64), returns: Vec<Return>) -> Record {
    Record::Scan(RangeScan {
        stamp_us: 0,
        world_from_body: Pose2::new(x, y, heading),
        mounts: 0..rig.mounts.len(),
        returns,
        signals: Vec::new(),
    })
}

/// The sonar scans of the toy scene of MAPPERS, G15.
pub(super) fn toy_scene(rig: &Rig) -> [Record; 4] {
    [
        (0.51, 1.53, 1.52),
        (0.51, 1.23, 1.52),
        (0.51, 1.83, 1.52),
        (0.51, 1.53, 2.61),
    ]
    .map(|(x, y, range_m)| scan_of(rig, (x, y, 0.0), vec![echo(range_m)]))
}

pub(super) fn echo(range_m: f64) -> Return {
    Return::Echo {
        range_m,
        sigma_m: 0.0,
    }
}

pub(super) fn no_echo(limit_m: f64) -> Return {
    Return::NoEcho {
        limit_m,
        sigma_m: 0.0,
    }
}

/// A rig of the repository.
pub(super) fn rig_named(name: &str) -> Rig {
    Rig::load(
        &Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../rigs")
            .join(name),
    )
    .unwrap()
}

/// The rig `kcma` with the mounts and the limit of the tabulated figures: the file has the
/// sonars' positions to a micrometre, which moves a cell on the edge of a class, and ends
/// their range at 5.0 m, not at the 5.11 m that mean no echo.
fn tabulated_kcma() -> Rig {
    let mut rig = rig_named("kcma.toml");
    let distances_m = [0.18, 0.06, 0.03, 0.01, 0.01, 0.03, 0.06, 0.18];
    let degrees = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0];
    let places = distances_m.into_iter().zip(degrees.map(f64::to_radians));
    for (mount, (distance_m, heading_rad)) in rig.mounts.iter_mut().zip(places) {
        let pose = Pose2::new(0.0, 0.0, heading_rad);
        let position = pose.heading.direction().scaled(distance_m);
        mount.body_from_sensor = Pose2 { position, ..pose };
        if let Sensor::Cone(cone) = &mut mount.sensor {
            cone.range_m[1] = 5.11;
        }
    }
    rig
}

/// The keyframes of the recording `robond`: raw odometry, 0.10 m or 5 degrees apart.
pub(super) fn robond() -> (Rig, Vec<Record>) {
    let rig = tabulated_kcma();
    let drive = DriveFile {
        path: &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robond"),
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut keyframes = Keyframes::new(0.10, 5_f64.to_radians());
    let mut is_keyframe = false;
    let mut records = Vec::new();
    let mut take = |record: &Record| {
        if let Some(pose) = record.pose() {
            is_keyframe = keyframes.take(&pose);
        }
        if is_keyframe {
            records.push(record.clone());
        }
    };
    Kcma.read(&drive, &mut |_, _| {}, &mut take).unwrap();
    (rig, records)
}
