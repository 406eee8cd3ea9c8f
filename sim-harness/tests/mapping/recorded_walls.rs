//! The stepped series of the real AMiRo beside walls that are known.
//!
//! The recordings are not part of the project; without them this test says so and passes.

use sim_harness::evaluation::recorded::{SeriesWalls, recorded_walls};

use crate::common;

#[test]
fn stepped_series_are_mapped_by_every_method_and_simulated_under_both_physics() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let report = recorded_walls(&folder.join("amiro")).unwrap();
    assert_eq!(report.sources.len(), 6, "{report}");
    // By four methods: recorded, and simulated under either physics.
    assert_eq!(report.walls.len(), 6 * 3 * 4, "{report}");
    for walls in &report.walls {
        assert!(walls.stations >= 17, "{report}");
        // One step a station, whatever the distance between them.
        assert_eq!(walls.steps as usize, walls.stations, "{report}");
        assert!((0.0..=1.0).contains(&walls.recall), "{report}");
        assert!(walls.beside <= walls.occupied, "{report}");
        assert!(walls.false_cells <= walls.occupied, "{report}");
        assert_eq!(walls.mean_m.is_some(), walls.beside > 0, "{report}");
    }
    let fitted: Vec<_> = report
        .walls
        .iter()
        .filter(|walls| walls.method == "wall-map" && walls.readings == "recorded")
        .collect();
    let mean = |value: &dyn Fn(&&SeriesWalls) -> f64| {
        fitted.iter().map(value).sum::<f64>() / fitted.len() as f64
    };
    assert!(mean(&|walls| walls.recall) >= 0.97, "{report}");
    assert!(
        mean(&|walls| walls.mean_m.unwrap()).abs() <= 0.003,
        "{report}"
    );
    assert!(mean(&|walls| walls.rms_m.unwrap()) <= 0.006, "{report}");
    assert!(mean(&|walls| walls.false_cells as f64) <= 3.0, "{report}");
    assert_eq!(report.physics.len(), 3, "{report}");
    for physics in &report.physics {
        assert_eq!(
            physics.sensors.len(),
            6,
            "all but the guide's two: {report}"
        );
        // 3 x 19 and 3 x 17 stations.
        let rows = |rows: usize| rows == 108;
        assert!(
            physics.sensors.iter().all(|sensor| rows(sensor.rows)),
            "{report}"
        );
        assert!(physics.alpha_counts_m2 > 0.0, "{report}");
    }
    let again = recorded_walls(&folder.join("amiro")).unwrap();
    assert_eq!(report, again);
}
