//! Simulated worlds that differ from the filter's model, through the public door.

use amiro_ipf::checksum::CRC;
use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Angle;
use amiro_ipf::link::TruthMessage;
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::{Config, Event, Input};
use sim_harness::log::{RecordingWriter, read_from};
use sim_harness::run;
use sim_harness::world::{
    Drive, OdometryModel, Options, Scenario, Simulation, Vector, simulate_with,
};

const MSOD: &str = include_str!("../../../scenarios/msod.toml");
const MSM_T: &str = include_str!("../../../scenarios/msm_t.toml");

/// Everything that may differ, at once.
const ALL: &str = "physics=patch noise=2 drift=0..10 reflectivity=0.7 dropout=0.05 xi=1 \
                   delta=-0.00025 odometry=wheel-errors";

fn msod() -> Scenario {
    Scenario::parse(MSOD).unwrap()
}

fn simulated(words: &str, seed: u64) -> Simulation {
    simulate_with(&msod(), seed, &words.parse().unwrap())
}

fn samples(simulation: &Simulation) -> impl Iterator<Item = [Sample; SENSORS]> {
    simulation.inputs.iter().filter_map(|input| match input {
        Input::Proximity { samples, .. } => Some(*samples),
        _ => None,
    })
}

/// Of every bit that the robot is told.
fn digest(simulation: &Simulation) -> u32 {
    let mut bytes = Vec::new();
    for input in &simulation.inputs {
        match *input {
            Input::Odometry { stamp_us, pose } => {
                bytes.extend(stamp_us.to_le_bytes());
                for value in [pose.position.x, pose.position.y, pose.heading.radians()] {
                    bytes.extend(value.to_bits().to_le_bytes());
                }
            }
            Input::Proximity { stamp_us, samples } => {
                bytes.extend(stamp_us.to_le_bytes());
                for sample in samples {
                    bytes.extend(match sample {
                        Sample::Counts(counts) => counts.to_le_bytes(),
                        Sample::Saturated => [0xff; 4],
                        Sample::Missing => [0xfe; 4],
                    });
                }
            }
            _ => {}
        }
    }
    CRC.checksum(&bytes)
}

#[test]
fn every_kind_of_world_is_the_same_on_every_machine() {
    // Pinned: a changed digest means that recordings can no longer be made again.
    for (words, expected) in [
        ("", 0xc783_687f),
        ("physics=patch", 0xad8d_e125),
        ("odometry=wheel-errors", 0xe371_3cf4),
        ("odometry=amiro", 0x2639_467b),
        (ALL, 0x1000_4a76),
        ("physics=patch gain-spread=0.12", 0x57b5_757e),
        ("odometry=wheel-errors:1:2:-2:1", 0xf7cd_59b1),
    ] {
        let simulation = simulated(words, 1);
        assert_eq!(simulation, simulated(words, 1), "{words}");
        assert_ne!(digest(&simulation), digest(&simulated(words, 2)), "{words}");
        let digest = digest(&simulation);
        assert_eq!(digest, expected, "{words}: {digest:#x}");
    }
}

#[test]
fn a_recording_can_be_made_again_from_its_truth_alone() {
    let new = "gain-spread=0.12 odometry=wheel-errors:1:2:-2:1";
    for (words, seed) in [("", 3), (ALL, 4), ("odometry=amiro", 5), (new, 6)] {
        let options: Options = words.parse().unwrap();
        let made = simulate_with(&msod(), seed, &options);
        let mut writer = RecordingWriter::new(Vec::new()).unwrap();
        writer.write_truth(&TruthMessage::Seed(seed)).unwrap();
        writer.write_scenario(&options.in_front_of(MSOD)).unwrap();
        for input in &made.inputs {
            writer.write_input(input).unwrap();
        }
        let bytes = writer.finish().unwrap();

        let recording = read_from(&bytes[..]).unwrap();
        let truth = recording.truth.unwrap();
        let text = truth.scenario.unwrap();
        let again = simulate_with(
            &Scenario::parse(&text).unwrap(),
            truth.seed.unwrap(),
            &Options::named_in(&text).unwrap(),
        );
        assert_eq!(again, made, "{words}");
        assert_eq!(again.inputs, recording.inputs, "{words}");
    }
}

