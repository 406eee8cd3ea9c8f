//! A whole robot, from a simulated world through its parts, buses and frames to a map.
//!
//! Names that begin with f01 to f31 are entries of the fault catalogue.

use amiro_ipf::board::can::TransmittedPose;
use amiro_ipf::board::sensor_state::{SensorFault, SensorState};
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{DeviceEndpoint, Encoder, Message};
use amiro_ipf::model::{SENSORS, Sample, SensorMask};
use amiro_ipf::node::{Config, Event, Input, InputError, Node, Particles, Source};
use sim_harness::device::boot_on_host;
use sim_harness::drive::FilterRecords;
use sim_harness::evaluation::{NodeRun, Scores, SensorFaultTrials, map};
use sim_harness::faults::{ActiveFaults, Component, Kind};
use sim_harness::mapping::{CountingMapper, Map, Mapper, Method};
use sim_harness::robot::{
    AcquisitionReport, OFFSETS, PartClocks, ReportContent, Robot, STARTS_DRIVING_US, SensedWorld,
    SensorClocks, drive,
};
use sim_harness::world::{Drive, Options, Physics, Scenario, standard};
use sim_harness::{log, run};

const CAPACITY: usize = 8_000;

fn scenario(name: &str) -> Scenario {
    standard(name).unwrap().unwrap()
}

/// 300 particles a sensor: the thresholds' fewest, at a third of the time.
fn config(scenario: &Scenario, profile: Profile, seed: u64) -> Config {
    Config {
        seed,
        particles_per_sensor: 300,
        ..scenario.config(profile)
    }
}

fn robot(scenario: &Scenario, seed: u64, faults: ActiveFaults) -> Robot {
    Robot::new(scenario, seed, &Options::default(), faults)
}

/// The middle of the drive, in its own time.
fn middle_us(scenario: &Scenario) -> u64 {
    Drive::of(scenario).end_us() / 2
}

fn mapped(scenario: &Scenario, profile: Profile, seed: u64, faults: ActiveFaults) -> NodeRun {
    let inputs = drive(robot(scenario, seed, faults)).inputs();
    map(scenario, &config(scenario, profile, seed), &inputs).unwrap()
}

/// The events as the link would carry them.
fn bytes(events: &[Event]) -> Vec<u8> {
    let mut encoder = Encoder::new(1);
    events
        .iter()
        .flat_map(|event| encoder.encode(event).to_vec())
        .collect()
}

fn cells(map: &Map) -> Vec<(i32, i32, u32)> {
    map.iter()
        .map(|(cell, belief)| (cell.row, cell.column, belief.p_occ().to_bits()))
        .collect()
}

/// A pose as the message leaves it: 256 um and 256 urad down, in double precision.
fn rounded(pose: &Pose) -> Pose {
    let steps = |number: f32| (f64::from(number) * 1e6 / 256.0).floor();
    let turn = f64::from(pose.heading.radians()).rem_euclid(core::f64::consts::TAU);
    let heading = (turn * 1e6 / 256.0).floor();
    let unit = |steps: f64| (steps * 256.0 / 1e6) as f32;
    Pose::new(
        unit(steps(pose.position.x)),
        unit(steps(pose.position.y)),
        unit(heading),
    )
}

