//! A robot that stands: the filter stays off, or it finds walls in the noise.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::{Config, Input, StepRule};
use sim_harness::drive::Record;
use sim_harness::geometry::Pose2;
use sim_harness::mapping::{CountingMapper, Map, Mapper};
use sim_harness::world::{SAMPLE_PERIOD_US, Scenario, Vector, simulate};
use sim_harness::{TICK_PERIOD_US, pipeline, with_ticks};

const MSSO: &str = include_str!("../../../scenarios/msso.toml");

/// Ten seconds at 125 Hz.
const TEN_SECONDS: u64 = 1_250;
/// Ten minutes at 125 Hz.
const TEN_MINUTES: u64 = 75_000;

/// A drive with and without a rest half way.
struct Stop {
    /// Samples of the rest.
    samples: u64,
    before: Vec<Input>,
    rest: Vec<Input>,
    after: Vec<Input>,
}

impl Stop {
    /// Half way: 145 mm driven, 205 mm before the block. The sensors go on with noise
    /// of their own.
    fn half_way(scenario: &Scenario, seed: u64, samples: u64) -> Self {
        let simulation = simulate(scenario, seed);
        let half = simulation.poses.len() / 2;
        let (last_us, pose) = simulation.poses[half - 1];
        let mut standing = scenario.clone();
        standing.start = Vector::from(pose.position);
        standing.drive.clear();
        let rest = (1..=samples).flat_map(|sample| {
            let stamp_us = last_us + sample * SAMPLE_PERIOD_US;
            // A drive of no way has one sample; each seed gives its own noise.
            let simulation = simulate(&standing, 100_000 * seed + sample);
            let stamped = |input: &Input| at(stamp_us, *input);
            simulation.inputs.iter().map(stamped).collect::<Vec<_>>()
        });
        let (before, after) = simulation.inputs.split_at(2 * half);
        Self {
            samples,
            before: before.to_vec(),
            rest: rest.collect(),
            after: after.to_vec(),
        }
    }

    fn to_the_stop(&self) -> Vec<Input> {
        self.before.clone()
    }

    fn to_the_end_of_the_stop(&self) -> Vec<Input> {
        [self.before.as_slice(), &self.rest].concat()
    }

    fn without_the_stop(&self) -> Vec<Input> {
        [self.before.as_slice(), &self.after].concat()
    }

    fn whole(&self) -> Vec<Input> {
        let delay_us = self.samples * SAMPLE_PERIOD_US;
        let later = self.after.iter().map(|input| delayed(*input, delay_us));
        let mut inputs = self.to_the_end_of_the_stop();
        inputs.extend(later);
        inputs
    }
}

/// An input with another stamp.
fn at(stamp_us: u64, input: Input) -> Input {
    match input {
        Input::Odometry { pose, .. } => Input::Odometry { stamp_us, pose },
        Input::Proximity { samples, .. } => Input::Proximity { stamp_us, samples },
        other => other,
    }
}

/// An input after the stop.
fn delayed(input: Input, delay_us: u64) -> Input {
    match input {
        Input::Odometry { stamp_us, .. } | Input::Proximity { stamp_us, .. } => {
            at(stamp_us + delay_us, input)
        }
        other => other,
    }
}

/// The map of a run, and the poses of its steps.
fn mapped(config: &Config, inputs: &[Input]) -> (Map, Vec<Pose2>) {
    let mut mapper = CountingMapper::new(0.010);
    let mut poses = Vec::new();
    let outcome = pipeline::filter_records(config, inputs, &mut |record| {
        mapper.take(record);
        if let Record::Pose {
            world_from_body, ..
        } = record
        {
            poses.push(*world_from_body);
        }
    })
    .unwrap();
    assert_eq!(outcome.faults().count(), 0, "{outcome:?}");
    (mapper.map(), poses)
}

/// Cells of a map whose class differs in another one.
fn changed_cells(before: &Map, after: &Map) -> usize {
    let cells = after.iter();
    cells
        .filter(|(cell, belief)| before.occupancy(*cell) != belief.occupancy())
        .count()
}

fn scenario_and_config(profile: Profile, seed: u64) -> (Scenario, Config) {
    let scenario = Scenario::parse(MSSO).unwrap();
    let config = Config {
        seed,
        particles_per_sensor: 300,
        ..scenario.config(profile)
    };
    (scenario, config)
}

#[test]
fn f33_ten_minutes_at_rest_change_no_cell_with_a_step_per_distance() {
    for profile in [Profile::Paper, Profile::Plus] {
        // One seed: equality is exact, and ten minutes of noise are 75 000 samples.
        let seed = 100;
        let (scenario, config) = scenario_and_config(profile, seed);
        let stop = Stop::half_way(&scenario, seed, TEN_MINUTES);
        assert_eq!(stop.rest.len(), 150_000);
        let (before, steps) = mapped(&config, &stop.to_the_stop());
        let (after, steps_after) = mapped(&config, &stop.to_the_end_of_the_stop());
        assert_eq!(before, after, "{profile:?}");
        assert_eq!(steps.len(), steps_after.len(), "{profile:?}");
        // And what comes later is as if nobody had waited.
        let straight_on = mapped(&config, &stop.without_the_stop());
        let whole = mapped(&config, &stop.whole());
        assert_eq!(straight_on, whole, "{profile:?}");
    }
}

#[test]
fn ten_seconds_at_rest_change_the_map_with_a_step_per_tick() {
    for profile in [Profile::Paper, Profile::Plus] {
        for seed in 100..103 {
            let (scenario, config) = scenario_and_config(profile, seed);
            let stop = Stop::half_way(&scenario, seed, TEN_SECONDS);
            let config = Config {
                step_rule: StepRule::PerTick { own_clock: false },
                ..config
            };
            let with_ticks = |inputs: &[Input]| with_ticks(inputs, TICK_PERIOD_US);
            let (before, steps) = mapped(&config, &with_ticks(&stop.to_the_stop()));
            let (after, steps_after) = mapped(&config, &with_ticks(&stop.to_the_end_of_the_stop()));
            assert_eq!(
                steps_after.len() - steps.len(),
                80,
                "{profile:?}, seed {seed}"
            );
            let changed = changed_cells(&before, &after);
            assert!(changed > 0, "{profile:?}, seed {seed}");
        }
    }
}
