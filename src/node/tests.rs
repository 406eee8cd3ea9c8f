use super::*;
use crate::filter::{ParticleSet, Profile};
use crate::geometry::Pose;
use crate::math;
use crate::model::{SENSORS, Sample, SensorMask};

fn config() -> Config {
    Config {
        particles_per_sensor: 20,
        ..Config::amiro(Profile::Plus)
    }
}

/// Feeds a node and lists the kinds of its events, a letter each.
fn fed(node: &mut Node<'_, 160>, inputs: &[Input]) -> String {
    let mut kinds = String::new();
    for input in inputs {
        let handled = node.handle(input, &mut |event| {
            kinds.push(match event {
                Event::Configured(_) => 'C',
                Event::StepBegun(_) => 'b',
                Event::Walls(_) => 'w',
                Event::Particles(_) => 'p',
                Event::StepDone(_) => 'd',
                _ => '?',
            });
        });
        if handled.is_err() {
            kinds.push('!');
        }
    }
    kinds
}

fn at(stamp_us: u64, x: f32, heading: f32) -> [Input; 2] {
    let pose = Pose::new(x, 0.0, heading);
    let samples = [Sample::Counts(78); SENSORS];
    [
        Input::Odometry { stamp_us, pose },
        Input::Proximity { stamp_us, samples },
    ]
}

fn steps(kinds: &str) -> usize {
    kinds.matches('d').count()
}

#[test]
fn first_reading_steps_and_then_every_ten_millimetres() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    assert_eq!(fed(&mut node, &[Input::Configure(config())]), "C");
    assert_eq!(fed(&mut node, &at(0, 0.0, 0.0)), "bd", "nobody lives yet");
    assert_eq!(fed(&mut node, &at(8_000, 0.009, 0.0)), "");
    let kinds = fed(&mut node, &at(16_000, 0.0101, 0.0));
    assert_eq!(kinds, "bpppppd", "160 outcomes in batches of 38");
    let way: Vec<Input> = (0..100)
        .flat_map(|row| at(24_000 + row * 8_000, 0.0101 + row as f32 * 1e-3, 0.0))
        .collect();
    assert_eq!(steps(&fed(&mut node, &way)), 9);
}

#[test]
fn walls_come_once_per_step_of_the_profile_wall_ahead_of_the_particles() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    let config = Config {
        parameters: Profile::Wall.parameters(),
        ..config()
    };
    fed(&mut node, &[Input::Configure(config)]);
    let mut kinds = String::new();
    for step in 0..3_u8 {
        let x = 0.0101 * f32::from(step);
        kinds += &fed(&mut node, &at(1_000_000 * u64::from(step), x, 0.0));
    }
    let letters: Vec<&str> = kinds.split_inclusive('d').collect();
    assert_eq!(letters.len(), 3, "{kinds}");
    for letters in letters {
        let particles = letters.trim_start_matches("bw").trim_end_matches('d');
        assert!(letters.starts_with("bw"), "{kinds}");
        assert!(particles.chars().all(|kind| kind == 'p'), "{kinds}");
    }
}

#[test]
fn standstill_and_turning_in_place_step_nothing() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(0, 0.0, 0.0));
    let still: Vec<Input> = (1..1250)
        .flat_map(|row| at(row * 8_000, 0.0, 0.0))
        .collect();
    assert_eq!(fed(&mut node, &still), "");
    let turning: Vec<Input> = (0..500)
        .flat_map(|row| at(10_000_000 + row * 8_000, 0.0, row as f32 * 0.01))
        .collect();
    assert_eq!(fed(&mut node, &turning), "");
}

