//! Logs of the robot server Player 1, through the public interface.

use std::fs;
use std::path::{Path, PathBuf};

use sim_harness::datasets::{
    Dataset, DatasetError, DriveFile, Player, PoseSource, ReadRows, recognise,
};
use sim_harness::drive::{RangeScan, Record, Return};
use sim_harness::geometry::Vector;
use sim_harness::log::Place;
use sim_harness::rig::Rig;
use tempfile::TempDir;

use crate::common::{own_folder, recordings, report_skipped, root};

fn rig(name: &str) -> Rig {
    Rig::load(&root().join("rigs").join(name)).unwrap()
}

/// A row of the interface at a time, both as the server writes them.
fn row(time_s: f64, interface: &str, values: &str) -> String {
    let written_s = time_s + 0.011;
    format!("{written_s:014.3} robot 6665 {interface} 00 {time_s:014.3} {values}\n")
}

fn position(time_s: f64, x_m: f64, heading_rad: f64) -> String {
    let values = format!("{x_m:+07.3} +00.000 {heading_rad:+.3} +00.100 +00.000 +00.000 0");
    row(time_s, "position", &values)
}

/// The poses of the rig's sonars and these ranges.
fn sonar(time_s: f64, ranges_m: [f64; 16]) -> String {
    let mut values = "16".to_owned();
    for mount in &rig("pioneer2dx.toml").mounts {
        let at = mount.body_from_sensor;
        let heading_rad = at.heading_rad();
        let Vector { x, y } = at.position;
        values += &format!(" {x:+07.3} {y:+07.3} {heading_rad:+07.4}");
    }
    values += " 16";
    for range_m in ranges_m {
        values += &format!(" {range_m:.3}");
    }
    row(time_s, "sonar", &values)
}

fn laser(time_s: f64, range_m: f64) -> String {
    let mut values = "-01.5708 +01.5708 +0.01745329 0181".to_owned();
    for _ in 0..181 {
        values += &format!(" {range_m:.3}  0");
    }
    row(time_s, "laser", &values)
}

fn log(rows: &[String]) -> (TempDir, PathBuf) {
    let folder = own_folder("player");
    let path = folder.path().join("drive.log");
    fs::write(&path, rows.concat()).unwrap();
    (folder, path)
}

