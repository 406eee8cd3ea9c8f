//! The wall segments of simulated drives, from the messages alone, against the scenarios.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Event;
use sim_harness::RunRecord;
use sim_harness::drive::{KnownWall, WallFate};
use sim_harness::world::{Options, Physics, Scenario, simulate_with};

const MAZES: [&str; 2] = [
    include_str!("../../../scenarios/msm_l.toml"),
    include_str!("../../../scenarios/msm_t.toml"),
];

/// Largest deviation across of a segment that is compared, metres: 2 sigma are 10 mm.
const SURE_M: f64 = 0.005;

/// The record of a drive with the profile `wall`, without the events that are lost.
fn driven(scenario: &Scenario, seed: u64, mut is_lost: impl FnMut(&Event) -> bool) -> RunRecord {
    let config = scenario.config(Profile::Wall);
    let options = Options {
        physics: Physics::Patch,
        ..Options::default()
    };
    let inputs = simulate_with(scenario, seed, &options).inputs;
    let mut record = RunRecord::new(&config, scenario.cell_m, None);
    sim_harness::run(&config, &inputs, |event| {
        if !is_lost(event) {
            record.take(event);
        }
    })
    .unwrap();
    record
}

fn is_sure(wall: &&KnownWall) -> bool {
    let is_narrow = |sigma: &Option<f64>| sigma.is_some_and(|sigma| sigma <= SURE_M);
    wall.state.across_m.iter().all(is_narrow)
}

#[test]
fn sure_walls_of_the_messages_lie_within_ten_millimetres_of_the_scenario_s() {
    for scenario in MAZES.map(|text| Scenario::parse(text).unwrap()) {
        for seed in [100, 101, 102] {
            let record = driven(&scenario, seed, |_| false);
            let mut length_m = 0.0;
            for wall in record.known_walls().standing().filter(is_sure) {
                let [from, to] = wall.state.ends;
                let way = to - from;
                // All but the last 50 mm at each end, which may exceed the wall.
                let margin = (0.05 / way.norm()).min(0.5);
                for share in [margin, 0.3, 0.5, 0.7, 1.0 - margin] {
                    let place = from + way.scaled(share);
                    let distances = scenario.shapes.iter().map(|shape| shape.distance_m(place));
                    let nearest_m = distances.fold(f64::INFINITY, |m, d| m.min(d.abs()));
                    assert!(nearest_m < 0.010, "seed {seed}: {nearest_m} m, {wall:?}");
                }
                length_m += way.norm();
            }
            // Four sides of 0.4 m and more lie along each maze's path.
            assert!(
                length_m > 1.5,
                "{}, seed {seed}: {length_m} m",
                scenario.name
            );
        }
    }
}

#[test]
fn a_lost_walls_message_costs_only_itself() {
    let [text, _] = MAZES;
    let scenario = Scenario::parse(text).unwrap();
    let whole = driven(&scenario, 100, |_| false);
    // Every third message, but not the last one.
    let is_lost = |event: &Event| matches!(event, Event::Walls(walls) if walls.index % 3 == 1 && walls.index < 84);
    let torn = driven(&scenario, 100, is_lost);
    let seen = |record: &RunRecord| -> Vec<(u16, [(f64, f64); 2])> {
        let standing = record.known_walls().standing();
        let seen = standing.filter(|wall| wall.fate == WallFate::Tracked);
        seen.map(|wall| (wall.id, wall.state.ends.map(|end| (end.x, end.y))))
            .collect()
    };
    assert!(!seen(&whole).is_empty());
    assert_eq!(
        seen(&torn),
        seen(&whole),
        "the tracked ones are those of the last message"
    );
    let sure = |record: &RunRecord| record.known_walls().standing().filter(is_sure).count();
    assert_eq!(sure(&torn), sure(&whole));
}

#[test]
fn the_other_profiles_have_no_walls() {
    let [text, _] = MAZES;
    let scenario = Scenario::parse(text).unwrap();
    let config = scenario.config(Profile::Plus);
    let inputs = simulate_with(&scenario, 100, &Options::default()).inputs;
    let mut record = RunRecord::new(&config, scenario.cell_m, None);
    sim_harness::run(&config, &inputs, |event| {
        assert!(!matches!(event, Event::Walls(_)));
        record.take(event);
    })
    .unwrap();
    assert!(record.known_walls().is_empty());
}
