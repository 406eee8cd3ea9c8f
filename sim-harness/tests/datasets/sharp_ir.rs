//! Sweeps of an infrared sensor on a servo, through the public interface.

use std::fs;
use std::path::{Path, PathBuf};

use sim_harness::datasets::{
    Dataset, DatasetError, DriveFile, PoseSource, ReadRows, SharpIr, recognise,
};
use sim_harness::drive::{Record, Return};
use sim_harness::log::Place;
use sim_harness::rig::Rig;
use tempfile::TempDir;

use crate::common::{own_folder, recordings, report_skipped, root};

fn rig(name: &str) -> Rig {
    Rig::load(&root().join("rigs").join(name)).unwrap()
}

fn file(name: &str, text: &str) -> (TempDir, PathBuf) {
    let folder = own_folder("sharp-ir");
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    (folder, path)
}

fn read_with(path: &Path, rig: &Rig) -> Result<(Vec<Record>, ReadRows), DatasetError> {
    let drive = DriveFile {
        path,
        rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut records = Vec::new();
    let rows = SharpIr.read(&drive, &mut |_, _| {}, &mut |record| {
        records.push(record.clone());
    })?;
    Ok((records, rows))
}

fn read(path: &Path) -> Result<(Vec<Record>, ReadRows), DatasetError> {
    read_with(path, &rig("sharp_ir.toml"))
}

/// Bearing in degrees and return of each reading.
fn readings(records: &[Record]) -> Vec<(f64, Return)> {
    let scans = records.iter().filter_map(|record| match record {
        Record::Scan(scan) => {
            let bearing_deg = scan.world_from_body.heading_rad().to_degrees();
            Some((bearing_deg, scan.returns[0]))
        }
        _ => None,
    });
    scans.collect()
}

fn echo(measured: Return) -> f64 {
    match measured {
        Return::Echo { range_m, .. } => range_m,
        _ => f64::NAN,
    }
}

/// A row of the list with the same text for each distance but one.
fn row(distance: &str, at: usize, other: &str) -> String {
    let mut row = vec![distance; 60];
    row[at] = other;
    format!("[{}]", row.join(", "))
}

#[test]
fn points_are_bearings_and_ranges() {
    let (_folder, path) = file("test2d.csv", "30.0,0.0,-40\r\n40.0,25.0,30\r\n");
    assert_eq!(recognise(&path).unwrap().name(), "sharp_ir");
    let (records, rows) = read(&path).unwrap();
    assert_eq!((rows.used, rows.refused.count), (3, 0), "{}", rows.refused);
    let expected = [(53.1301, 0.5), (90.0, 0.25), (143.1301, 0.5)];
    for ((bearing_deg, measured), (expected_deg, range_m)) in
        readings(&records).into_iter().zip(expected)
    {
        assert!((bearing_deg - expected_deg).abs() < 1e-3, "{bearing_deg}");
        assert!((echo(measured) - range_m).abs() < 1e-12);
    }
}

#[test]
fn a_bad_point_is_refused_with_its_line_and_value() {
    let text = "30.0,zz,nan,1e9,5,0\n40.0,25.0,1,1,-5,8\n";
    let (_folder, path) = file("test2d.csv", text);
    // With a word in it, it is not recognised; with numbers that are too large it is.
    assert!(recognise(&path).is_err());
    let (_folder, path) = file("test2d.csv", &text.replace("zz", "1e9"));
    let (records, rows) = read(&path).unwrap();
    assert_eq!((rows.used, rows.refused.count), (2, 4), "{}", rows.refused);
    let words = rows.refused.to_string();
    for reason in [
        "line 1: value 2 is no distance",
        "line 1: value 3 is no distance",
        "line 2: value 5 is behind the sensor",
    ] {
        assert!(words.contains(reason), "{reason}: {words}");
    }
    // 8 cm are nearer than the sensor measures.
    assert_eq!(readings(&records)[1].1, Return::TooClose);
}

#[test]
fn every_second_row_of_distances_is_swept_back() {
    let text = format!("[{}, {}]", row("50", 1, "40"), row("50", 1, "114.4273"));
    let (_folder, path) = file("data.txt", &text);
    assert_eq!(recognise(&path).unwrap().name(), "sharp_ir");
    let (records, rows) = read(&path).unwrap();
    assert_eq!((rows.used, rows.refused.count), (2, 0), "{}", rows.refused);
    let resets = records
        .iter()
        .filter(|record| matches!(record, Record::OdometryReset { .. }));
    assert_eq!(resets.count(), 1);
    let readings = readings(&records);
    assert_eq!(readings.len(), 120);
    for (index, bearing_deg) in [(0, 60.0), (59, 119.0), (60, 119.0), (119, 60.0)] {
        assert!((readings[index].0 - bearing_deg).abs() < 1e-9, "{index}");
    }
    assert!((echo(readings[1].1) - 0.4).abs() < 1e-12);
    let Return::NoEcho { limit_m, .. } = readings[61].1 else {
        panic!("{:?}", readings[61]);
    };
    assert!((limit_m - 1.144_273).abs() < 1e-12);
}

#[test]
fn a_bad_row_of_distances_is_refused_with_its_byte_and_keeps_its_direction() {
    let long = "7".repeat(1 << 20);
    let rows = [
        row("50", 0, "50"),
        row("50", 3, "\u{1b}[2J"),
        row("50", 3, "-1"),
        row("50", 3, ""),
        row("50", 3, &long),
        "[1, 2, 3]".to_owned(),
        row("50", 0, "60"),
    ];
    let text = format!("[{}", rows.join(", "));
    let (_folder, path) = file("data.txt", &text);
    let (records, read_rows) = read(&path).unwrap();
    assert_eq!(read_rows.used, 2, "{}", read_rows.refused);
    // The bracket of the escape sequence is within a row and begins none.
    assert_eq!(read_rows.refused.count, 5, "{}", read_rows.refused);
    // Row 6 from 0: forwards.
    let last = readings(&records)[60];
    assert!((last.0 - 60.0).abs() < 1e-9);
    assert!((echo(last.1) - 0.6).abs() < 1e-12);
    let first = read_rows.refused.first[0].place;
    assert_eq!(first, Place::Byte(1 + rows[0].len() as u64 + 2));
    let words = read_rows.refused.to_string();
    for reason in [
        "'' is no number",
        "3 values where 60 are expected",
        "a distance is not 0 to 10000 cm",
    ] {
        assert!(
            words.contains(reason) || read_rows.refused.count > 5,
            "{reason}: {words}"
        );
    }
    assert!(!words.contains('\u{1b}'), "{words}");
}

#[test]
fn a_list_that_was_cut_keeps_its_whole_rows() {
    let text = format!("[{}, {}]", row("50", 0, "50"), row("50", 0, "50"));
    for end in 0..text.len() {
        let (_folder, path) = file("data.txt", &text[..end]);
        let whole = text[..end].matches(']').count().min(2);
        match read(&path) {
            Ok((records, rows)) => {
                assert_eq!(
                    (rows.used, readings(&records).len()),
                    (whole as u64, 60 * whole)
                );
            }
            Err(error) => assert_eq!(whole, 0, "{end}: {error}"),
        }
    }
}

#[test]
fn other_files_and_rigs_are_refused() {
    for text in [
        "",
        "1,2,3\n",
        "1,2\n3\n",
        "1\n2\n",
        "1,2\n3,4\n5,6\n",
        "[1, 2]",
        "{}",
    ] {
        let (_folder, path) = file("other", text);
        assert!(recognise(&path).is_err(), "{text}");
    }
    let (_folder, path) = file("test2d.csv", "1,2\n3,4\n");
    let error = read_with(&path, &rig("kcma.toml")).unwrap_err().to_string();
    assert!(error.contains("needs one scanner of one beam"), "{error}");
}

#[test]
fn the_recorded_sweeps_are_read_whole() {
    let Some(folder) = recordings().map(|folder| folder.join("sharp_ir")) else {
        report_skipped("the recorded sweeps are missing");
        return;
    };
    let points = folder.join("kzhang_DIY-3D-Scanner/test2d.csv");
    assert_eq!(recognise(&points).unwrap().name(), "sharp_ir");
    let (records, rows) = read(&points).unwrap();
    assert_eq!((rows.used, rows.refused.count), (60, 0), "{}", rows.refused);
    for (index, (bearing_deg, measured)) in readings(&records).into_iter().enumerate() {
        assert!((bearing_deg - 60.0 - index as f64).abs() < 1e-6, "{index}");
        assert!((0.28..0.70).contains(&echo(measured)), "{index}");
    }
    let list = folder.join("jcuhnoio_3dscanner/data.txt");
    assert_eq!(recognise(&list).unwrap().name(), "sharp_ir");
    let (records, rows) = read(&list).unwrap();
    assert_eq!((rows.used, rows.refused.count), (50, 0), "{}", rows.refused);
    let all = readings(&records);
    assert_eq!(all.len(), 3000);
    let silent = all
        .iter()
        .filter(|(_, measured)| matches!(measured, Return::NoEcho { .. }));
    assert_eq!(silent.count(), 1637);
}
