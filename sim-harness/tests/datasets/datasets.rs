//! Recorded drives of other robots, through the public interface.

use std::fs;
use std::path::{Path, PathBuf};

use sim_harness::datasets::{
    Dataset, DatasetError, DriveFile, Kcma, PoseSource, ReadRows, RefusedRows, recognise,
};
use sim_harness::drive::{Keyframes, Record, Return};
use sim_harness::log::Place;
use sim_harness::mapping::{Map, Mapper, Method, Occupancy, Setup};
use sim_harness::pipeline::{self, DriveFigures, DriveOptions, KeyframeShare, NothingMapped};
use sim_harness::rig::Rig;

use crate::common::report_skipped;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn robond() -> PathBuf {
    root().join("tests/data/robond")
}

fn rig() -> Rig {
    Rig::load(&root().join("../rigs/kcma.toml")).unwrap()
}

/// The usual keyframes of a drive, mapped with cells of 0.1 m.
fn mapped(drive: &Path, method: &str, sensors: &str, poses: PoseSource) -> (DriveFigures, Map) {
    let rig = rig();
    let options = DriveOptions {
        keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
        share: KeyframeShare::All,
        mounts: rig.mounts_named(&[sensors.to_owned()]),
    };
    let method: Method = method.parse().unwrap();
    let mut mapper = method.mapper(&Setup::new(&rig, 0.1));
    let drive = DriveFile {
        path: drive,
        rig: &rig,
        poses,
        calibration: None,
        profile: None,
    };
    let run = pipeline::run(
        |take| pipeline::dataset_records(&Kcma, &drive, &options, &mut |_, _| {}, take),
        &mut mapper,
        &mut |_, _| {},
    )
    .unwrap();
    (run.figures, mapper.map())
}

fn cells(map: &Map) -> (usize, usize) {
    (map.count(Occupancy::Occupied), map.count(Occupancy::Free))
}

/// A folder of the test's own, with the first `rows` rows of the drive.
fn copied(name: &str, rows: usize) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("ipf-datasets-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    for file in ["poses.txt", "measurement.txt"] {
        let text = fs::read_to_string(robond().join(file)).unwrap();
        let head: String = text.split_inclusive('\n').take(rows).collect();
        fs::write(folder.join(file), head).unwrap();
    }
    folder
}

/// A drive with a rig, read to its end.
fn read_with(
    folder: &Path,
    rig: &Rig,
    poses: PoseSource,
    take: &mut dyn FnMut(&Record),
) -> Result<ReadRows, DatasetError> {
    let drive = DriveFile {
        path: folder,
        rig,
        poses,
        calibration: None,
        profile: None,
    };
    Kcma.read(&drive, &mut |_, _| {}, take)
}

fn read(folder: &Path, poses: PoseSource) -> Result<(Vec<Record>, RefusedRows), DatasetError> {
    let mut records = Vec::new();
    let rows = read_with(folder, &rig(), poses, &mut |record| {
        records.push(record.clone());
    })?;
    Ok((records, rows.refused))
}

#[test]
fn sonar_maps_have_the_published_number_of_cells() {
    // Carvalho and Ventura's inverse sensor model by an independent implementation.
    for (method, expected) in [("ism", (1753, 11_924)), ("ism-decay", (2237, 11_673))] {
        let (figures, map) = mapped(&robond(), method, "sonar", PoseSource::Odometry);
        assert_eq!(cells(&map), expected, "{method}");
        assert_eq!(figures.poses, 413);
        assert_eq!(figures.keyframes, 187);
        assert_eq!(figures.echoes, 1038);
        assert_eq!(figures.echoes + figures.no_echoes + figures.invalid, 1496);
        assert_eq!(figures.refused_rows, 0);
    }
}

/// Keyframes, readings of the sonars at them, those with an echo, and the sum of their ranges.
fn sonar_readings(folder: &Path, poses: PoseSource) -> (usize, usize, usize, f64) {
    let (records, refused) = read(folder, poses).unwrap();
    assert_eq!(refused.count, 0, "{refused}");
    let mut keyframes = Keyframes::new(0.10, 5_f64.to_radians());
    let (mut is_keyframe, mut sum_m) = (false, 0.0);
    let [mut kept, mut readings, mut echoes] = [0; 3];
    for record in &records {
        match record {
            Record::Pose {
                world_from_body, ..
            } => {
                is_keyframe = keyframes.take(world_from_body);
                kept += usize::from(is_keyframe);
            }
            Record::Scan(scan) if is_keyframe && scan.mounts.start == 0 => {
                readings += scan.returns.len();
                for measured in &scan.returns {
                    if let Return::Echo { range_m, .. } = measured {
                        echoes += 1;
                        sum_m += range_m;
                    }
                }
            }
            _ => {}
        }
    }
    (kept, readings, echoes, sum_m)
}

#[test]
fn g18_readings_of_the_fixture() {
    let (keyframes, readings, echoes, sum_m) = sonar_readings(&robond(), PoseSource::Odometry);
    assert_eq!((keyframes, readings, echoes), (187, 1496, 1038));
    // The recording has millimetres.
    assert!((sum_m - 2434.2).abs() < 1e-6, "{sum_m}");
}