/// What a node is to be told of a robot whose sensors all measure 6 ms into each round,
/// without any of the robot's parts: from the world's counts and the driven way.
///
/// The frames' stamps alone are the robot's; what they are worth is another test's.
fn handled_directly(scenario: &Scenario, seed: u64, stamps_us: &[u64]) -> Vec<Input> {
    let mut sensed_world = SensedWorld::of(scenario, seed, &Options::default());
    let drive = Drive::of(scenario);
    let end_us = STARTS_DRIVING_US + drive.end_us() + 100_000;
    let mut inputs = Vec::new();
    // Configured in round 0, nothing measured before round 1; trusted after ten readings.
    for round in 11.. {
        let begins_us = 8_000 * round;
        // Half a millisecond to the first byte, 88 bytes of 22.5 us to the last of a
        // bus's four sensors, and the next look after that.
        let stamp_us = begins_us + 2_500;
        if stamp_us >= end_us {
            break;
        }
        // Read in this round, measured in the one before.
        let measured_ns = (begins_us as i64 - 2_000 - STARTS_DRIVING_US as i64) * 1_000;
        let samples =
            core::array::from_fn(
                |sensor| match sensed_world.raw_counts(sensor, measured_ns) {
                    None => Sample::Missing,
                    Some(u16::MAX) => Sample::Saturated,
                    Some(raw) => Sample::Counts(i32::from(raw) - i32::from(OFFSETS[sensor])),
                },
            );
        inputs.push((stamp_us, 1, Input::Proximity { stamp_us, samples }));
    }
    for (frame, stamp_us) in stamps_us.iter().enumerate() {
        let sent_us = 40_000 + 63_000 * frame as u64;
        // Updates at 20 ms and every 50 ms after it.
        let updated_us = sent_us - (sent_us - 20_000) % 50_000;
        let pose = rounded(&drive.pose_at(updated_us.saturating_sub(STARTS_DRIVING_US)));
        let input = Input::Odometry {
            stamp_us: *stamp_us,
            pose,
        };
        inputs.push((sent_us, 0, input));
    }
    inputs.sort_by_key(|(at_us, order, _)| (*at_us, *order));
    inputs.into_iter().map(|(_, _, input)| input).collect()
}

#[test]
fn the_whole_way_through_parts_buses_and_frames_gives_the_map_of_the_counts_and_poses() {
    let clocks = PartClocks {
        sensors: SensorClocks::Together {
            into_round_ns: 6_000_000,
        },
        first_update_us: 20_000,
        first_frame_us: 40_000,
    };
    for (name, profile, seed) in [
        ("msm_l", Profile::Plus, 1),
        ("msod", Profile::Paper, 2),
        ("msso", Profile::Plus, 3),
    ] {
        let scenario = scenario(name);
        let options = Options::default();
        let robot = Robot::with_clocks(&scenario, seed, &options, ActiveFaults::none(), &clocks);
        let whole = drive(robot);
        let inputs = whole.inputs();
        let stamps_us: Vec<u64> = inputs
            .iter()
            .filter_map(|input| match input {
                Input::Odometry { stamp_us, .. } => Some(*stamp_us),
                _ => None,
            })
            .collect();
        let direct = handled_directly(&scenario, seed, &stamps_us);
        let differs = inputs.iter().zip(&direct).position(|(a, b)| a != b);
        if let Some(first) = differs {
            panic!(
                "{name}, input {first}: {:?} is not {:?}",
                inputs[first], direct[first]
            );
        }
        assert_eq!(inputs.len(), direct.len(), "{name}");
        let config = config(&scenario, profile, seed);
        let robots = map(&scenario, &config, &inputs).unwrap();
        let directs = map(&scenario, &config, &direct).unwrap();
        assert!(robots.outcome.steps > 25, "{name}: {:?}", robots.outcome);
        assert_eq!(robots.outcome, directs.outcome, "{name}");
        assert!(bytes(&robots.events) == bytes(&directs.events), "{name}");
        assert_eq!(cells(&robots.map), cells(&directs.map), "{name}");
    }
}