#[test]
fn a_turn_in_place_is_applied_whole_at_the_next_step() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    let mut config = config();
    config.parameters.wheel_noise = 0.0;
    fed(&mut node, &[Input::Configure(config)]);
    fed(&mut node, &at(0, 0.0, 0.0));
    let before: Vec<_> = node.filter().live().map(|(place, _)| place).collect();
    fed(&mut node, &at(1_000_000, 0.0, 1.2));
    // A wheel's width further on: the robot now looks along 1.2 rad.
    let (sine, cosine) = math::sin_cos(1.2);
    let end = Pose::new(0.0101 * cosine, 0.0101 * sine, 1.2);
    let mut places = Vec::new();
    let [_, reading] = at(2_000_000, 0.0, 0.0);
    let pose = Input::Odometry {
        stamp_us: 2_000_000,
        pose: end,
    };
    for input in [pose, reading] {
        node.handle(&input, &mut |event| {
            if let Event::Particles(particles) = event {
                places.extend(particles.outcomes.iter().map(|event| event.position()));
            }
        })
        .unwrap();
    }
    assert_eq!(
        places.len(),
        before.len(),
        "all stay within the local radius"
    );
    for (old, new) in before.iter().zip(&places) {
        // 0.25 mm of the event's rounding each way, and a unit of storage.
        let error = (end.world_from_body(*new) - *old).norm();
        assert!(error < 0.000_38, "{old:?} went to {new:?}");
    }
}

#[test]
fn masked_sensors_are_consumed_as_missing() {
    let mut set = ParticleSet::<160>::new();
    let mut node = Node::new(&mut set);
    let config = Config {
        sensors: SensorMask::ALL.complement().with(1),
        ..config()
    };
    fed(&mut node, &[Input::Configure(config)]);
    for input in at(0, 0.0, 0.0) {
        node.handle(&input, &mut |event| {
            if let Event::StepBegun(step) = event {
                for (sensor, sample) in step.samples.iter().enumerate() {
                    assert_eq!(*sample != Sample::Missing, sensor == 1, "{sensor}");
                }
            }
        })
        .unwrap();
    }
    assert_eq!(node.status().without, 0b1111_1101);
}

#[test]
fn ticks_step_under_their_rule_alone() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    let tick = [Input::Tick { stamp_us: 5 }];
    assert_eq!(fed(&mut node, &tick), "!", "no reading yet");
    fed(&mut node, &at(0, 0.0, 0.0));
    assert_eq!(fed(&mut node, &tick), "");
    let step_rule = StepRule::PerTick { own_clock: false };
    fed(
        &mut node,
        &[Input::Configure(Config {
            step_rule,
            ..config()
        })],
    );
    assert_eq!(fed(&mut node, &at(0, 0.0, 0.0)), "");
    assert_eq!(fed(&mut node, &tick), "bd");
    assert!(fed(&mut node, &tick).ends_with('d'), "again, at standstill");
}

/// The same with another sample for each sensor.
fn with_samples(stamp_us: u64, x: f32, sample: Sample) -> [Input; 2] {
    let [odometry, _] = at(stamp_us, x, 0.0);
    let samples = [sample; SENSORS];
    [odometry, Input::Proximity { stamp_us, samples }]
}

#[test]
fn f18_without_any_sensor_nothing_is_done_and_the_fault_is_named() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(0, 0.0, 0.0));
    fed(&mut node, &at(8_000, 0.0101, 0.0));
    let (digest, steps) = (node.filter().digest(), node.status().steps);
    for (row, sample) in [(1, Sample::Missing), (2, Sample::Saturated)] {
        // Later than any sample that could still be used.
        let dead = with_samples(row * 100_000, 0.0101 + row as f32 * 0.011, sample);
        assert_eq!(fed(&mut node, &dead), "!");
        assert_eq!(node.status().last_fault, Some(InputError::NoSensor));
        assert_eq!(node.status().without, 0xff);
    }
    assert_eq!(node.filter().digest(), digest);
    assert_eq!(node.status().steps, steps);
    assert!(fed(&mut node, &at(300_000, 0.045, 0.0)).ends_with('d'));
}