#[test]
fn g17_the_runs_of_kcma_have_the_published_keyframes() {
    let drives = root().join("../../shared/data/kcma");
    if !drives.is_dir() {
        report_skipped("the recordings of kcma are missing");
        return;
    }
    let kept = |run: &str, poses| {
        let (keyframes, readings, echoes, _) = sonar_readings(&drives.join(run), poses);
        (keyframes, readings, echoes)
    };
    let (keyframes, ..) = kept("test1", PoseSource::Odometry);
    assert_eq!(keyframes, 187);
    // Published for test4 are 232, 1856, 1629, of poses that were not rounded: with the
    // file's four decimals one pose has moved by 0.10001 m and is a keyframe too.
    for (run, expected) in [
        ("test1", (183, 1464, 1014)),
        ("test3", (102, 816, 677)),
        ("test4", (233, 1864, 1636)),
    ] {
        assert_eq!(kept(run, PoseSource::Matched), expected, "{run}");
    }
}

#[test]
fn a_laser_drive_maps_with_the_same_grid_as_a_sonar_drive() {
    let drive = root().join("../../shared/data/kcma/test1");
    if !drive.is_dir() {
        assert!(std::env::var_os("IPF_NO_SKIP").is_none(), "no recordings");
        return;
    }
    assert_eq!(recognise(&drive).unwrap().name(), "kcma");
    let (figures, map) = mapped(&drive, "ism", "laser", PoseSource::Matched);
    assert_eq!(figures.keyframes, 183);
    assert_eq!(figures.echoes + figures.no_echoes, 183 * 361);
    let (occupied, free) = cells(&map);
    assert!((1000..1300).contains(&occupied), "{occupied}");
    assert!(free > 20_000, "{free}");
}