#[test]
fn random_worlds_can_be_driven_near_their_blocks() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/random");
    let entries = std::fs::read_dir(folder).unwrap();
    let mut count = 0;
    for entry in entries {
        let path = entry.unwrap().path();
        // Reading checks that the hull enters no block.
        let scenario = Scenario::load(&path).unwrap();
        assert_eq!(path.file_stem().unwrap(), scenario.name.as_str());
        let name = &scenario.name;
        let (blocks, way_m) = (scenario.shapes.len(), 0.08 * scenario.duration_s());
        assert!((8..=10).contains(&blocks), "{name}: {blocks} blocks");
        assert!((0.9..1.2).contains(&way_m), "{name}: {way_m} m");
        let poses: Vec<_> = Drive::of(&scenario).samples().collect();
        for block in &scenario.shapes {
            assert!((block.outline_m() - 0.5).abs() < 1e-9, "{name}");
            let places = poses.iter().map(|(_, pose)| Vector::from(pose.position));
            let nearest_m = places.fold(f64::INFINITY, |nearest, place| {
                nearest.min(block.distance_m(place))
            });
            assert!((0.075..=0.14).contains(&nearest_m), "{name}: {nearest_m}");
        }
        count += 1;
    }
    assert_eq!(count, 10);
}

#[test]
fn lost_samples_leave_the_others_as_they_were() {
    let whole = simulated("", 1);
    let thinned = simulated("dropout=0.2", 1);
    let (mut missing, mut all) = (0_u32, 0_u32);
    for (whole, thinned) in samples(&whole).zip(samples(&thinned)) {
        for (whole, thinned) in whole.iter().zip(&thinned) {
            all += 1;
            missing += u32::from(*thinned == Sample::Missing);
            assert!(*thinned == Sample::Missing || thinned == whole);
        }
    }
    // 4 sigma of the share are 4 sqrt(0.2 x 0.8 / n).
    let (share, n) = (f64::from(missing) / f64::from(all), f64::from(all));
    assert!(
        (share - 0.2).abs() < 4.0 * (0.16 / n).sqrt(),
        "{share} of {n}"
    );
}

/// Mean counts of the whole drive.
fn mean_counts(words: &str, seed: u64) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for sample in samples(&simulated(words, seed)).flatten() {
        if let Sample::Counts(counts) = sample {
            sum += f64::from(counts);
            n += 1.0;
        }
    }
    sum / n
}

#[test]
fn drift_and_reflectivity_change_the_counts_by_their_amount() {
    // The same noise in both, so that only rounding differs: 7512 values, each within
    // 1/sqrt(6) of a count of their difference; 4 sigma of the mean are 0.02.
    for seed in 1..=3 {
        let nominal = mean_counts("", seed);
        let drifted = mean_counts("drift=10", seed) - nominal;
        assert!((drifted - 10.0).abs() < 0.02, "seed {seed}: {drifted}");
        let drifted = mean_counts("drift=0..10", seed) - nominal;
        assert!((drifted - 5.0).abs() < 0.02, "seed {seed}: {drifted}");
        // beta, -16.252, is no return. Half the noise's mean stays: 4 sigma of it are
        // 4 x 4.57 / 2 / sqrt(7512) = 0.105.
        let dim = mean_counts("reflectivity=0.5", seed) + 16.252;
        let error = dim - 0.5 * (nominal + 16.252);
        assert!(error.abs() < 0.125, "seed {seed}: {error}");
    }
}

#[test]
fn the_drive_past_a_block_returns_less_by_patches() {
    // The 200 mm block at 100 mm fills the lobe from no place of the drive.
    let peak = |words| {
        let simulation = simulated(words, 1);
        let counts = samples(&simulation)
            .flatten()
            .filter_map(|sample| match sample {
                Sample::Counts(counts) => Some(counts),
                Sample::Saturated | Sample::Missing => None,
            });
        counts.max().unwrap()
    };
    let (matched, patch) = (peak("noise=0"), peak("physics=patch noise=0"));
    assert!(patch < matched, "{patch}, {matched}");
    assert!(patch > matched / 2, "{patch}, {matched}");
}