#[test]
fn equal_seeds_give_equal_reports_and_others_do_not() {
    let scenario = scenario("ssso");
    let of = |seed| drive(robot(&scenario, seed, ActiveFaults::none()));
    let first = of(1);
    assert_eq!(first, of(1));
    assert_ne!(first.reports, of(2).reports);
    // A health eight times a second, samples at 125 Hz less the time to trust, a frame
    // each 63 ms.
    let seconds = 4.125;
    let count = |is: fn(&ReportContent) -> bool| {
        let reports = first.reports.iter().filter(|report| is(&report.content));
        reports.count() as f64 / seconds
    };
    assert!((count(|text| matches!(text, ReportContent::Health(_))) - 8.0).abs() < 0.3);
    let samples = count(|text| matches!(text, ReportContent::Samples(_)));
    assert!((120.0..125.0).contains(&samples), "{samples}");
    let poses = count(|text| matches!(text, ReportContent::Pose { .. }));
    assert!((15.2..16.1).contains(&poses), "{poses}");
    let offsets = first
        .reports
        .iter()
        .find_map(|report| match report.content {
            ReportContent::Offsets(offsets) => Some(offsets),
            _ => None,
        });
    let offsets = offsets.unwrap();
    assert_eq!(offsets.offsets.counts, OFFSETS);
    assert!(offsets.is_kept);
}

#[test]
fn a_pose_is_stamped_with_its_time_to_some_milliseconds_once_the_robot_has_driven() {
    let scenario = scenario("msm_t");
    for seed in 1..=6 {
        let whole = drive(robot(&scenario, seed, ActiveFaults::none()));
        let errors_us = whole
            .reports
            .iter()
            .filter_map(|report| match report.content {
                ReportContent::Pose {
                    input: Input::Odometry { stamp_us, .. },
                    updated_us,
                } => Some((report.at_us, stamp_us.abs_diff(updated_us))),
                _ => None,
            });
        let errors_us: Vec<(u64, u64)> = errors_us.collect();
        // A frame that came with an update may be counted to the one before.
        let miscounted = errors_us.iter().filter(|(_, error_us)| *error_us > 25_000);
        let miscounted = miscounted.count();
        assert!(
            miscounted * 50 < errors_us.len(),
            "seed {seed}: {miscounted}"
        );
        // A second of driving, 13 ms of doubt.
        let is_driving = |at_us: u64| at_us > STARTS_DRIVING_US + 1_000_000;
        let driving = errors_us.iter().filter(|(at_us, _)| is_driving(*at_us));
        let (count, sum_us) = driving.fold((0, 0), |(count, sum_us), (_, error_us)| {
            (count + 1, sum_us + error_us)
        });
        assert!(
            count > 100 && sum_us < 3_000 * count,
            "seed {seed}: {sum_us} us in {count}"
        );
    }
}

/// Scores with a sensor's trouble from the middle on, and without.
fn with_and_without(name: &str, seed: u64, sensor: usize, kind: Kind) -> (Scores, Scores) {
    let scenario = scenario(name);
    let of = |faults| mapped(&scenario, Profile::Plus, seed, faults).scores(&scenario);
    let from_us = middle_us(&scenario);
    (
        of(ActiveFaults::none().from(from_us, Component::Sensor(sensor), kind)),
        of(ActiveFaults::none()),
    )
}

#[test]
fn f01_f09_f10_one_broken_sensor_costs_no_more_than_it_may() {
    // Reduced: the example `robot_studies` runs all scenarios and eight seeds,
    // with 1000 particles a sensor.
    let trials = SensorFaultTrials {
        scenarios: vec![scenario("msm_t")],
        physics: Physics::Matched,
        seeds: 100..102,
        breaks_at: 0.35,
        methods: vec![Method::PAPER, Method::PLUS],
        particles_per_sensor: 300,
    };
    let rows = trials.run().unwrap();
    let story: String = rows.iter().map(|row| format!("{row}\n")).collect();
    assert!(rows.iter().all(|row| row.holds()), "\n{story}");
    // Six with trouble, which made a difference.
    let judged = rows.iter().filter(|row| row.sensor_break.is_some());
    let touched = judged.filter(|row| row.worst.is_some_and(|(loss, _)| loss.abs() > 0.0));
    assert_eq!(touched.count(), 6, "\n{story}");
}

