//! Comparisons of whole drives, and maps that must not pass for good ones.

use amiro_ipf::filter::{FilterParameters, Profile};
use amiro_ipf::node::Config;
use sim_harness::evaluation::{Claims, MethodComparison, Metric, Over, Scores, Truth, json};
use sim_harness::geometry::Pose2;
use sim_harness::lattice::Cell;
use sim_harness::mapping::{Belief, CountingMapper, Map, Mapper, Method, Occupancy};
use sim_harness::pipeline;
use sim_harness::world::{Options, Scenario, simulate, standard};

fn scenario(name: &str) -> Scenario {
    standard(name).unwrap().unwrap()
}

fn recall_bound(name: &str) -> f64 {
    let claims = Claims::built_in().unwrap();
    let bound = claims.threshold(name, Method::PAPER, Metric::SurfaceRecall);
    bound.unwrap()
}

/// The final map of a drive with the given parameters, and the truth.
fn mapped(scenario: &Scenario, parameters: FilterParameters, seed: u64) -> (Map, Truth) {
    let config = Config {
        seed,
        parameters,
        particles_per_sensor: 1000,
        ..scenario.config(Profile::Paper)
    };
    let mut mapper = CountingMapper::new(scenario.cell_m);
    let mut poses: Vec<Pose2> = Vec::new();
    let inputs = simulate(scenario, seed).inputs;
    pipeline::filter_records(&config, &inputs, &mut |record| {
        mapper.take(record);
        poses.extend(record.pose());
    })
    .unwrap();
    (mapper.map(), Truth::of(scenario, &poses))
}

/// A map with every known cell converted.
fn with_classes(map: &Map, convert: impl Fn(Cell, Occupancy) -> (Cell, Occupancy)) -> Map {
    let mut converted = Map::unknown(map.lattice());
    for (cell, belief) in map.iter() {
        let (cell, class) = convert(cell, belief.occupancy());
        let p_occ = match class {
            Occupancy::Unknown => continue,
            Occupancy::Occupied => 1.0,
            Occupancy::Free => 0.0,
        };
        *converted.reach(cell).unwrap() = Belief::of_probability(p_occ);
    }
    converted
}

#[test]
fn a_map_that_is_free_everywhere_fails_the_recall_bound_whatever_its_error() {
    for name in ["ssso", "msso", "msod", "msm_l", "msm_t"] {
        let scenario = scenario(name);
        let (map, truth) = mapped(&scenario, FilterParameters::PAPER, 100);
        let all_free = with_classes(&map, |cell, _| (cell, Occupancy::Free));
        let scores = Scores::of(&all_free, &truth);
        assert!(scores.surface_recall.unwrap() < 1e-12, "{name}: {scores}");
        let good = Scores::of(&map, &truth).surface_recall.unwrap();
        assert!(good >= recall_bound(name), "{name}: {good}");
    }
    // The error by itself would let it pass: 1.2 % of the cells of a drive-by are wall.
    let scenario = scenario("msod");
    let (map, truth) = mapped(&scenario, FilterParameters::PAPER, 100);
    let all_free = with_classes(&map, |cell, _| (cell, Occupancy::Free));
    let oe = Scores::of(&all_free, &truth).oe.unwrap();
    let claims = Claims::built_in().unwrap();
    let bound = claims.threshold("msod", Method::PAPER, Metric::Oe).unwrap();
    assert!(oe < bound, "OE {oe}");
}

#[test]
fn a_filter_without_model_error_fails_the_recall_bound() {
    let scenario = scenario("ssso");
    let parameters = FilterParameters {
        model_error_m: 0.0,
        ..FilterParameters::PAPER
    };
    for seed in 100..103 {
        let (map, truth) = mapped(&scenario, parameters, seed);
        let scores = Scores::of(&map, &truth);
        let recall = scores.surface_recall.unwrap();
        assert!(recall < recall_bound("ssso"), "seed {seed}: {scores}");
    }
}

