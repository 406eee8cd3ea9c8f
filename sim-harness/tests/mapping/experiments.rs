//! Experiments of the papers on mapping, on their recordings and simulated.

use std::path::Path;

use sim_harness::datasets::{DriveFile, PoseSource, SharpIr};
use sim_harness::experiments::{
    ExperimentReport, Flight, FlightFigures, FlightForm, MaximumRange, RUNS, ServoScan,
    ServoScanFigures, ServoSweep, corridor, specular_room, sweeps, two_sensors,
};
use sim_harness::rig::Rig;

use crate::common::{recordings, report_skipped, root};

const SEED: u64 = 100;

/// The sweeps of a recording with more than 10 echoes.
fn recorded_sweeps(file: &Path) -> Vec<ServoSweep> {
    let rig = Rig::load(&root().join("rigs/sharp_ir.toml")).unwrap();
    let drive = DriveFile {
        path: file,
        rig: &rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let (mut all, rows) = sweeps(&SharpIr, &drive).unwrap();
    assert_eq!(rows.refused.count, 0, "{}", rows.refused);
    all.retain(|sweep| sweep.echoes() > 10);
    all
}

fn scanned(
    all: &[ServoSweep],
    particles: usize,
    passes: usize,
    maximum: MaximumRange,
) -> ServoScanFigures {
    let scan = ServoScan {
        particles,
        passes,
        maximum,
        limit_m: all.iter().filter_map(ServoSweep::limit_m).reduce(f64::max),
        seed: SEED,
    };
    all.iter().fold(ServoScanFigures::default(), |sum, sweep| {
        sum.plus(&scan.run(sweep).unwrap().figures)
    })
}

#[test]
fn a_recorded_servo_sweep_gives_the_published_figures() {
    let Some(folder) = recordings() else {
        report_skipped("the recorded sweeps are missing");
        return;
    };
    let all = recorded_sweeps(&folder.join("sharp_ir/kzhang_DIY-3D-Scanner/test2d.csv"));
    assert_eq!(all.len(), 1);
    // Published: 373 high, 99 % at an end, 98 % of the ends, 5 % left in the free sector. The
    // order of stages and the resampling are others here: a fifth in number, 3 % in shares.
    let found = scanned(&all, 10_000, 1, MaximumRange::Clears);
    assert!((300..=450).contains(&found.high), "{found:?}");
    assert!(found.near_share() > 0.96, "{found:?}");
    assert!(found.covered_share() > 0.95, "{found:?}");
    assert!(found.free_density() < 0.10, "{found:?}");
    assert!(found.outside_change < 1e-6, "{found:?}");
    // Published: 38, 97 %, 48 %.
    let few = scanned(&all, 1_000, 1, MaximumRange::Clears);
    assert!((28..=50).contains(&few.high), "{few:?}");
    assert!(few.near_share() > 0.90, "{few:?}");
    assert!((0.33..0.63).contains(&few.covered_share()), "{few:?}");
    // Published after three passes: 373, 98 %, 97 %, nothing.
    let thrice = scanned(&all, 10_000, 3, MaximumRange::Clears);
    assert!((300..=450).contains(&thrice.high), "{thrice:?}");
    assert!(thrice.near_share() > 0.95, "{thrice:?}");
    assert!(thrice.covered_share() > 0.94, "{thrice:?}");
    assert!(thrice.free_density() < 0.02, "{thrice:?}");
}

#[test]
fn the_printed_maximum_range_makes_a_ring_that_the_corrected_one_does_not() {
    let Some(folder) = recordings() else {
        report_skipped("the recorded sweeps are missing");
        return;
    };
    let all = recorded_sweeps(&folder.join("sharp_ir/jcuhnoio_3dscanner/data.txt"));
    assert_eq!(all.len(), 40);
    // Published per row with 1000 particles: 77 % at an end and 5 in the ring; as printed 73
    // in the ring. With 10 000 particles 71 %, 47, and 695.
    for (particles, ring, printed_ring) in [(1_000, 5.0, 73.0), (10_000, 47.0, 695.0)] {
        let corrected = scanned(&all, particles, 3, MaximumRange::Clears);
        let printed = scanned(&all, particles, 3, MaximumRange::Obstacle);
        let per_row = |count: usize| count as f64 / 40.0;
        assert!(
            (0.65..0.90).contains(&corrected.near_share()),
            "{corrected:?}"
        );
        assert!(printed.near_share() < 0.40, "{printed:?}");
        assert!(per_row(corrected.ring) < 2.0 * ring, "{corrected:?}");
        let share = per_row(printed.ring) / printed_ring;
        assert!((0.8..1.25).contains(&share), "{printed:?}");
    }
}

#[test]
fn the_beam_filter_finds_the_walls_around_drones_and_more_of_them_by_sharing() {
    let Some(folder) = recordings().map(|folder| folder.join("nano_swarm")) else {
        report_skipped("the recordings of nano_swarm are missing");
        return;
    };
    let rig = Rig::load(&root().join("rigs/nano_swarm.toml")).unwrap();
    let flown = |is_shared: bool, only_four: bool, form| {
        let runs = RUNS.into_iter().filter(|run| run.is_shared || !only_four);
        runs.fold(FlightFigures::default(), |sum, run| {
            let drive = DriveFile {
                path: &folder.join(run.folder),
                rig: &rig,
                poses: PoseSource::MotionCapture,
                calibration: None,
                profile: None,
            };
            let flight = Flight::read(&drive).unwrap();
            (SEED..SEED + 3).fold(sum, |sum, seed| {
                sum.plus(&flight.fly(form, is_shared, seed).unwrap())
            })
        })
    };
    let alone = flown(false, false, FlightForm::Moving);
    assert_eq!((alone.scans, alone.blind), (3 * 126, 0));
    assert!(
        alone.nearest_error_cm(0.5) <= 2.5,
        "{}",
        alone.nearest_error_cm(0.5)
    );
    assert!(
        alone.nearest_error_cm(0.9) <= 7.0,
        "{}",
        alone.nearest_error_cm(0.9)
    );
    assert!(alone.recall() >= 0.70, "{}", alone.recall());
    let paper = flown(false, false, FlightForm::Paper);
    assert!(
        paper.nearest_error_cm(0.9) > 20.0,
        "{}",
        paper.nearest_error_cm(0.9)
    );
    assert!(paper.recall() < 0.45, "{}", paper.recall());
    let four = flown(false, true, FlightForm::Moving);
    let shared = flown(true, true, FlightForm::Moving);
    let gain = shared.recall_of_all() - four.recall_of_all();
    assert!(gain >= 0.08, "{gain}");
    assert!(shared.precision() >= 0.88, "{}", shared.precision());
}

/// Panics with the whole report where a check does not hold.
fn assert_holds(report: &ExperimentReport) {
    assert!(!report.checks.is_empty());
    assert!(report.checks.iter().all(|check| check.holds), "{report:#?}");
}

#[test]
fn in_a_simulated_room_filtered_echoes_give_the_better_maps() {
    assert_holds(&specular_room(&(SEED..SEED + 2)).unwrap());
}

#[test]
fn in_a_simulated_corridor_the_box_mends_corners_and_closes_openings() {
    assert_holds(&corridor(&(SEED..SEED + 2)).unwrap());
}

#[test]
fn in_simulated_hallways_the_fusions_trade_free_space_for_walls() {
    assert_holds(&two_sensors(&(SEED..SEED + 2)).unwrap());
}