#[test]
fn f14_garbage_of_one_sensor_costs_less_than_three_points() {
    for (seed, sensor) in [(100, 1), (101, 4), (102, 6)] {
        let (garbage, sound) = with_and_without("msm_l", seed, sensor, Kind::Garbage);
        let loss = garbage.oe.unwrap() - sound.oe.unwrap();
        assert!(loss <= 0.03, "seed {seed}: {garbage}\n{sound}");
    }
}

#[test]
fn f12_ambient_saturation_turns_no_free_cells_into_walls() {
    // 50 000 counts are 12.5 klx; what of it the sensor takes for its own looks like a
    // wall at 58 mm.
    let lit = Kind::Lit {
        ambient: 50_000,
        added: 300,
    };
    for (seed, sensor) in [(100, 1), (101, 4), (102, 6)] {
        let (dazzled, sound) = with_and_without("msod", seed, sensor, lit);
        let more = dazzled.fpr.unwrap() - sound.fpr.unwrap();
        assert!(more <= 0.02, "seed {seed}: {dazzled}\n{sound}");
    }
}

/// A node that is told what a robot reports, and what it says when.
struct Watched<'a> {
    robot: Robot,
    node: Node<'a, CAPACITY>,
    records: FilterRecords,
    mapper: CountingMapper,
    steps: Vec<(u64, Pose)>,
    was_reset: Vec<u64>,
    particle_events: usize,
    faults: Vec<(u64, InputError)>,
}

impl<'a> Watched<'a> {
    fn new(
        scenario: &Scenario,
        config: &Config,
        robot: Robot,
        set: &'a mut ParticleSet<CAPACITY>,
    ) -> Self {
        let mut node = Node::new(set);
        node.handle(&Input::Configure(*config), &mut |_| ())
            .unwrap();
        Self {
            robot,
            node,
            records: FilterRecords::new(config),
            mapper: CountingMapper::new(scenario.cell_m),
            steps: Vec::new(),
            was_reset: Vec::new(),
            particle_events: 0,
            faults: Vec::new(),
        }
    }

    /// The next report and what came of it; `None` at the end.
    fn go_on(&mut self) -> Option<AcquisitionReport> {
        let report = self.robot.next()?;
        let Some(input) = report.content.input() else {
            return Some(report);
        };
        let at_us = report.at_us;
        let handled = self.node.handle(&input, &mut |event| {
            self.records
                .translate(event, &mut |record| self.mapper.take(record));
            match event {
                Event::StepBegun(step) => self.steps.push((at_us, step.pose)),
                Event::OdometryReset { .. } => self.was_reset.push(at_us),
                Event::Particles(Particles { outcomes, .. }) => {
                    self.particle_events += outcomes.len();
                }
                _ => {}
            }
        });
        if let Err(fault) = handled {
            self.faults.push((at_us, fault));
        }
        Some(report)
    }

    fn finish(&mut self) {
        while self.go_on().is_some() {}
    }

    /// Distances of the steps' poses from the truth, metres, as if the odometry were
    /// elsewhere by so much.
    fn off_m(&self, elsewhere_m: impl Fn(u64) -> [f32; 2]) -> Vec<(u64, f32)> {
        let off = |&(at_us, pose): &(u64, Pose)| {
            let mut truth = self.robot.true_pose_at(at_us).position;
            let [x, y] = elsewhere_m(at_us);
            truth.x += x;
            truth.y += y;
            (at_us, (pose.position - truth).norm())
        };
        self.steps.iter().map(off).collect()
    }
}

/// In the robot's time.
fn at_middle_us(scenario: &Scenario) -> u64 {
    STARTS_DRIVING_US + middle_us(scenario)
}

fn set() -> Box<ParticleSet<CAPACITY>> {
    Box::new(ParticleSet::new())
}

