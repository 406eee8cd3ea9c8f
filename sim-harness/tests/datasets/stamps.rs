//! Stamps at both ends of their range: nothing panics, wraps or runs backward.
//!
//! Overflow checks are on in this build, so that an unguarded `+` ends a test.

use amiro_ipf::can;
use amiro_ipf::driver::Bus;
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample, WheelSpeeds};
use amiro_ipf::node::{Config, Input, Node, StepRule};
use amiro_ipf::senses::Senses;
use proptest::prelude::*;
use sim_harness::faults::Faults;
use sim_harness::log::{RecordingWriter, read_from};
use sim_harness::{run, with_ticks};

/// Stamps near a limit of the type, of a period or of a sign.
const EDGES: [u64; 12] = [
    0,
    1,
    8_000,
    125_000,
    1_000_001,
    i64::MAX as u64,
    1 << 63,
    u64::MAX - 1_000_001,
    u64::MAX - 125_000,
    u64::MAX - 8_000,
    u64::MAX - 1,
    u64::MAX,
];

fn stamp_us() -> impl Strategy<Value = u64> {
    prop_oneof![
        prop::sample::select(EDGES.to_vec()),
        (prop::sample::select(EDGES.to_vec()), 0..2_000_000_u64)
            .prop_map(|(edge, by)| edge.saturating_add(by)),
        (prop::sample::select(EDGES.to_vec()), 0..2_000_000_u64)
            .prop_map(|(edge, by)| edge.saturating_sub(by)),
    ]
}

fn input() -> impl Strategy<Value = Input> {
    (0..4, stamp_us(), -20_i16..20).prop_map(|(kind, stamp_us, millimetres)| {
        let x = f32::from(millimetres) * 1e-3;
        let speed = 10.0 * x;
        match kind {
            0 => Input::Tick { stamp_us },
            1 => Input::Odometry {
                stamp_us,
                pose: Pose::new(x, 0.0, x),
            },
            2 => Input::Wheels {
                stamp_us,
                speeds: WheelSpeeds {
                    left_m_per_s: speed,
                    right_m_per_s: speed,
                },
            },
            _ => Input::Proximity {
                stamp_us,
                samples: [Sample::Counts(90); SENSORS],
            },
        }
    })
}

fn stamp_of(input: &Input) -> u64 {
    match *input {
        Input::Tick { stamp_us }
        | Input::Odometry { stamp_us, .. }
        | Input::Wheels { stamp_us, .. }
        | Input::Proximity { stamp_us, .. } => stamp_us,
        _ => 0,
    }
}

/// Inputs in any order and in the order of their stamps: the first are refused early.
fn inputs() -> impl Strategy<Value = Vec<Input>> {
    (prop::collection::vec(input(), 1..40), any::<bool>()).prop_map(|(mut inputs, is_sorted)| {
        if is_sorted {
            inputs.sort_by_key(stamp_of);
        }
        inputs
    })
}

fn config(step_rule: StepRule) -> Config {
    Config {
        particles_per_sensor: 4,
        step_rule,
        ..Config::amiro(Profile::Plus)
    }
}

/// Readings at the given stamps.
fn readings(stamps_us: &[u64]) -> Vec<Input> {
    let samples = [Sample::Counts(90); SENSORS];
    stamps_us
        .iter()
        .map(|&stamp_us| Input::Proximity { stamp_us, samples })
        .collect()
}

fn ticks(inputs: &[Input]) -> Vec<u64> {
    let ticks = inputs
        .iter()
        .filter(|input| matches!(input, Input::Tick { .. }));
    ticks.map(stamp_of).collect()
}

#[test]
fn a_reading_at_the_last_stamp_there_is_gets_its_tick() {
    let last = [u64::MAX - 1_000, u64::MAX - 999, u64::MAX];
    let ticked = with_ticks(&readings(&last), 125_000);
    assert_eq!(ticks(&ticked), [u64::MAX - 1_000, u64::MAX]);
    for period_us in [0, 1, u64::MAX] {
        let ticked = with_ticks(&readings(&[0, u64::MAX]), period_us);
        assert_eq!(ticks(&ticked), [0, u64::MAX], "period {period_us}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_stamps_are_taken_or_refused_by_the_node(inputs in inputs()) {
        for step_rule in [
            StepRule::PerTick { own_clock: false },
            StepRule::PerDistance { step_m: 0.01 },
        ] {
            let mut set = ParticleSet::<32>::new();
            let mut node = Node::new(&mut set);
            node.handle(&Input::Configure(config(step_rule)), &mut |_| ()).unwrap();
            for input in &inputs {
                let _ = node.handle(input, &mut |_| ());
            }
        }
    }

    #[test]
    fn any_stamps_get_ticks_in_order(
        mut stamps in prop::collection::vec(stamp_us(), 1..40),
        period_us in stamp_us(),
    ) {
        stamps.sort_unstable();
        let ticks = ticks(&with_ticks(&readings(&stamps), period_us));
        prop_assert!(ticks.len() <= stamps.len());
        prop_assert!(ticks.is_sorted());
    }

    #[test]
    fn any_stamps_pass_through_faults_and_are_replayed(inputs in inputs()) {
        for text in ["can=delayed:10s, s3=stuck@1s..2s, s4=garbage", "can=intermittent:0.5, ring=off@86400s"] {
            let faults: Faults = text.parse().unwrap();
            let broken = faults.on_inputs(1, &inputs).unwrap();
            prop_assert!(broken.len() <= inputs.len());
            let rule = StepRule::PerTick { own_clock: false };
            run(&config(rule), &with_ticks(&broken, 125_000), |_| ()).unwrap();
        }
    }

    #[test]
    fn any_stamps_are_written_and_read(inputs in inputs()) {
        let mut writer = RecordingWriter::new(Vec::new()).unwrap();
        let rule = StepRule::PerTick { own_clock: false };
        writer.write_input(&Input::Configure(config(rule))).unwrap();
        for input in &inputs {
            writer.write_input(input).unwrap();
        }
        // Odometry at the edges may be taken for another unit and refused by name.
        if let Ok(recording) = read_from(&writer.finish().unwrap()[..]) {
            prop_assert!(recording.inputs.len() <= inputs.len());
        }
    }

    #[test]
    fn any_time_is_a_time_for_the_senses(
        mut times in prop::collection::vec(stamp_us(), 1..60),
        is_sorted in any::<bool>(),
    ) {
        if is_sorted {
            times.sort_unstable();
        }
        let mut senses = Senses::new();
        for (count, &now_us) in times.iter().enumerate() {
            let x = count as f32 * if count % 3 == 0 { 0.008 } else { 0.004 };
            senses.take_frame(now_us, &can::odometry(&Pose::new(x, 0.0, 0.0)));
            for bus in [Bus::I2c1, Bus::I2c2] {
                if senses.next(bus, now_us).is_some() {
                    senses.answer(bus, now_us, Ok(&[0; 32]));
                }
            }
            senses.poll(now_us);
            senses.frame_due(now_us);
            let _ = (senses.sensors(now_us), senses.take_offsets());
        }
    }
}
