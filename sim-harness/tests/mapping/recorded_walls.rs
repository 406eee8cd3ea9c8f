//! The stepped series of the real AMiRo beside walls that are known.
//!
//! The recordings are not part of the project; without them this test says so and passes.

use std::path::Path;

use sim_harness::evaluation::recorded::{
    RecordedReport, RecordedSeries, RecordedSettings, SERIES_FILE, SeriesWalls, WallEnd,
};
use sim_harness::mapping::Method;

use crate::common;

/// The report by the folder's own description, or by the example.
fn judged(folder: &Path) -> RecordedReport {
    let own = folder.join(SERIES_FILE);
    let example = common::root().join("scenarios/recorded_series.toml");
    let description = if own.is_file() { own } else { example };
    let settings = RecordedSettings {
        methods: vec![
            Method::PAPER,
            Method::PLUS,
            Method::ISM_TUNED,
            Method::WALL_MAP,
        ],
        particles_per_sensor: 1000,
    };
    let series = RecordedSeries::load(folder, &description).unwrap();
    assert_eq!(series.files().len(), 7);
    series.judge(&settings, &mut |_, _| {}).unwrap()
}

#[test]
fn stepped_series_are_mapped_by_every_method_and_simulated_under_both_physics() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let report = judged(&folder.join("amiro"));
    assert_eq!(report.sources.len(), 6, "{report}");
    // By five methods: recorded, and simulated under either physics.
    assert_eq!(report.walls.len(), 6 * 3 * 5, "{report}");
    for walls in &report.walls {
        assert!(walls.stations >= 17, "{report}");
        // One step a station, whatever the distance between them.
        assert_eq!(walls.steps as usize, walls.stations, "{report}");
        assert!((0.0..=1.0).contains(&walls.recall_15), "{report}");
        assert!(
            (walls.recall_15..=1.0).contains(&walls.recall_20),
            "{report}"
        );
        assert!(walls.beside <= walls.occupied, "{report}");
        assert!(walls.false_cells <= walls.occupied, "{report}");
        assert_eq!(walls.mean_m.is_some(), walls.beside > 0, "{report}");
    }
    // The figures of docs/evaluation.md.
    assert!((report.alpha_counts_m2 - 1.863).abs() < 5e-4, "{report}");
    let recorded = || report.walls.iter().filter(|walls| walls.is_recorded());
    let tuned = recorded().filter(|walls| walls.method == Method::ISM_TUNED.name);
    let found: Vec<_> = tuned
        .map(|walls| (walls.recall_15, walls.false_cells))
        .collect();
    let expected = [
        (0.8, 47),
        (0.625, 43),
        (0.35, 6),
        (0.7375, 37),
        (0.8, 34),
        (0.275, 1),
    ];
    assert_eq!(found, expected, "{report}");
    let fitted: Vec<_> = recorded()
        .filter(|walls| walls.method == Method::WALL_MAP.name)
        .collect();
    let mean = |value: &dyn Fn(&&SeriesWalls) -> f64| {
        fitted.iter().map(value).sum::<f64>() / fitted.len() as f64
    };
    assert!(mean(&|walls| walls.recall_15) >= 0.97, "{report}");
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
    // All fourteen ends of the seven wall sides, within 8 mm RMS.
    let ends: Vec<&WallEnd> = fitted.iter().flat_map(|walls| &walls.ends).collect();
    assert_eq!(ends.len(), 14, "{report}");
    assert!(ends.iter().all(|end| end.mapped.is_some()), "{report}");
    assert!(WallEnd::rms_m(ends).unwrap() <= 0.008, "{report}");
    for walls in recorded() {
        let has_walls = walls.method == Method::WALL_MAP.name;
        assert_eq!(walls.end_error_m().is_some(), has_walls, "{report}");
    }
    let again = judged(&folder.join("amiro"));
    assert_eq!(report, again);
}