#[test]
fn f01_a_dead_sensor_is_named_within_one_step() {
    let scenario = scenario("msod");
    for sensor in 0..SENSORS {
        let seed = 100 + sensor as u64;
        let config = Config {
            particles_per_sensor: 20,
            ..config(&scenario, Profile::Plus, seed)
        };
        let component = Component::Sensor(sensor);
        let faults = ActiveFaults::none().from(middle_us(&scenario), component, Kind::Off);
        let dead_us = at_middle_us(&scenario);
        let mut particles = set();
        let robot = robot(&scenario, seed, faults);
        let mut watched = Watched::new(&scenario, &config, robot, &mut particles);
        let (mut seen, mut named_at_step) = (0, 0);
        while let Some(report) = watched.go_on() {
            let steps = watched.steps.len();
            if report.at_us < dead_us + 32_000 {
                named_at_step = steps;
            }
            let without = SensorMask(watched.node.status().without);
            // The first step may come before the last sensor has earned trust.
            if report.at_us < dead_us && steps > 1 {
                assert_eq!(without, SensorMask::NONE, "sensor {sensor}");
            }
            // Three rounds of 8 ms, and what is left of the one before.
            if steps > named_at_step && report.at_us > dead_us + 32_000 {
                named_at_step = steps;
                assert_eq!(without, SensorMask::NONE.with(sensor), "sensor {sensor}");
                let missing = watched.robot.sensors()[sensor] == SensorState::Missing;
                assert!(missing, "sensor {sensor}: {:?}", watched.robot.sensors());
                let others = watched.robot.sensors().into_iter().enumerate();
                let mut others = others.filter(|(other, _)| *other != sensor);
                assert!(others.all(|(_, state)| state.is_trusted()));
                seen += 1;
            }
        }
        assert!(seen > 20, "{seen} steps");
    }
}

#[test]
fn f18_without_any_sensor_there_are_no_outcomes() {
    for (name, sensors) in [("ssso", 1), ("msod", SENSORS)] {
        let scenario = scenario(name);
        let dead_us = at_middle_us(&scenario);
        let mut faults = ActiveFaults::none();
        for sensor in 0..sensors {
            faults = faults.from(middle_us(&scenario), Component::Sensor(sensor), Kind::Off);
        }
        let mut particles = set();
        let config = config(&scenario, Profile::Plus, 100);
        let robot = robot(&scenario, 100, faults);
        let mut watched = Watched::new(&scenario, &config, robot, &mut particles);
        let mut before = None;
        while let Some(report) = watched.go_on() {
            // Two periods of age, one of trying, one in hand.
            if report.at_us > dead_us + 32_000 {
                let now = || {
                    let steps = watched.node.status().steps;
                    (steps, watched.particle_events, cells(&watched.mapper.map()))
                };
                before.get_or_insert_with(now);
            }
        }
        let (steps, particle_events, map) = before.unwrap();
        let status = watched.node.status();
        assert!(steps > 10 && particle_events > 0, "{name}: {steps} steps");
        assert_eq!(status.steps, steps, "{name}");
        assert_eq!(watched.particle_events, particle_events, "{name}");
        assert_eq!(cells(&watched.mapper.map()), map, "{name}");
        assert_eq!(status.last_fault, Some(InputError::NoSensor), "{name}");
        assert_eq!(SensorMask(status.without), SensorMask::ALL, "{name}");
        let missing = watched
            .robot
            .sensors()
            .map(|state| state == SensorState::Missing);
        assert_eq!(missing, [true; SENSORS], "{name}");
    }
}

