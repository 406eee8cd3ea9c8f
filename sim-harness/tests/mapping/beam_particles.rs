//! The inverted particle filter for range beams, on recordings with exact walls.

use std::path::Path;

use sim_harness::datasets::{Dataset, DriveFile, NanoSwarm, PoseSource};
use sim_harness::drive::Record;
use sim_harness::evaluation::cell_truth::DriveSurvey;
use sim_harness::experiments::RUNS;
use sim_harness::lattice::Lattice;
use sim_harness::mapping::{Mapper, Method, Setup};
use sim_harness::rig::Rig;

use crate::common::{recordings, report_skipped, root};

const CELL_M: f64 = 0.05;

/// The records of a recording.
fn records(folder: &Path, rig: &str) -> (Rig, Vec<Record>) {
    let rig = Rig::load(&root().join("rigs").join(rig)).unwrap();
    let drive = DriveFile {
        path: folder,
        rig: &rig,
        poses: PoseSource::MotionCapture,
        calibration: None,
        profile: None,
    };
    let mut records = Vec::new();
    let mut take = |record: &Record| records.push(record.clone());
    NanoSwarm.read(&drive, &mut |_, _| {}, &mut take).unwrap();
    (rig, records)
}

#[test]
fn maps_of_the_drones_are_as_good_as_an_independent_implementation_found() {
    let Some(folder) = recordings() else {
        report_skipped("the recordings of nano_swarm are missing");
        return;
    };
    let folder = folder.join("nano_swarm");
    // The walls lie on multiples of 0.5 m, and pass through centres with it.
    let lattice = Lattice::new(CELL_M).moved_by_half_a_cell();
    let methods = [Method::KLEPPE, Method::KLEPPE_PAPER];
    let mut means = [[0.0; 4]; 2];
    for run in RUNS {
        let folder = folder.join(run.folder);
        let (rig, of_beams) = records(&folder, "nano_swarm.toml");
        // Scored is where beams or cones look.
        let (both, of_both) = records(&folder, "nano_swarm_both.toml");
        let world = NanoSwarm.true_world(&folder).unwrap().unwrap();
        let mut survey = DriveSurvey::new(&world, &both, lattice);
        of_both.iter().for_each(|record| survey.take(record));
        let truth = survey.finish();
        for (method, mean) in methods.iter().zip(&mut means) {
            let mut mapper = method.mapper(&Setup::new(&rig, lattice));
            of_beams.iter().for_each(|record| mapper.take(record));
            mapper.finish(&mut |_| {});
            let scores = truth.scores(&mapper.map());
            let scores = [scores.oe, scores.tpr, scores.fpr, scores.coverage];
            for (sum, score) in mean.iter_mut().zip(scores) {
                *sum += 0.25 * score.unwrap();
            }
        }
    }
    // The bounds of particle methods: 0.015 in error and FPR, 0.05 in TPR and coverage.
    let expected = [[0.078, 0.671, 0.059, 0.76], [0.081, 0.371, 0.039, 0.34]];
    for (mean, expected) in means.iter().zip(expected) {
        for ((found, expected), within) in mean.iter().zip(expected).zip([0.015, 0.05, 0.015, 0.05])
        {
            assert!((found - expected).abs() < within, "{means:.3?}");
        }
    }
}