#[test]
fn a_broken_row_costs_that_row_and_is_named() {
    let folder = copied("broken", 20);
    let path = folder.join("measurement.txt");
    let text = fs::read_to_string(&path).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[3] = lines[3].replace(' ', ",");
    lines[5].push_str(" 400");
    lines[7].truncate(20);
    lines[9] = lines[9].replacen("1", "9", 1);
    lines[11].push_str("\u{1b}[2J");
    fs::write(&path, lines.join("\n") + "\n").unwrap();
    let (records, refused) = read(&folder, PoseSource::Odometry).unwrap();
    assert_eq!(refused.count, 5, "{refused}");
    let scans = records
        .iter()
        .filter(|record| matches!(record, Record::Scan(_)));
    assert_eq!(scans.count(), 15);
    let places: Vec<_> = refused.first.iter().map(|row| row.place).collect();
    assert_eq!(places, [4, 6, 8, 10, 12].map(Place::Line));
    let words = refused.to_string();
    assert!(words.contains("measurement.txt line 4: "), "{words}");
    assert!(!words.contains('\u{1b}'), "{words}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_cut_row_at_the_end_is_refused_and_the_rest_is_kept() {
    let folder = copied("cut", 10);
    let path = folder.join("measurement.txt");
    let bytes = fs::read(&path).unwrap();
    let (whole, _) = read(&folder, PoseSource::Odometry).unwrap();
    for end in (bytes.len() - 60)..bytes.len() {
        fs::write(&path, &bytes[..end]).unwrap();
        let (records, refused) = read(&folder, PoseSource::Odometry).unwrap();
        // One row or two are hit: the cut begins within the last but one.
        assert!(whole.len() - records.len() <= 4, "{end}: {refused}");
        assert!(records == whole[..records.len()], "{end}: {refused}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_line_without_an_end_is_refused_in_bounded_memory() {
    let folder = copied("endless", 3);
    let path = folder.join("poses.txt");
    let mut text = fs::read(&path).unwrap();
    let line_end = text.iter().position(|byte| *byte == b'\n').unwrap();
    let long = vec![b'1'; 3 << 20];
    text.splice(line_end..line_end, long);
    fs::write(&path, text).unwrap();
    let (records, refused) = read(&folder, PoseSource::Odometry).unwrap();
    assert_eq!(refused.count, 1);
    assert!(refused.to_string().contains("longer than 65536 bytes"));
    assert_eq!(records.len(), 4);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_is_missing_is_named() {
    let message = |result: Result<(Vec<Record>, RefusedRows), DatasetError>| {
        result
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default()
    };
    let matched = message(read(&robond(), PoseSource::Matched));
    assert!(matched.ends_with("matched_poses.csv is missing: the recording has no matched poses"));
    let folder = copied("empty", 0);
    let empty = message(read(&folder, PoseSource::Odometry));
    assert!(
        empty.contains("poses.txt: no row of the format kcma"),
        "{empty}"
    );
    fs::remove_file(folder.join("poses.txt")).unwrap();
    let unknown = recognise(&folder).err().unwrap().to_string();
    for words in [
        "of no known format; looked for a folder with od.txt or poses.txt, and",
        "sonar.txt or measurement.txt (kcma)",
    ] {
        assert!(unknown.contains(words), "{unknown}");
    }
    let missing = message(read(&folder, PoseSource::Odometry));
    assert!(
        missing.contains("od.txt or poses.txt is missing"),
        "{missing}"
    );
    fs::remove_dir_all(&folder).unwrap();
    let nothing = recognise(&folder).err().unwrap().to_string();
    assert!(nothing.contains("No such file"), "{nothing}");
}

#[test]
fn a_rig_with_mounts_that_the_recording_cannot_have_is_refused_by_their_names() {
    let refused = |name: &str| {
        let rig = Rig::load(&root().join("../rigs").join(name)).unwrap();
        let other = read_with(&robond(), &rig, PoseSource::Odometry, &mut |_| {});
        other.unwrap_err().to_string()
    };
    assert_eq!(
        refused("amiro.toml"),
        "rig amiro: the recording needs 8 cones, in this order"
    );
    let pioneer = refused("pioneer2dx.toml");
    let words = "needs 8 cones, in this order, and has no data for sonar 8, sonar 9, sonar 10";
    assert!(pioneer.contains(words), "{pioneer}");
}

#[test]
fn mounts_that_were_asked_for_and_have_no_data_are_named_and_alone_they_give_no_map() {
    let rig = rig();
    let drive = DriveFile {
        path: &robond(),
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    for (asked, silent) in [("", "laser"), ("sonar", ""), ("laser", "laser")] {
        let mut mapper = Method::ISM.mapper(&Setup::new(&rig, 0.1));
        let options = DriveOptions {
            keyframes: Kcma.usual().keyframes,
            share: KeyframeShare::All,
            mounts: rig.mounts_named(&[asked.to_owned()]),
        };
        let run = pipeline::run(
            |take| pipeline::dataset_records(&Kcma, &drive, &options, &mut |_, _| {}, take),
            &mut mapper,
            &mut |_, _| {},
        )
        .unwrap();
        assert_eq!(run.mounts_without_data.join(","), silent, "{asked}");
        let nothing = NothingMapped::NoScan("laser".to_owned());
        let expected = if asked == "laser" {
            Err(nothing)
        } else {
            Ok(())
        };
        assert_eq!(run.check(&mapper.map()), expected, "{asked}");
    }
}

#[test]
fn one_sonar_of_a_scan_is_mapped_without_its_neighbours() {
    let (all, _) = mapped(&robond(), "ism", "sonar", PoseSource::Odometry);
    let echoes = (0..8).map(|index| {
        let name = format!("sonar {index}");
        let (figures, _) = mapped(&robond(), "ism", &name, PoseSource::Odometry);
        let returns = figures.echoes + figures.no_echoes + figures.invalid;
        assert_eq!(returns, all.keyframes, "{name}");
        figures.echoes
    });
    assert_eq!(echoes.sum::<u64>(), all.echoes);
}

#[test]
fn rows_of_a_file_behind_the_end_of_another_are_refused() {
    let folder = copied("short", 20);
    let path = folder.join("measurement.txt");
    let text = fs::read_to_string(&path).unwrap();
    let first: String = text.split_inclusive('\n').take(1).collect();
    fs::write(&path, first).unwrap();
    let (records, refused) = read(&folder, PoseSource::Odometry).unwrap();
    assert_eq!((records.len(), refused.count), (2, 19), "{refused}");
    let words = refused.to_string();
    assert!(words.contains("poses.txt line 2: "), "{words}");
    assert!(words.contains("measurement.txt has ended"), "{words}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn zero_bytes_at_the_end_of_a_file_are_reported() {
    for files in [&["poses.txt"][..], &["poses.txt", "measurement.txt"]] {
        let folder = copied("zeros", 10);
        for file in files {
            let path = folder.join(file);
            let mut bytes = fs::read(&path).unwrap();
            bytes.extend([0; 100]);
            fs::write(&path, bytes).unwrap();
        }
        let (records, refused) = read(&folder, PoseSource::Odometry).unwrap();
        assert_eq!(
            (records.len(), refused.count),
            (20, 1),
            "{files:?}: {refused}"
        );
        let words = refused.to_string();
        assert!(
            words.contains("poses.txt line 11: holds 100 zero bytes"),
            "{files:?}: {words}"
        );
        fs::remove_dir_all(folder).unwrap();
    }
}

#[test]
fn the_bytes_of_all_files_are_reported_up_to_their_sum() {
    let (rig, folder) = (rig(), robond());
    let drive = DriveFile {
        path: &folder,
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut reports = Vec::new();
    Kcma.read(
        &drive,
        &mut |bytes, length| reports.push((bytes, length)),
        &mut |_| {},
    )
    .unwrap();
    let length = |name: &str| fs::metadata(folder.join(name)).unwrap().len();
    let sum = length("poses.txt") + length("measurement.txt");
    assert_eq!(reports.last(), Some(&(sum, Some(sum))));
    assert!(
        reports.is_sorted() && reports.len() == 413,
        "{}",
        reports.len()
    );
}