#[test]
fn f20_silent_odometry_suspends_the_filter_and_a_second_clears_the_particles() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(0, 0.0, 0.0));
    fed(&mut node, &at(63_000, 0.005, 0.0));
    let samples = [Sample::Counts(78); SENSORS];
    let reading = |stamp_us| Input::Proximity { stamp_us, samples };
    let mut refused_since = None;
    for stamp_us in (71_000..1_000_000).step_by(8_000) {
        let kinds = fed(&mut node, &[reading(stamp_us)]);
        if kinds == "!" {
            refused_since.get_or_insert(stamp_us);
            assert_eq!(node.status().last_fault, Some(InputError::StalePose));
        } else {
            // The motion goes on as before for three periods, then no longer.
            assert_eq!(refused_since, None, "{stamp_us}: {kinds}");
        }
    }
    assert!(refused_since.is_some_and(|stamp_us| stamp_us <= 63_000 + 208_000));
    assert!(node.filter().live().next().is_some(), "kept for a second");
    let back = Pose::new(0.02, 0.0, 0.0);
    let odometry = Input::Odometry {
        stamp_us: 1_063_001,
        pose: back,
    };
    assert_eq!(fed(&mut node, &[odometry]), "?", "the odometry broke off");
    assert_eq!(node.filter().live().count(), 0);
    assert_eq!(fed(&mut node, &[reading(1_064_000)]), "bd");
    assert!(node.filter().live().next().is_some());
}

#[test]
fn f31_a_new_origin_moves_no_particle() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(0, 0.0, 0.0));
    let kinds: Vec<_> = (1..=4)
        .map(|row| fed(&mut node, &at(row * 63_000, 3.0, 0.0)))
        .collect();
    // Twice refused and predicted to stand still, then believed: a first step.
    assert_eq!(kinds, ["!", "!", "?bd", ""]);
    assert_eq!(node.status().last_fault, Some(InputError::Implausible));
}

#[test]
fn refused_inputs_change_only_their_counter() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    let [odometry, reading] = at(8_000, 0.0, 0.0);
    assert_eq!(fed(&mut node, &[reading]), "!");
    assert_eq!(node.status().last_fault, Some(InputError::NoPose));
    fed(&mut node, &[odometry, reading]);
    let [_, early] = at(7_999, 0.0, 0.0);
    assert_eq!(fed(&mut node, &[early]), "!");
    assert_eq!(node.status().last_fault, Some(InputError::StampBackward));
    let mut bad = config();
    bad.parameters.veto = 2.0;
    let many = Config {
        particles_per_sensor: 21,
        ..config()
    };
    assert_eq!(
        fed(&mut node, &[Input::Configure(bad), Input::Configure(many)]),
        "!!"
    );
    assert_eq!(node.status().last_fault, Some(InputError::TooManyParticles));
    assert_eq!((node.status().refused, node.status().steps), (4, 1));
}

/// Digests of the steps that a node makes of a configuration and these inputs.
fn digests(node: &mut Node<'_, 160>, inputs: impl IntoIterator<Item = Input>) -> Vec<u32> {
    let mut digests = Vec::new();
    for input in [Input::Configure(config())].into_iter().chain(inputs) {
        node.handle(&input, &mut |event| {
            if let Event::StepDone(done) = event {
                digests.push(done.digest);
            }
        })
        .unwrap();
    }
    digests
}

#[test]
fn configuring_again_gives_the_same_run_again() {
    let drive = || (0..200).flat_map(|row| at(row * 8_000, row as f32 * 1e-3, 0.0));
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    let first = digests(&mut node, drive());
    assert_eq!(first.len(), 20);
    assert_eq!(digests(&mut node, drive()), first);
}

/// Digests of a drive whose stamps begin so late and run so fast.
fn digests_at(start_us: u64, rate: f64) -> Vec<u32> {
    let mut set = ParticleSet::new();
    let drive = (0..400_u64).flat_map(|row| {
        let stamp_us = start_us + (row as f64 * 12_500.0 * rate) as u64;
        at(stamp_us, row as f32 * 1e-3, 0.0)
    });
    digests(&mut Node::new(&mut set), drive)
}