#[test]
fn f20_while_the_bus_is_silent_nothing_moves_and_then_it_goes_on() {
    for (name, silent_us, breaks_off) in [
        ("msod", 500_000, 0),
        ("msm_l", 500_000, 0),
        ("msod", 3_000_000, 1),
        ("msm_l", 3_000_000, 1),
    ] {
        let scenario = scenario(name);
        let from_us = middle_us(&scenario);
        let silence = from_us..from_us + silent_us;
        let faults = ActiveFaults::none().within(silence, Component::Can, Kind::Off);
        let config = config(&scenario, Profile::Plus, 100);
        let mut particles = set();
        let robot = robot(&scenario, 100, faults);
        let mut watched = Watched::new(&scenario, &config, robot, &mut particles);
        watched.finish();
        let from_us = from_us + STARTS_DRIVING_US;
        let is_silent = |at_us: &u64| (from_us + 375_000..from_us + silent_us).contains(at_us);
        let steps = watched.steps.iter();
        let silent = steps.filter(|(at_us, _)| is_silent(at_us)).count();
        assert_eq!(silent, 0, "{name}, {silent_us} us");
        assert_eq!(
            watched.was_reset.len(),
            breaks_off,
            "{name}, {silent_us} us"
        );
        let after = watched.steps.iter();
        let after = after.filter(|(at_us, _)| *at_us > from_us + silent_us);
        assert!(after.count() > 3, "{name}, {silent_us} us");
        // At 80 mm/s 200 ms of prediction are 16 mm, and 5 mm are the odometry's own.
        for (at_us, off_m) in watched.off_m(|_| [0.0; 2]) {
            assert!(
                off_m < 0.021,
                "{name}, {silent_us} us: {off_m} m at {at_us}"
            );
        }
    }
}

#[test]
fn f21_a_bus_that_is_off_for_120_ms_costs_nothing() {
    let scenario = scenario("msod");
    for seed in 100..102 {
        let from_us = middle_us(&scenario);
        let off =
            ActiveFaults::none().within(from_us..from_us + 120_000, Component::Can, Kind::Off);
        let off = mapped(&scenario, Profile::Plus, seed, off);
        let sound = mapped(&scenario, Profile::Plus, seed, ActiveFaults::none());
        assert!(off.outcome.steps.abs_diff(sound.outcome.steps) <= 1);
        // Two lost frames of 63 ms: the last one's pose is too old for 14 ms.
        let stale = off.outcome.refusals.len() - sound.outcome.refusals.len();
        assert!(stale <= 3, "seed {seed}: {:?}", off.outcome);
        let (off, sound) = (off.scores(&scenario), sound.scores(&scenario));
        let loss = off.oe.unwrap() - sound.oe.unwrap();
        assert!(loss <= 0.005, "seed {seed}: {off}\n{sound}");
    }
}

#[test]
fn f22_without_a_bus_from_the_start_there_is_no_step_and_the_sensors_are_well() {
    let scenario = scenario("msod");
    let faults = ActiveFaults::none().from(0, Component::Can, Kind::Off);
    let config = config(&scenario, Profile::Plus, 100);
    let mut particles = set();
    let robot = robot(&scenario, 100, faults);
    let mut watched = Watched::new(&scenario, &config, robot, &mut particles);
    watched.finish();
    assert_eq!(watched.node.status().steps, 0);
    assert_eq!(watched.node.status().last_fault, Some(InputError::NoPose));
    assert!(
        watched
            .faults
            .iter()
            .all(|(_, fault)| *fault == InputError::NoPose)
    );
    // A reading each 8 ms.
    assert!(watched.faults.len() > 900, "{}", watched.faults.len());
    assert!(
        watched
            .robot
            .sensors()
            .iter()
            .all(|state| state.is_trusted())
    );
    assert_eq!(watched.robot.health().can.taken, 0);
}

#[test]
fn f31_a_jump_in_the_frames_smears_nothing_and_what_insists_is_a_new_origin() {
    let scenario = scenario("msod");
    let from_us = middle_us(&scenario);
    let by_m = [0.5, 0.0];
    // One frame, two frames, all frames from there on.
    for (length_us, breaks_off) in [(63_000, 0), (126_000, 0), (u64::MAX / 4, 1)] {
        let when_us = from_us..from_us + length_us;
        let faults = ActiveFaults::none().within(when_us, Component::Can, Kind::Wrong(500));
        let config = config(&scenario, Profile::Plus, 100);
        let mut particles = set();
        let robot = robot(&scenario, 100, faults);
        let mut watched = Watched::new(&scenario, &config, robot, &mut particles);
        watched.finish();
        assert_eq!(watched.was_reset.len(), breaks_off, "{length_us} us");
        let new_origin_us = watched.was_reset.first().copied().unwrap_or(u64::MAX);
        let off = watched.off_m(|at_us| {
            if at_us < new_origin_us {
                [0.0; 2]
            } else {
                by_m
            }
        });
        // A cell, and a step of travel.
        for (at_us, off_m) in &off {
            assert!(*off_m <= 0.020, "{length_us} us: {off_m} m at {at_us}");
        }
        let after = off.iter().filter(|(at_us, _)| *at_us > from_us + 700_000);
        assert!(after.count() > 20, "{length_us} us");
    }
}