fn read(path: &Path, rig: &Rig) -> Result<(Vec<Record>, ReadRows), DatasetError> {
    let drive = DriveFile {
        path,
        rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut records = Vec::new();
    let rows = Player.read(&drive, &mut |_, _| {}, &mut |record| {
        records.push(record.clone());
    })?;
    Ok((records, rows))
}

fn scans(records: &[Record]) -> Vec<&RangeScan> {
    let scans = records.iter().filter_map(|record| match record {
        Record::Scan(scan) => Some(scan),
        _ => None,
    });
    scans.collect()
}

const START_S: f64 = 1_106_955_333.0;

#[test]
fn the_genuine_row_of_sonars_fits_the_rig_of_the_pioneer() {
    let Some(folder) = recordings() else {
        report_skipped("the row of Radish is missing");
        return;
    };
    let genuine = fs::read_to_string(folder.join("radish/sonar_line.txt")).unwrap();
    let rows = [
        "## a comment\n".to_owned(),
        position(1_106_955_333.276, 1.0, 0.5),
        genuine.trim_end().to_owned() + "\n",
    ];
    let (_folder, path) = log(&rows);
    assert_eq!(recognise(&path).unwrap().name(), "player");
    let (records, rows) = read(&path, &rig("pioneer2dx.toml")).unwrap();
    assert_eq!((rows.used, rows.refused.count), (2, 0), "{}", rows.refused);
    let scans = scans(&records);
    assert_eq!(scans[0].world_from_body.position, Vector::new(1.0, 0.0));
    let returns = &scans[0].returns;
    assert_eq!(returns.len(), 16);
    let echo = |range_m| Return::Echo {
        range_m,
        sigma_m: 0.03,
    };
    assert_eq!(returns[0], echo(0.326));
    assert_eq!(returns[14], echo(2.225));
    // 7.365 m are beyond what the rig's sonars measure.
    let none = Return::NoEcho {
        limit_m: 5.0,
        sigma_m: 0.03,
    };
    assert_eq!(returns[15], none);
}

#[test]
fn a_scan_has_the_pose_between_the_rows_around_it() {
    let rows = [
        position(START_S, 0.0, 3.1),
        laser(START_S + 0.025, 2.0),
        // Written late: it was measured before the row above.
        sonar(START_S + 0.0, [1.0; 16]),
        position(START_S + 0.1, 0.4, -3.1),
        laser(START_S + 0.1, 3.0),
        laser(START_S + 0.15, 9.0),
    ];
    let (_folder, path) = log(&rows);
    let (records, rows) = read(&path, &rig("pioneer2dx_laser.toml")).unwrap();
    assert_eq!((rows.used, rows.refused.count), (6, 0), "{}", rows.refused);
    let stamps: Vec<_> = records
        .iter()
        .map(|record| match record {
            Record::Pose { stamp_us, .. } => *stamp_us,
            Record::Scan(scan) => scan.stamp_us,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(stamps, [0, 0, 25_000, 100_000, 100_000, 150_000]);
    let scans = scans(&records);
    assert_eq!(scans[0].mounts, 0..16);
    let quarter = scans[1].world_from_body;
    assert!((quarter.position - Vector::new(0.1, 0.0)).norm() < 1e-6);
    // A quarter of the short way from 3.1 to -3.1.
    let heading_rad = 3.1 + 0.25 * (2.0 * std::f64::consts::PI - 6.2);
    assert!((quarter.heading_rad() - heading_rad).abs() < 1e-6);
    assert_eq!(scans[1].mounts, 16..17);
    assert_eq!(scans[1].returns.len(), 181);
    // Behind the last row of poses its pose holds.
    assert_eq!(scans[3].world_from_body, records[3].pose().unwrap());
    assert!(matches!(scans[3].returns[0], Return::NoEcho { .. }));
}

#[test]
fn bad_rows_are_refused_with_their_line_and_the_others_are_used() {
    let mut elsewhere = sonar(START_S + 0.1, [1.0; 16]);
    elsewhere = elsewhere.replacen("+00.115", "+00.215", 1);
    let rows = [
        position(START_S, 0.0, 0.0),
        row(START_S, "position", "+00.000 nan +00.000 0 0 0 0"),
        elsewhere,
        sonar(START_S + 0.1, [1.0; 16]).replacen(" 16 ", " 17 ", 1),
        sonar(START_S + 0.1, [1.0; 16]).replacen(" 1.000\n", "\n", 1),
        row(START_S, "laser", "0 0 0 1e30"),
        position(START_S - 5.0, 0.0, 0.0),
        sonar(START_S - 5.0, [1.0; 16]),
        "\u{1b}[2J\n".to_owned(),
        sonar(START_S + 0.2, [1.0; 16]),
        // An hour later.
        sonar(START_S + 3600.0, [1.0; 16]),
    ];
    let (_folder, path) = log(&rows);
    let (records, rows) = read(&path, &rig("pioneer2dx.toml")).unwrap();
    assert_eq!(rows.used, 2, "{}", rows.refused);
    assert_eq!(rows.refused.count, 9, "{}", rows.refused);
    assert_eq!(scans(&records).len(), 1);
    let places: Vec<_> = rows.refused.first.iter().map(|row| row.place).collect();
    assert_eq!(places, [2, 3, 4, 5, 6].map(Place::Line));
    let words = rows.refused.to_string();
    for reason in [
        "'nan' is no number",
        "sonar 0 is elsewhere on the rig",
        "the row ends too early",
        "number 1000000000000000000000000000000 is not 0 to 4096",
    ] {
        assert!(words.contains(reason), "{reason}: {words}");
    }
    assert!(!words.contains('\u{1b}'), "{words}");
}

#[test]
fn other_interfaces_devices_and_sensors_that_the_rig_lacks_are_counted() {
    let rows = [
        position(START_S, 0.0, 0.0),
        row(START_S, "gps", "1 2 3"),
        row(START_S, "gps", "1 2 3"),
        laser(START_S, 1.0),
        position(START_S, 7.0, 0.0).replacen(" position 00 ", " position 01 ", 1),
        sonar(START_S, [1.0; 16]),
    ];
    let (_folder, path) = log(&rows);
    let (_, rows) = read(&path, &rig("pioneer2dx.toml")).unwrap();
    assert_eq!((rows.used, rows.refused.count), (2, 0), "{}", rows.refused);
    let notes = [
        "2 rows of gps 00 passed over",
        "1 rows of laser 00 passed over",
        "1 rows of position 01 passed over",
    ];
    assert_eq!(rows.notes, notes);
}

#[test]
fn a_log_without_poses_of_version_2_or_for_another_rig_is_an_error() {
    let (_folder, path) = log(&[sonar(START_S, [1.0; 16])]);
    let error = read(&path, &rig("pioneer2dx.toml"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("no row of the format player; "), "{error}");
    assert!(error.contains("line 1: no position row is near"), "{error}");
    let error = read(&path, &rig("nano_swarm.toml"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("needs cones, or one scanner"), "{error}");
    let error = read(&path, &rig("amiro.toml")).unwrap_err().to_string();
    assert!(error.contains("needs cones, or one scanner"), "{error}");
    // Kind and subkind of the message in place of the data time.
    let later = "1306011115.200 16777343 6665 ranger 00 001 001 0.5\n".to_owned();
    let (_folder, path) = log(&[later]);
    assert!(recognise(&path).is_err());
}

#[test]
fn scans_without_a_pose_are_held_in_bounded_memory() {
    let mut rows: Vec<_> = (0..300_u32)
        .map(|index| sonar(START_S + 1e-3 * f64::from(index), [1.0; 16]))
        .collect();
    rows.insert(0, position(START_S, 0.0, 0.0));
    let (_folder, path) = log(&rows);
    let (_, rows) = read(&path, &rig("pioneer2dx.toml")).unwrap();
    assert_eq!((rows.used, rows.refused.count), (257, 44));
    let words = rows.refused.to_string();
    assert!(words.contains("more than 256 scans"), "{words}");
}
