//! Recordings of drones with time-of-flight rows, through the public interface.

use std::fs;
use std::path::Path;

use sim_harness::datasets::{
    Dataset, DatasetError, DriveFile, NanoSwarm, PoseSource, ReadRows, recognise,
};
use sim_harness::drive::{RangeScan, Record, Return};
use sim_harness::geometry::{Pose2, Vector};
use sim_harness::log::Place;
use sim_harness::rig::Rig;
use sim_harness::sensors::Sensor;
use tempfile::TempDir;

use crate::common::{own_folder, recordings, report_skipped, root};

fn rig(name: &str) -> Rig {
    Rig::load(&root().join("rigs").join(name)).unwrap()
}

/// The digits of a scan in which every frame has the same distances and the same pose.
fn digits(millimetres: &[i16; 32], pose: [f32; 3]) -> String {
    let mut bytes = vec![0; 4];
    for _ in 0..15 {
        bytes.extend(millimetres.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend(pose.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A folder of scans with their poses by motion capture.
fn recording(scans: &str, captured: &str) -> TempDir {
    let folder = own_folder("nano-swarm");
    fs::write(folder.path().join("scans.csv"), scans).unwrap();
    fs::write(folder.path().join("vicon_poses.csv"), captured).unwrap();
    folder
}

fn read(
    folder: &Path,
    rig: &Rig,
    poses: PoseSource,
) -> Result<(Vec<Record>, ReadRows), DatasetError> {
    let drive = DriveFile {
        path: folder,
        rig,
        poses,
        calibration: None,
        profile: None,
    };
    let mut records = Vec::new();
    let rows = NanoSwarm.read(&drive, &mut |_, _| {}, &mut |record| {
        records.push(record.clone());
    })?;
    Ok((records, rows))
}

fn captured(folder: &Path) -> (Vec<Record>, ReadRows) {
    read(folder, &rig("nano_swarm.toml"), PoseSource::MotionCapture).unwrap()
}

fn scans(records: &[Record]) -> Vec<&RangeScan> {
    let scans = records.iter().filter_map(|record| match record {
        Record::Scan(scan) => Some(scan),
        _ => None,
    });
    scans.collect()
}

/// Ranges of the returns with an echo.
fn ranges(scan: &RangeScan) -> impl Iterator<Item = f64> {
    scan.returns.iter().filter_map(|measured| match measured {
        Return::Echo { range_m, .. } => Some(*range_m),
        _ => None,
    })
}

const FACING_X: &str = "1.0,2.0,0.6,1.0,0.0,0.0,0.0";

#[test]
fn distances_along_the_axis_become_ranges_along_beams() {
    let mut millimetres = [-1; 32];
    millimetres[0] = 1000;
    millimetres[8] = 0;
    millimetres[31] = 1999;
    let row = digits(&millimetres, [0.0; 3]);
    let folder = recording(&format!("0/0,{row}\n"), &format!("0/0,{FACING_X}\n"));
    let (records, rows) = captured(folder.path());
    assert_eq!((rows.used, rows.refused.count), (1, 0));
    let scans = scans(&records);
    assert_eq!(scans.len(), 15);
    let returns = &scans[0].returns;
    assert_eq!(returns.len(), 32);
    let cosine = f64::cos(19.6875_f64.to_radians());
    let first = ranges(scans[0]).next().unwrap();
    assert!((first - 1.0 / cosine).abs() < 1e-12, "{first}");
    assert_eq!(returns[1], Return::Invalid);
    assert_eq!(returns[8], Return::TooClose);
    // 1.999 m along the axis are 2.12 m along the beam.
    let limit = Return::NoEcho {
        limit_m: 2.0,
        sigma_m: 0.02,
    };
    assert_eq!(returns[31], limit);
    assert!(
        scans
            .windows(2)
            .all(|two| two[0].stamp_us < two[1].stamp_us)
    );
}

#[test]
fn a_rig_of_cones_gets_the_shortest_range_of_each_row() {
    let mut millimetres = [-1; 32];
    millimetres[..8].copy_from_slice(&[900, 800, 700, 650, 600, 700, -5, 900]);
    let row = digits(&millimetres, [0.0; 3]);
    let folder = recording(&format!("0/0,{row}\n"), &format!("0/0,{FACING_X}\n"));
    let wide = rig("nano_swarm_wide.toml");
    let (records, _) = read(folder.path(), &wide, PoseSource::MotionCapture).unwrap();
    let scans = scans(&records);
    let nearest = 0.6 / f64::cos(2.8125_f64.to_radians());
    assert!((ranges(scans[0]).next().unwrap() - nearest).abs() < 1e-12);
    assert_eq!(scans[0].returns[1..], [Return::Invalid; 3]);
}

#[test]
fn the_pose_of_a_frame_is_in_the_body_frame_of_the_scan() {
    // A quarter turn to the left: 0.1 m ahead is 0.1 m along y.
    let row = digits(&[500; 32], [0.1, 0.0, 0.5]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let poses = format!("0/0,1.0,2.0,0.6,{half},0.0,0.0,{half}\n");
    let folder = recording(&format!("0/0,{row}\n"), &poses);
    let (records, _) = captured(folder.path());
    let pose = records[0].pose().unwrap();
    // 1e-7: the frame's values have single precision.
    assert!((pose.position - Vector::new(1.0, 2.1)).norm() < 1e-7);
    let expected = Pose2::new(0.0, 0.0, std::f64::consts::FRAC_PI_2 + 0.5);
    assert!(pose.turn_to(&expected) < 1e-7);
}

#[test]
fn drones_are_read_one_after_the_other_with_a_reset_between_them() {
    let row = digits(&[500; 32], [0.0; 3]);
    let scans = format!("0/0,{row}\n1/0,{row}\n0/1,{row}\n1/1,{row}\n");
    let pose = |key: &str, x: f64| format!("{key},{x},0.0,0.6,1.0,0.0,0.0,0.0\n");
    let poses = [
        pose("0/0", 0.0),
        pose("0/1", 1.0),
        pose("1/0", 5.0),
        pose("1/1", 6.0),
    ]
    .concat();
    let folder = recording(&scans, &poses);
    let (records, rows) = captured(folder.path());
    assert_eq!(rows.used, 4);
    let mut last = 0;
    let mut places = Vec::new();
    for record in &records {
        match record {
            Record::Pose {
                stamp_us,
                world_from_body,
            } => {
                assert!(*stamp_us >= last);
                last = *stamp_us;
                places.push(world_from_body.position.x);
            }
            Record::OdometryReset { .. } => places.push(f64::INFINITY),
            _ => {}
        }
    }
    places.dedup();
    assert_eq!(places, [0.0, 1.0, f64::INFINITY, 5.0, 6.0]);
}

#[test]
fn of_several_rows_the_first_is_the_odometry_and_the_last_is_matched() {
    let row = digits(&[500; 32], [0.0; 3]);
    let folder = recording(&format!("0/0,{row}\n"), "");
    let poses = "0/0,1.0,0.0,0.0\n0/0,2.0,0.0,0.0\n0/0,3.0,0.0,0.0\n";
    fs::write(folder.path().join("poses.csv"), poses).unwrap();
    for (source, x) in [(PoseSource::Odometry, 1.0), (PoseSource::Matched, 3.0)] {
        let (records, _) = read(folder.path(), &rig("nano_swarm.toml"), source).unwrap();
        let pose = records[0].pose().unwrap();
        assert_eq!(pose.position, Vector::new(x, 0.0), "{source}");
    }
}

#[test]
fn a_bad_row_is_refused_with_its_place_and_the_others_are_used() {
    let good = digits(&[500; 32], [0.0; 3]);
    let not_finite = digits(&[500; 32], [f32::NAN, 0.0, 0.0]);
    let rows = [
        format!("0/0,{good}"),
        // Cut in the middle of a frame.
        format!("0/1,{}", &good[..1000]),
        format!("0/2,{not_finite}"),
        format!("0/3,{}", good.replacen("f4", "zz", 1)),
        format!("\u{1b}[2J,{good}"),
        // Without a pose.
        format!("0/9,{good}"),
        format!("0/4,{good}"),
    ];
    let poses: String = (0..5)
        .map(|scan| format!("0/{scan},{FACING_X}\n"))
        .collect();
    let folder = recording(&(rows.join("\n") + "\n"), &poses);
    let (_, read) = captured(folder.path());
    assert_eq!((read.used, read.refused.count), (2, 5));
    let first = &read.refused.first;
    let places: Vec<_> = first.iter().map(|row| row.place).collect();
    assert_eq!(places, [2, 3, 4, 5, 6].map(Place::Line));
    let words = read.refused.to_string();
    for reason in [
        "500 bytes where 1144 are expected",
        "frame 0 is not finite",
        "no hexadecimal digits",
        "is no drone/scan",
        "no pose for 0/9",
    ] {
        assert!(words.contains(reason), "{reason}: {words}");
    }
    assert!(!words.contains('\u{1b}'), "{words}");
}

#[test]
fn a_bad_pose_is_refused_and_its_scan_with_it() {
    let row = digits(&[500; 32], [0.0; 3]);
    let scans: String = (0..4).map(|scan| format!("0/{scan},{row}\n")).collect();
    let poses = format!(
        "0/0,{FACING_X}\n0/1,nan,0.0,0.6,1.0,0.0,0.0,0.0\n\
         0/2,0.0,0.0,0.6,0.0,0.0,0.0,0.0\n0/3,1e30,0.0,0.6,1.0,0.0,0.0,0.0\n"
    );
    let folder = recording(&scans, &poses);
    let (_, read) = captured(folder.path());
    assert_eq!((read.used, read.refused.count), (1, 6));
    let words = read.refused.to_string();
    assert!(
        words.contains("vicon_poses.csv line 2: 'nan' is no number"),
        "{words}"
    );
    assert!(
        words.contains("line 3: the norm of the quaternion is not 1"),
        "{words}"
    );
    assert!(
        words.contains("line 4: a pose that is not finite"),
        "{words}"
    );
}

#[test]
fn a_recording_without_a_usable_row_and_without_poses_is_an_error() {
    let folder = recording("0/0,00\n", &format!("0/0,{FACING_X}\n"));
    let nano = rig("nano_swarm.toml");
    let error = |poses| read(folder.path(), &nano, poses).unwrap_err().to_string();
    let none = error(PoseSource::MotionCapture);
    assert!(none.contains("no row of the format nano_swarm; "), "{none}");
    assert!(none.contains("1 bytes where 1144"), "{none}");
    let odometry = error(PoseSource::Odometry);
    assert!(odometry.contains("poses.csv is missing"), "{odometry}");
    assert!(odometry.contains("has no odometry poses"), "{odometry}");
}

#[test]
fn other_rigs_are_refused() {
    let row = digits(&[500; 32], [0.0; 3]);
    let folder = recording(&format!("0/0,{row}\n"), &format!("0/0,{FACING_X}\n"));
    let mut turned = rig("nano_swarm.toml");
    if let Sensor::Scanner(scanner) = &mut turned.mounts[2].sensor {
        scanner.step_rad = -scanner.step_rad;
    }
    for rig in [rig("kcma.toml"), rig("amiro.toml"), turned] {
        let error = read(folder.path(), &rig, PoseSource::MotionCapture).unwrap_err();
        assert!(
            error.to_string().contains("needs 4 scanners of 8 beams"),
            "{error}"
        );
    }
    assert_eq!(recognise(folder.path()).unwrap().name(), "nano_swarm");
}

#[test]
fn g17_the_recording_of_four_drones_has_the_published_beams() {
    let Some(folder) = recordings() else {
        report_skipped("the recordings of nano_swarm are missing");
        return;
    };
    let folder = folder.join("nano_swarm/exp1/four-drones");
    let (records, rows) = captured(&folder);
    assert_eq!((rows.used, rows.refused.count), (32, 0));
    let all = scans(&records);
    assert_eq!(all.len(), 480);
    // The published heading is asin(2 (x y + w z)), ours is exact for a drone that leans:
    // 4e-6 rad apart, and less than 6e-6 m over a beam.
    let within = 1e-5;
    let pose = |frame: usize| {
        let Pose2 { position, .. } = all[frame].world_from_body;
        [
            position.x,
            position.y,
            all[frame].world_from_body.heading_rad(),
        ]
    };
    for (frame, expected) in [
        (0, [-0.915154, -0.032135, 0.053465]),
        (14, [-0.898343, -0.036431, 0.823113]),
    ] {
        for (found, expected) in pose(frame).into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < within,
                "{frame}: {found} {expected}"
            );
        }
    }
    let is_valid = |measured: &&Return| !matches!(measured, Return::Invalid);
    assert_eq!(all[0].returns.iter().filter(is_valid).count(), 31);
    let first_m = ranges(all[0]).next().unwrap();
    assert!((first_m - 1.355_221).abs() < within, "{first_m}");
    let start = all[0].world_from_body.place(Vector::new(0.02, 0.0));
    let bearing_rad = all[0].world_from_body.heading_rad() + 19.6875_f64.to_radians();
    assert!((start - Vector::new(-0.895_182, -0.031_066)).norm() < within);
    let end = start + Vector::new(bearing_rad.cos(), bearing_rad.sin()).scaled(first_m);
    assert!(
        (end - Vector::new(0.354_596, 0.493_030)).norm() < within,
        "{end:?}"
    );
    let valid: usize = all
        .iter()
        .map(|scan| scan.returns.iter().filter(is_valid).count())
        .sum();
    assert_eq!(valid, 14_109);
    assert_eq!(all.iter().flat_map(|scan| ranges(scan)).count(), 12_031);
    let sum_m: f64 = all.iter().flat_map(|scan| ranges(scan)).sum();
    assert!((sum_m - 10_436.335).abs() < 1e-3, "{sum_m}");
    let wide = rig("nano_swarm_wide.toml");
    let (records, _) = read(&folder, &wide, PoseSource::MotionCapture).unwrap();
    let cones = scans(&records);
    assert_eq!(cones.iter().flat_map(|scan| ranges(scan)).count(), 1919);
    let sum_m: f64 = cones.iter().flat_map(|scan| ranges(scan)).sum();
    assert!((sum_m - 1507.228).abs() < 1e-3, "{sum_m}");
}