#[test]
fn f10_f14_stuck_and_mad_sensors_are_named_in_their_time() {
    let scenario = scenario("msod");
    type Named = fn(SensorState) -> bool;
    let cases: [(Kind, u64, Named); 2] = [
        (Kind::Stuck, 1_200_000, |state| state == SensorState::Stale),
        (Kind::Garbage, 2_000_000, |state| {
            state == SensorState::Faulty(SensorFault::Garbage)
        }),
    ];
    for (kind, within_us, is_named) in cases {
        let faults = ActiveFaults::none().from(middle_us(&scenario), Component::Sensor(4), kind);
        let mut robot = robot(&scenario, 100, faults);
        let broken_us = at_middle_us(&scenario);
        let mut named_us = None;
        while let Some(report) = robot.next() {
            if is_named(robot.sensors()[4]) {
                named_us.get_or_insert(report.at_us);
            }
        }
        let named_us = named_us.unwrap();
        let took_us = named_us.saturating_sub(broken_us);
        assert!(took_us > 0 && took_us < within_us, "{kind:?}: {took_us}");
    }
}

#[test]
fn what_a_robot_recorded_of_its_own_drive_replays_to_the_same_steps() {
    let scenario = scenario("msm_l");
    let config = Config {
        source: Source::Board,
        particles_per_sensor: 100,
        ..scenario.config(Profile::Plus)
    };
    let mut particles = set();
    let mut endpoint =
        DeviceEndpoint::new(Node::new(&mut particles), boot_on_host(CAPACITY as u32), 7);
    let mut line = Vec::new();
    let mut send = |frame: &[u8], _| line.extend_from_slice(frame);
    endpoint.introduce(&mut send);
    endpoint.inject(&Input::Configure(config), &mut send);
    for report in robot(&scenario, 100, ActiveFaults::none()) {
        match report.content {
            ReportContent::Health(health) => endpoint.publish(&Message::Health(health), &mut send),
            ReportContent::Offsets(offsets) => {
                endpoint.publish(&Message::Offsets(offsets), &mut send)
            }
            text => endpoint.inject(&text.input().unwrap(), &mut send),
        }
    }
    let recording = log::read_from(line.as_slice()).unwrap();
    assert_eq!(recording.config, Some(config), "{:?}", recording.refusals);
    fn text<'e>(events: impl Iterator<Item = &'e Event>) -> Vec<Event> {
        let of_steps = |event: &&Event| {
            matches!(
                event,
                Event::StepBegun(_) | Event::Particles(_) | Event::StepDone(_)
            )
        };
        events.filter(of_steps).cloned().collect()
    }
    let mut replayed = Vec::new();
    run(&config, &recording.inputs, |event| {
        replayed.push(event.clone())
    })
    .unwrap();
    let (live, replayed) = (text(recording.events()), text(replayed.iter()));
    assert!(live.len() > 200, "{}", live.len());
    assert!(live == replayed, "{} and {}", live.len(), replayed.len());
}

#[test]
fn a_frame_s_pose_is_the_nearest_below_it() {
    // Guards this file's own rounding, which the direct way rests on.
    for pose in [Pose::new(-0.4, 0.123, -1.0), Pose::new(1.0, -1.0, 3.0)] {
        let sent = TransmittedPose::of(&pose).pose();
        assert_eq!(rounded(&pose), sent);
    }
}
