//! Drives of the AMiRo as a dataset: the steps of its recordings, without a filter.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample, SensorMask};
use amiro_ipf::node::{Config, Input, Source};
use sim_harness::datasets::{Amiro, Dataset, DatasetError, DriveFile, PoseSource, recognise};
use sim_harness::drive::{Keyframes, NoSteps, Record};
use sim_harness::log::RecordingWriter;
use sim_harness::mapping::{Map, Mapper, Method, Setup};
use sim_harness::pipeline::{self, DriveOptions, DriveSummary, KeyframeShare};
use sim_harness::rig::Rig;
use sim_harness::world::{simulate, standard};
use tempfile::TempDir;

use crate::common;

/// Side of a cell, metres.
const CELL_M: f64 = 0.010;

/// The methods that need no filter and map ranges.
const RANGE_METHODS: [Method; 5] = [
    Method::ISM,
    Method::ISM_DECAY,
    Method::ISM_STANDARD,
    Method::ISM_TUNED,
    Method::ISM_STANDARD_OBJECT,
];

fn amiro_toml() -> Rig {
    Rig::load(&common::root().join("rigs/amiro.toml")).unwrap()
}

/// Writes a recording of the link.
fn write(path: &Path, config: &Config, inputs: &[Input]) {
    let mut writer = RecordingWriter::new(BufWriter::new(File::create(path).unwrap())).unwrap();
    writer.write_input(&Input::Configure(*config)).unwrap();
    for input in inputs {
        writer.write_input(input).unwrap();
    }
    writer.finish().unwrap();
}

fn options() -> DriveOptions {
    DriveOptions {
        keyframes: Amiro.usual().keyframes,
        share: KeyframeShare::All,
        mounts: vec![true; SENSORS],
    }
}

