//! Whole drives past a block: simulated, filtered, mapped, scored.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;
use sim_harness::drive::Record;
use sim_harness::evaluation::{Scores, Truth};
use sim_harness::mapping::{CountingMapper, Mapper};
use sim_harness::pipeline;
use sim_harness::world::{Scenario, simulate};

/// Seeds 0 to 99 were for tuning.
const SEEDS: core::ops::RangeInclusive<u64> = 100..=109;

const MSOD: &str = include_str!("../../../scenarios/msod.toml");

/// The final map's scores of one drive; the seed drives world and filter alike.
fn scores(scenario: &Scenario, profile: Profile, seed: u64) -> Scores {
    let config = Config {
        seed,
        ..scenario.config(profile)
    };
    let mut mapper = CountingMapper::new(scenario.cell_m);
    let mut steps = Vec::new();
    let inputs = simulate(scenario, seed).inputs;
    let outcome = pipeline::filter_records(&config, &inputs, &mut |record| {
        mapper.take(record);
        if let Record::Pose {
            world_from_body, ..
        } = record
        {
            steps.push(*world_from_body);
        }
    })
    .unwrap();
    assert_eq!(outcome.faults().count(), 0, "seed {seed}: {outcome:?}");
    Scores::of(&mapper.map(), &Truth::of(scenario, &steps))
}

/// Means over the seeds, and the scores of each seed for the failure message.
struct Figures {
    oe: f64,
    tpr: f64,
    recall: f64,
    story: String,
}

fn figures(profile: Profile) -> Figures {
    let scenario = Scenario::parse(MSOD).unwrap();
    let all: Vec<_> = SEEDS
        .map(|seed| (seed, scores(&scenario, profile, seed)))
        .collect();
    let mean = |ratio: fn(&Scores) -> Option<f64>| {
        let sum: f64 = all.iter().map(|(_, scores)| ratio(scores).unwrap()).sum();
        sum / all.len() as f64
    };
    Figures {
        oe: mean(|scores| scores.oe),
        tpr: mean(|scores| scores.tpr),
        recall: mean(|scores| scores.surface_recall),
        story: all.iter().fold(String::new(), |story, (seed, scores)| {
            story + &format!("seed {seed}: {scores}\n")
        }),
    }
}

#[test]
fn the_paper_s_filter_maps_the_block_within_its_bounds() {
    let figures = figures(Profile::Paper);
    assert!(figures.oe <= 0.035, "OE {}\n{}", figures.oe, figures.story);
    let recall = figures.recall;
    assert!(recall >= 0.80, "recall {recall}\n{}", figures.story);
}

#[test]
fn the_plus_profile_maps_the_block_within_its_bounds() {
    let figures = figures(Profile::Plus);
    assert!(figures.oe <= 0.008, "OE {}\n{}", figures.oe, figures.story);
    assert!(
        figures.tpr >= 0.85,
        "TPR {}\n{}",
        figures.tpr,
        figures.story
    );
    let recall = figures.recall;
    assert!(recall >= 0.82, "recall {recall}\n{}", figures.story);
}
