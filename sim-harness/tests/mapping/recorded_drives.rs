//! Three drives of the real AMiRo along walls, through the filter to the map.
//!
//! The drives are not part of the project; without them these tests say so and pass.

use std::path::Path;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::{Photometry, SensorMask};
use amiro_ipf::node::Config;
use sim_harness::evaluation::{MappedPath, WallReport, WallRow, WallRowSettings};
use sim_harness::mapping::{Method, Occupancy};
use sim_harness::{RunRecord, log, run};

use crate::common;

/// The sensors that see the guide robot ahead.
const GUIDE: SensorMask = SensorMask::NONE.with(3).with(4);

fn drive_run(folder: &Path, drive: &str, profile: Profile) -> RunRecord {
    run_with(None, folder, drive, profile)
}

/// The record of a drive whose map has the footprint of a hull of the given radius, if any.
fn run_with(hull_m: Option<f64>, folder: &Path, drive: &str, profile: Profile) -> RunRecord {
    let file = folder.join(format!("amiro/RingProximityAndOdometry_{drive}.txt"));
    let recording = log::read(&file).unwrap();
    let mut config = Config {
        sensors: GUIDE.complement(),
        ..Config::amiro(profile)
    };
    config.photometry.x_max_m = 0.17;
    let mut record = RunRecord::new(&config, 0.010, hull_m);
    let outcome = run(&config, &recording.inputs, |event| record.take(event)).unwrap();
    assert_eq!(outcome.faults().count(), 0, "{drive}: {outcome:?}");
    record
}

/// What `plus` finds beside the first leg of each drive: the walls, and nothing else.
#[test]
fn walls_of_the_recorded_drives_are_found_where_they_stand() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    for (drive, left, right) in [
        ("Left", true, false),
        ("Gang", true, true),
        ("Right_Right", false, true),
    ] {
        let drive_run = drive_run(&folder, drive, Profile::Plus);
        let legs = WallReport::by_leg(&MappedPath::new(&drive_run.map(), &drive_run.path()));
        let leg = legs.first().unwrap();
        for (side, is_wall) in [(leg.left, left), (leg.right, right)] {
            assert_eq!(side.claimed, is_wall, "{drive}: {leg}");
            if is_wall {
                assert!(side.covered_m > 0.295, "{drive}: {leg}");
                assert!(side.share.unwrap() >= 0.85, "{drive}: {leg}");
            } else {
                assert_eq!(side.occupied, 0, "{drive}: {leg}");
            }
        }
    }
}

/// Walls beside the legs, at the range limit of the sensors; the gain is that of the
/// recorded series.
#[test]
fn a_map_of_straight_walls_keeps_to_their_lines_in_the_recorded_drives() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let settings = WallRowSettings {
        sensors: GUIDE.complement(),
        photometry: Photometry {
            x_max_m: 0.20,
            ..Photometry::VCNL4020
        },
        particles_per_sensor: 1,
        wall_alpha_counts_m2: 1.97,
    };
    for (drive, sides) in [
        ("Left", vec![true]),
        ("Gang", vec![true, false]),
        ("Right_Right", vec![false]),
    ] {
        let file = folder.join(format!("amiro/RingProximityAndOdometry_{drive}.txt"));
        let recording = log::read(&file).unwrap();
        let rows = WallRow::of(&recording.inputs, &Method::WALL_MAP, &settings).unwrap();
        for is_left in sides {
            let is_wanted = |row: &&WallRow| row.leg == 1 && row.is_left == is_left;
            let row = rows.iter().find(is_wanted).unwrap();
            assert!(row.side.claimed, "{drive}: {rows:?}");
        }
        for row in rows.iter().filter(|row| row.side.claimed) {
            assert!(row.side.rms_inliers_m.unwrap() <= 0.006, "{drive}: {row:?}");
        }
    }
}

#[test]
fn no_cell_is_occupied_where_the_hull_of_a_recorded_robot_has_been() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let under_the_hull = |drive_run: &RunRecord| {
        let map = drive_run.map();
        let under = map.cells_of(Occupancy::Occupied).filter(|cell| {
            let (x, y) = map.centre(*cell);
            let mut path = drive_run.path().into_iter();
            path.any(|(robot_x, robot_y)| (x - robot_x).hypot(y - robot_y) < 0.05 - 1e-6)
        });
        under.count()
    };
    for (drive, profile, before) in [
        ("Gang", Profile::Paper, 30),
        ("Gang", Profile::Plus, 17),
        ("Left", Profile::Paper, 12),
    ] {
        let counted = drive_run(&folder, drive, profile);
        assert_eq!(under_the_hull(&counted), before, "{drive}");
        let cleared = run_with(Some(0.05), &folder, drive, profile);
        assert_eq!(under_the_hull(&cleared), 0, "{drive}");
    }
}

#[test]
fn steps_of_the_recorded_drives_are_ten_millimetres_long() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    for drive in ["Left", "Gang", "Right_Right"] {
        let mean = drive_run(&folder, drive, Profile::Paper)
            .statistics()
            .mean_step_m
            .unwrap();
        // Rows are 5 to 10 mm apart; the remainder of each step is carried over.
        assert!((0.0095..0.0105).contains(&mean), "{drive}: {mean} m");
    }
}

#[test]
fn a_drive_gives_the_same_digest_twice_and_another_for_another_seed() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let digest = || {
        drive_run(&folder, "Left", Profile::Paper)
            .statistics()
            .last_digest
    };
    assert!(digest().is_some());
    assert_eq!(digest(), digest());
}