fn mapped_with(
    path: &Path,
    rig: &Rig,
    method: &Method,
    options: &DriveOptions,
) -> Result<(DriveSummary, Map), DatasetError> {
    let mut mapper = method.mapper(&Setup::new(rig, CELL_M));
    let drive = DriveFile {
        path,
        rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let dataset = recognise(path)?;
    assert_eq!(dataset.name(), "amiro");
    let run = pipeline::run(
        |take| pipeline::dataset_records(dataset, &drive, options, &mut |_, _| {}, take),
        &mut mapper,
        &mut |_, _| {},
    )?;
    Ok((run, mapper.map()))
}

fn mapped(path: &Path, rig: &Rig, method: &Method) -> (DriveSummary, Map) {
    mapped_with(path, rig, method, &options()).unwrap()
}

/// The map as a comparison makes it: of the steps, collected in memory.
fn compared(config: &Config, inputs: &[Input], method: &Method) -> (usize, Map) {
    let mut steps = Vec::new();
    let mut take = |record: &Record| steps.push(record.clone());
    pipeline::step_records(config, inputs, &mut take).unwrap();
    let mut mapper = method.mapper(&Setup::new(&Rig::from(config), CELL_M));
    steps.iter().for_each(|record| mapper.take(record));
    let poses = steps.iter().filter(|record| record.pose().is_some());
    (poses.count(), mapper.map())
}

fn assert_same(name: &str, found: &Map, expected: &Map) {
    let cells = |map: &Map| {
        map.iter()
            .map(|(cell, held)| (cell, *held))
            .collect::<Vec<_>>()
    };
    assert!(cells(expected).len() > 100, "{name}");
    assert!(cells(found) == cells(expected), "{name}");
}

struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

#[test]
fn maps_of_a_recorded_simulation_have_the_cells_of_a_comparison() {
    let folder = Folder::new("simulated");
    let scenario = standard("msm_l").unwrap().unwrap();
    for seed in [100, 101, 102] {
        let inputs = simulate(&scenario, seed).inputs;
        // Not the default configuration, and one of a board that read its sensors itself.
        let mut config = Config {
            seed,
            sensors: SensorMask::NONE.with(3).complement(),
            source: Source::Board,
            ..scenario.config(Profile::Paper)
        };
        config.photometry.x_max_m = 0.17;
        let path = folder.file("drive.ipf");
        write(&path, &config, &inputs);
        for method in RANGE_METHODS {
            let name = format!("{}, seed {seed}", method.name);
            let (steps, expected) = compared(&config, &inputs, &method);
            let (run, map) = mapped(&path, &Rig::from(&config), &method);
            assert_eq!(run.figures.keyframes, steps as u64, "{name}");
            assert_eq!(run.figures.poses, steps as u64, "{name}");
            assert!(run.notes.is_empty(), "{name}: {:?}", run.notes);
            assert_same(&name, &map, &expected);
        }
    }
}

#[test]
fn maps_of_a_real_drive_have_the_cells_of_a_comparison() {
    let Some(recordings) = common::recordings() else {
        return common::skip("no recordings");
    };
    let config = Config::default();
    for drive in ["Left", "Gang", "Right_Right"] {
        let path = recordings.join(format!("amiro/RingProximityAndOdometry_{drive}.txt"));
        let inputs = sim_harness::log::read(&path).unwrap().inputs;
        for method in [Method::ISM, Method::ISM_DECAY] {
            let name = format!("{drive}, {}", method.name);
            let (_, expected) = compared(&config, &inputs, &method);
            let (_, map) = mapped(&path, &Rig::from(&config), &method);
            assert_same(&name, &map, &expected);
            // The mounts of the file have five decimals.
            let (run, of_file) = mapped(&path, &amiro_toml(), &method);
            assert!(run.notes.is_empty(), "{name}: {:?}", run.notes);
            let known = |map: &Map| map.iter().count();
            assert!(
                known(&of_file).abs_diff(known(&expected)) * 100 < known(&expected),
                "{name}"
            );
        }
    }
}

/// A drive along x, a reading and a pose each 5 mm; between two resets of the odometry.
fn driven() -> Vec<Input> {
    let at = |row: u32, x: f32| {
        let stamp_us = 62_500 * u64::from(row);
        let samples = [Sample::Counts(300); SENSORS];
        let pose = Pose::new(x, 0.0, 0.0);
        [
            Input::Odometry { stamp_us, pose },
            Input::Proximity { stamp_us, samples },
        ]
    };
    let first = (0..100_u8).flat_map(|row| at(u32::from(row), 0.005 * f32::from(row)));
    // More than a second later, elsewhere.
    let second = (0..100_u8).flat_map(|row| at(200 + u32::from(row), 5.0 + 0.005 * f32::from(row)));
    first.chain(second).collect()
}

#[test]
fn every_step_is_mapped_unless_the_user_asks_otherwise() {
    let folder = Folder::new("keyframes");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    write(&path, &config, &driven());
    let rig = Rig::from(&config);
    let (run, _) = mapped(&path, &rig, &Method::ISM);
    assert!((90..=102).contains(&run.figures.poses), "{:?}", run.figures);
    assert_eq!(run.figures.keyframes, run.figures.poses);
    let sparse = DriveOptions {
        keyframes: Keyframes::new(0.0995, 1.0),
        ..options()
    };
    let (run, _) = mapped_with(&path, &rig, &Method::ISM, &sparse).unwrap();
    assert!(
        (9..=12).contains(&run.figures.keyframes),
        "{:?}",
        run.figures
    );
}

#[test]
fn a_reset_of_the_odometry_is_no_way_of_the_robot() {
    let folder = Folder::new("reset");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    write(&path, &config, &driven());
    let rig = Rig::from(&config);
    let mut resets = 0;
    let drive = DriveFile {
        path: &path,
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    Amiro
        .read(&drive, &mut |_, _| {}, &mut |record| {
            resets += usize::from(matches!(record, Record::OdometryReset { .. }));
        })
        .unwrap();
    assert_eq!(resets, 1);
    let (run, _) = mapped(&path, &rig, &Method::ISM);
    assert!(run.figures.path_m < 1.0, "{:?}", run.figures);
    let [jump] = run.jumps[..] else {
        panic!("{:?}", run.jumps);
    };
    assert!(run.path[jump - 1].0 < 1.0 && run.path[jump].0 > 4.0);
}

#[test]
fn one_sensor_of_the_ring_is_mapped_without_its_neighbours() {
    let folder = Folder::new("one");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    write(&path, &config, &driven());
    let rig = Rig::from(&config);
    let one = DriveOptions {
        mounts: rig.mounts_named(&["infrared 3".to_owned()]),
        ..options()
    };
    let (run, map) = mapped_with(&path, &rig, &Method::ISM, &one).unwrap();
    assert_eq!(run.figures.echoes, run.figures.poses);
    let (all, whole) = mapped(&path, &rig, &Method::ISM);
    assert_eq!(all.figures.echoes, 8 * run.figures.echoes);
    assert!(map.iter().count() < whole.iter().count());
}

#[test]
fn rigs_of_other_robots_are_refused_with_what_differs() {
    let folder = Folder::new("rigs");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    write(&path, &config, &driven());
    let refused = |rig: &Rig| {
        let result = mapped_with(&path, rig, &Method::ISM, &options());
        result.err().unwrap().to_string()
    };
    let kcma = Rig::load(&common::root().join("rigs/kcma.toml")).unwrap();
    assert_eq!(
        refused(&kcma),
        "rig kcma: the recording needs 8 infrared sensors, in this order"
    );
    let mut more = amiro_toml();
    let mut ninth = more.mounts[0].clone();
    ninth.name = "infrared 8".to_owned();
    more.mounts.push(ninth);
    assert!(refused(&more).ends_with("and has no data for infrared 8"));
    let mut moved = amiro_toml();
    moved.mounts[2].body_from_sensor.position.x += 0.012;
    let words = "rig amiro: infrared 2 is 12 mm and 0 degrees from where the recording has it";
    assert_eq!(refused(&moved), words);
    // Another law is told, not refused.
    let mut other = config;
    other.photometry.alpha_counts_m2 = 0.5;
    let (run, _) = mapped(&path, &Rig::from(&other), &Method::ISM);
    assert!(run.notes[0].contains("law"), "{:?}", run.notes);
}

#[test]
fn a_recording_without_steps_is_an_error_with_the_reason() {
    let folder = Folder::new("no-steps");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    let read = |inputs: &[Input]| {
        write(&path, &config, inputs);
        let result = mapped_with(&path, &Rig::from(&config), &Method::ISM, &options());
        match result {
            Err(DatasetError::NoSteps { reason, .. }) => reason,
            other => panic!("{other:?}"),
        }
    };
    let is_reading = |input: &Input| matches!(input, Input::Proximity { .. });
    let (readings, poses): (Vec<_>, Vec<_>) = driven().into_iter().partition(is_reading);
    assert_eq!(read(&readings), NoSteps::NoOdometry { readings: 200 });
    assert_eq!(read(&poses), NoSteps::NoReadings { poses: 200 });
}

#[test]
fn what_of_a_recording_was_left_out_is_counted_with_its_place() {
    let folder = Folder::new("refused");
    let path = folder.file("drive.txt");
    let columns: Vec<_> = (0..8).map(|sensor| format!("PRV {sensor}")).collect();
    let mut text = format!("{}\tX [ym]\tY [ym]\tTheta [yrad]\n", columns.join("\t"));
    for row in 0..50 {
        text += &format!("{}\t{}\t0\t0\n", ["300"; 8].join("\t"), 5000 * row);
        if row == 20 {
            text += "nonsense\n";
        }
    }
    text += "\0\0\0\0";
    fs::write(&path, text).unwrap();
    let (run, _) = mapped(&path, &amiro_toml(), &Method::ISM);
    assert_eq!(
        (run.used_rows, run.refused.count),
        (50, 2),
        "{}",
        run.refused
    );
    let words = run.refused.to_string();
    assert!(words.contains("drive.txt line 23: "), "{words}");
    assert!(
        words.contains("drive.txt line 53: holds a zero byte"),
        "{words}"
    );
}

#[test]
fn the_bytes_are_reported_over_both_passes() {
    let folder = Folder::new("bytes");
    let path = folder.file("drive.ipf");
    let config = Config::default();
    write(&path, &config, &driven());
    let length = fs::metadata(&path).unwrap().len();
    let rig = Rig::from(&config);
    let drive = DriveFile {
        path: &path,
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut reports = Vec::new();
    Amiro
        .read(
            &drive,
            &mut |bytes, all| reports.push((bytes, all)),
            &mut |_| {},
        )
        .unwrap();
    assert_eq!(reports.last(), Some(&(2 * length, Some(2 * length))));
    assert!(reports.is_sorted(), "{reports:?}");
    let matched = DriveFile {
        poses: PoseSource::Matched,
        calibration: None,
        ..drive
    };
    let error = Amiro.read(&matched, &mut |_, _| {}, &mut |_| {});
    assert!(matches!(error, Err(DatasetError::NoSuchPoses { .. })));
}