#[test]
fn f42_the_end_of_32_bit_milliseconds_and_microseconds_is_no_event() {
    let early = digests_at(0, 1.0);
    assert_eq!(early.len(), 40);
    for start_us in [
        (1_u64 << 32) - 2_000_000,
        ((1_u64 << 32) - 2_000) * 1_000,
        (1_u64 << 48) - 2_000_000,
    ] {
        assert_eq!(digests_at(start_us, 1.0), early, "{start_us}");
    }
}

#[test]
fn f44_a_clock_two_percent_off_changes_no_particle() {
    let exact = digests_at(1_000_000, 1.0);
    for rate in [0.98, 0.999_99, 1.000_01, 1.02] {
        assert_eq!(digests_at(1_000_000, rate), exact, "{rate}");
    }
}

#[test]
fn a_limit_holds_until_the_next_configuration() {
    let mut set = ParticleSet::new();
    let mut node = Node::new(&mut set);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(0, 0.0, 0.0));
    assert_eq!(node.filter().live().count(), 160);
    let limit = |particles_per_sensor| Input::Limit {
        particles_per_sensor,
    };
    assert_eq!(fed(&mut node, &[limit(5)]), "");
    assert_eq!(node.filter().live().count(), 40);
    fed(&mut node, &at(8_000, 0.0101, 0.0));
    assert_eq!(node.filter().live().count(), 40);
    assert_eq!(fed(&mut node, &[limit(20), limit(0)]), "!", "never more");
    assert_eq!(node.filter().live().count(), 40);
    fed(&mut node, &[Input::Configure(config())]);
    fed(&mut node, &at(16_000, 0.0, 0.0));
    assert_eq!(node.filter().live().count(), 160);
}

#[test]
fn a_node_cuts_its_first_configuration_to_its_capacity() {
    let mut set = ParticleSet::<80>::new();
    assert_eq!(Node::new(&mut set).config().particles(), 80);
}

#[test]
fn the_profile_wall_has_segments_beside_a_wall_and_their_state_is_in_the_digest() {
    let mut set = ParticleSet::<800>::new();
    let mut node = Node::new(&mut set);
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Wall)
    };
    let law = crate::model::TabulatedWallLaw::of(&config.photometry);
    let drive = |node: &mut Node<'_, 800>| {
        let mut digests = Vec::new();
        node.handle(&Input::Configure(config), &mut |_| {}).unwrap();
        for millimetre in 0..=200_u16 {
            let stamp_us = u64::from(millimetre) * 12_500;
            let x = f32::from(millimetre) * 1e-3;
            let pose = Pose::new(x, 0.0, 0.0);
            let samples = core::array::from_fn(|sensor| {
                let mount = config.ring.mount(sensor);
                let wall = [-0.3, 0.5]
                    .map(|end| mount.sensor_from_body(crate::geometry::Point::new(end - x, 0.11)));
                let counts = law.signal(&[wall]) + law.beta_counts();
                Sample::Counts(crate::math::round_to_i32(counts))
            });
            let mut emit = |event: &Event| {
                if let Event::StepDone(done) = event {
                    digests.push(done.digest);
                }
            };
            node.handle(&Input::Odometry { stamp_us, pose }, &mut emit)
                .unwrap();
            node.handle(&Input::Proximity { stamp_us, samples }, &mut emit)
                .unwrap();
        }
        digests
    };
    let first = drive(&mut node);
    let segments = node.filter().segments();
    assert_eq!(segments.len(), 1, "{segments:?}");
    for end in segments[0].ends() {
        assert!((end.y - 0.11).abs() < 2e-3, "{segments:?}");
    }
    assert_eq!(first.len(), 21);
    // Configured again it starts again, the tracker included.
    assert_eq!(first, drive(&mut node));
}