#[test]
fn the_amiro_sends_a_pose_every_63_ms_on_the_grid_of_256_millionths() {
    let scenario = msod();
    let drive = Drive::of(&scenario);
    let mut newest_us = None;
    let mut frames = 0;
    let on_grid = |value: f32| {
        let steps = (f64::from(value) / 256e-6).round();
        ((steps * 256.0 * 1e-6) as f32).to_bits() == value.to_bits()
    };
    let simulation = simulated("odometry=amiro", 1);
    let mut told = None;
    for input in &simulation.inputs {
        match *input {
            Input::Odometry { stamp_us, pose } => {
                assert_eq!(stamp_us % 50_000, 0, "an update of the odometry");
                assert!(newest_us < Some(stamp_us), "{stamp_us} us is told once");
                newest_us = Some(stamp_us);
                frames += 1;
                told = Some(stamp_us);
                assert!(on_grid(pose.position.x), "{pose:?}");
                assert!(on_grid(pose.position.y), "{pose:?}");
                assert_eq!(pose.heading, Angle::default(), "{pose:?}");
                let short = drive.pose_at(stamp_us).position - pose.position;
                // Rounded down, to the float's 3e-8 m.
                assert!((-1e-7..256.1e-6).contains(&short.x), "{short:?}");
            }
            Input::Proximity { stamp_us, .. } => {
                if let Some(update_us) = told.take() {
                    // The frame came since the sample before, with the newest update.
                    let sent_us = stamp_us - stamp_us % 63_000;
                    assert!(stamp_us - sent_us < 8_000, "a frame at {stamp_us} us");
                    assert_eq!(update_us, sent_us - sent_us % 50_000);
                }
            }
            _ => {}
        }
    }
    // 7.5 s of frames, the first at the start.
    assert_eq!(frames, 7_500 / 63 + 1);
}

/// Largest distance of the poses of a run's steps from where the robot really was when
/// the readings were taken, metres.
fn worst_pose_m(scenario: &Scenario, odometry: OdometryModel) -> f32 {
    let options = Options {
        odometry,
        ..Options::default()
    };
    let config = Config {
        particles_per_sensor: 10,
        ..scenario.config(Profile::Paper)
    };
    let drive = Drive::of(scenario);
    let (mut worst, mut steps) = (0.0_f32, 0);
    let inputs = simulate_with(scenario, 1, &options).inputs;
    let outcome = run(&config, &inputs, |event| {
        if let Event::StepBegun(step) = event {
            let error = step.pose.position - drive.pose_at(step.stamp_us).position;
            worst = worst.max(error.norm());
            steps += 1;
        }
    });
    assert_eq!(outcome.unwrap().faults().count(), 0, "{odometry}");
    assert!(steps >= 59, "{odometry}: {steps} steps");
    worst
}

#[test]
fn poses_are_predicted_to_the_readings_within_a_millimetre() {
    // A pose is up to 256 um too low; at most 112 ms of 50 ms updates later the
    // prediction has added 2.2 times the difference of two such errors: 0.82 mm along
    // the way, 0.26 mm beside it.
    let scenario = msod();
    let predicted = worst_pose_m(&scenario, OdometryModel::Amiro);
    let stale = worst_pose_m(&scenario, OdometryModel::AmiroUndated);
    let story = format!("predicted within {predicted} m, undated within {stale} m");
    assert!(predicted < 0.001, "{story}");
    // A step begins when a new frame moves the robot on: then the pose is up to 49 ms
    // old, and 8 ms to the next sample; 57 ms at 80 mm/s are 4.6 mm, and the rounding.
    assert!((0.003..0.0049).contains(&stale), "{story}");
    assert!(worst_pose_m(&scenario, OdometryModel::Truth) < 1e-6);
}

#[test]
fn a_scenario_has_no_key_that_names_a_file() {
    assert!(Scenario::parse(MSM_T).is_ok());
    for key in ["out", "file", "path", "include", "map", "recording"] {
        let named = format!("{key} = \"/etc/passwd\"\n{MSM_T}");
        let error = Scenario::parse(&named).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}