#[test]
fn a_map_that_is_shifted_by_three_cells_fails_the_recall_bound() {
    // Across the faces that are seen: towards the robot and away from it.
    for (name, row_shift, column_shift) in [("ssso", 0, 3), ("msod", 3, 0)] {
        let scenario = scenario(name);
        for sign in [-1, 1] {
            let (map, truth) = mapped(&scenario, FilterParameters::PLUS, 100);
            let shifted = with_classes(&map, |cell, class| {
                let cell = Cell {
                    row: cell.row + sign * row_shift,
                    column: cell.column + sign * column_shift,
                };
                (cell, class)
            });
            let scores = Scores::of(&shifted, &truth);
            let recall = scores.surface_recall.unwrap();
            assert!(recall < recall_bound(name), "{name}, {sign}: {scores}");
        }
    }
}

fn comparison(
    names: &[&str],
    methods: &[Method],
    particles: u16,
    threads: usize,
) -> MethodComparison {
    MethodComparison {
        scenarios: names.iter().map(|name| scenario(name)).collect(),
        methods: methods.to_vec(),
        seeds: 100..103,
        particles_per_sensor: particles,
        options: Options::default(),
        alpha_counts_m2: None,
        calibration: None,
        footprint: false,
        threads,
    }
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let methods = [
        Method::PAPER,
        Method::PLUS,
        Method::WALL,
        Method::ISM_TUNED,
        Method::SEGMENTS,
        Method::WALL_MAP,
        Method::ALL_FREE,
    ];
    let with = |threads| {
        let names = ["ssso", "msm_l"];
        let trials = comparison(&names, &methods, 20, threads).run().unwrap();
        json(&trials).unwrap()
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(1));
    // By scenario, seed and method.
    let first = "[\n{\"scenario\":\"ssso\",\"method\":\"paper\",\"seed\":100,\"oe\":0.";
    assert!(one.starts_with(first), "{one:.100}");
    assert_eq!(one.matches("\"scenario\"").count(), 2 * 3 * methods.len());
    // No opening in ssso.
    assert!(one.contains("\"opening_false_occupied\":null,\"opening_frontier\":null}"));
}

#[test]
fn the_filter_leaves_the_junction_open_and_the_inverse_sensor_model_does_not() {
    let methods = [Method::PAPER, Method::PLUS, Method::ISM_STANDARD];
    let trials = comparison(&["msm_t"], &methods, 300, 0).run().unwrap();
    for trial in &trials {
        let story = format!("{}, seed {}: {:?}", trial.method, trial.seed, trial.scores);
        assert_eq!(trial.scores.openings.len(), 2, "{story}");
        for opening in &trial.scores.openings {
            if trial.method == Method::ISM_STANDARD {
                assert!(opening.false_occupied >= 25, "{story}");
                assert_eq!(opening.frontier, 0, "{story}");
            } else {
                assert!(opening.false_occupied <= 10, "{story}");
                assert!(opening.frontier >= 8, "{story}");
            }
        }
    }
}

#[test]
fn readings_are_the_same_whatever_else_is_compared() {
    let alone = comparison(&["msso"], &[Method::ISM_TUNED], 7, 1)
        .run()
        .unwrap();
    let methods = [Method::PLUS, Method::ISM_TUNED];
    let beside = comparison(&["msso"], &methods, 30, 1).run().unwrap();
    let its: Vec<_> = beside
        .into_iter()
        .filter(|trial| trial.method == Method::ISM_TUNED)
        .collect();
    assert_eq!(json(&alone).unwrap(), json(&its).unwrap());
}

#[test]
fn a_threshold_is_judged_by_the_methods_that_it_names_and_no_other() {
    let claims = Claims::built_in().unwrap();
    let trials = comparison(&["msod"], &[Method::PLUS], 5, 1).run().unwrap();
    let thresholds = claims.thresholds.iter();
    let judged: Vec<_> = thresholds
        .filter_map(|claim| claim.judge(&trials))
        .collect();
    // Without the inverse sensor model its shares are not judged: OE, TPR, recall.
    assert_eq!(judged.len(), 3, "{judged:?}");
    assert!(
        judged
            .iter()
            .all(|verdict| verdict.claim.over == Over::Mean)
    );
}
