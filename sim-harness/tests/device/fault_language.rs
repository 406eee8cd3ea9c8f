//! The words for what is to break: that they are read as written, and that each does what
//! it says on every part that it makes sense for.
//!
//! Names that begin with f01 to f23 are entries of the fault catalogue.

use amiro_ipf::board::health::{BusState, Health};
use amiro_ipf::board::sensor_state::{SensorFault, SensorState};
use amiro_ipf::filter::Profile;
use amiro_ipf::link::{Encoder, TruthMessage};
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::{Config, Event, Input, InputError};
use proptest::prelude::*;
use sim_harness::bus::RobotBuses;
use sim_harness::device::Comparison;
use sim_harness::evaluation::{NodeRun, map};
use sim_harness::faults::Faults;
use sim_harness::log::{Reason, RecordingWriter, read_from};
use sim_harness::robot::{
    ReportContent, Robot, RobotDrive, STARTS_DRIVING_US, SimulatedDrive, drive,
};
use sim_harness::run;
use sim_harness::world::{Options, Scenario, simulate_with, standard};

const MSOD: &str = include_str!("../../../scenarios/msod.toml");
const SEED: u64 = 100;
/// Sensors 0, 1, 2 and 7 are on bus 1.
const BUS_OF: [usize; SENSORS] = [1, 1, 1, 2, 2, 2, 2, 1];

fn msod() -> Scenario {
    standard("msod").unwrap().unwrap()
}

fn faults(text: &str) -> Faults {
    text.parse().unwrap()
}

/// A whole drive with what a text says, without noise if so asked.
fn driven_with(text: &str, options: &Options) -> RobotDrive {
    let broken = faults(text).active(7);
    drive(Robot::new(&msod(), SEED, options, broken))
}

fn driven(text: &str) -> RobotDrive {
    driven_with(text, &Options::default())
}

/// Times of the drive in seconds, and the samples that were then given.
fn samples(whole: &RobotDrive) -> Vec<(f64, [Sample; SENSORS])> {
    let samples = whole
        .reports
        .iter()
        .filter_map(|report| match report.content {
            ReportContent::Samples(Input::Proximity { samples, .. }) => {
                Some((drive_s(report.at_us), samples))
            }
            _ => None,
        });
    samples.collect()
}

fn healths(whole: &RobotDrive) -> Vec<(f64, Health)> {
    let healths = whole.healths.iter();
    healths
        .map(|(at_us, health)| (drive_s(*at_us), *health))
        .collect()
}

fn drive_s(at_us: u64) -> f64 {
    (at_us as f64 - STARTS_DRIVING_US as f64) * 1e-6
}

/// States of a sensor in the reports of health between two times of the drive.
fn states(whole: &RobotDrive, sensor: usize, from_s: f64, to_s: f64) -> Vec<SensorState> {
    let inside = healths(whole).into_iter();
    inside
        .filter(|(at_s, _)| (from_s..to_s).contains(at_s))
        .map(|(_, health)| health.sensors[sensor].state)
        .collect()
}

/// That all sensors but some were trusted from half a second before the drive's third on.
fn assert_trusted_but(whole: &RobotDrive, text: &str, broken: &[usize]) {
    for sensor in (0..SENSORS).filter(|sensor| !broken.contains(sensor)) {
        let states = states(whole, sensor, 2.5, 6.0);
        assert!(states.len() > 20, "{text}: {states:?}");
        let trusted = states.iter().all(|state| state.is_trusted());
        assert!(trusted, "{text}: s{sensor} {states:?}");
    }
}

fn mapped(text: &str) -> NodeRun {
    mapped_of(&driven(text).inputs())
}

fn mapped_of(inputs: &[Input]) -> NodeRun {
    map(&msod(), &config(), inputs).unwrap()
}

fn config() -> Config {
    Config {
        seed: SEED,
        particles_per_sensor: 50,
        ..msod().config(Profile::Plus)
    }
}

/// A window in the middle of the drive that a text may have.
fn any_window() -> impl Strategy<Value = String> {
    let ms = 1..20_000_u32;
    prop_oneof![
        Just(String::new()),
        ms.clone().prop_map(|from| format!("@{from}ms")),
        ms.clone().prop_map(|to| format!("@..{to}ms")),
        (ms.clone(), ms).prop_map(|(from, more)| {
            format!(
                "@{}s..{}s",
                f64::from(from) / 1e3,
                f64::from(from + more) / 1e3
            )
        }),
    ]
}

fn any_fault() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        Just("ok".to_owned()),
        Just("off".to_owned()),
        Just("stuck".to_owned()),
        Just("garbage".to_owned()),
        (0.0..=1.0).prop_map(|share| format!("intermittent:{share}")),
    ];
    let valued = prop_oneof![
        (1..60_000_i32, any::<bool>())
            .prop_map(|(by, up)| { format!("wrong:{}", if up { by } else { -by }) }),
        (0.1..=100.0).prop_map(|rate: f64| format!("slow:{rate}Hz")),
        (1..10_000_u32).prop_map(|ms| format!("delayed:{ms}ms")),
    ];
    let component = prop::sample::select(vec![
        "s0", "s3", "s7", "ring", "bus1", "bus2", "mux1", "mux2", "can",
    ]);
    (component, word, valued, any::<bool>(), any_window()).prop_map(
        |(component, word, valued, is_valued, window)| {
            let takes_values = component.starts_with(['s', 'r']) || component == "can";
            let word = if is_valued && takes_values {
                valued
            } else {
                word
            };
            let is_jump = component == "can" && word.starts_with("wrong");
            let unit = if is_jump { "mm" } else { "" };
            format!("{component}={word}{unit}{window}")
        },
    )
}

proptest! {
    #[test]
    fn what_is_printed_is_read_back_as_it_was(
        words in prop::collection::vec(any_fault(), 1..6),
        link in prop_oneof![Just(""), Just(", link=ber:0.001+off@2s..5s")],
    ) {
        let read = faults(&format!("{}{link}", words.join(",")));
        prop_assert_eq!(read.parts().len(), words.len());
        let printed = read.to_string();
        prop_assert_eq!(printed.parse::<Faults>(), Ok(read));
    }

    #[test]
    fn no_text_panics(text in "[a-z0-9=:@.,+ \u{e4}-]{0,40}") {
        let _ = text.parse::<Faults>();
    }
}

#[test]
fn a_wrong_word_is_refused_by_name_and_place() {
    for (text, word, place, why) in [
        ("", "", 1, "names no part"),
        ("s8=off", "s8=off", 1, "names no part"),
        ("s03=off", "s03=off", 1, "names no part"),
        ("s3", "s3", 1, "names no part"),
        ("S3=off", "S3=off", 1, "names no part"),
        ("s3=off,", "", 8, "names no part"),
        ("s3=off, bus3=off", "bus3=off", 9, "names no part"),
        ("s3=", "s3=", 1, "is no word for s3"),
        ("s3=Off", "s3=Off", 1, "is no word for s3"),
        ("s3=dead", "s3=dead", 1, "is no word for s3: ok, off"),
        ("s3=off:1", "s3=off:1", 1, "takes no value"),
        ("s3=wrong", "s3=wrong", 1, "needs counts"),
        ("s3=wrong:0", "s3=wrong:0", 1, "needs counts"),
        ("s3=wrong:70000", "s3=wrong:70000", 1, "needs counts"),
        ("s3=wrong:5mm", "s3=wrong:5mm", 1, "needs counts"),
        ("can=wrong:5", "can=wrong:5", 1, "needs millimetres"),
        ("ring=slow:20", "ring=slow:20", 1, "needs a rate"),
        ("ring=slow:125Hz", "ring=slow:125Hz", 1, "needs a rate"),
        ("can=delayed:0s", "can=delayed:0s", 1, "needs a time"),
        ("can=delayed:11s", "can=delayed:11s", 1, "needs a time"),
        (
            "s1=intermittent:1.1",
            "s1=intermittent:1.1",
            1,
            "needs a share",
        ),
        (
            "s1=intermittent:NaN",
            "s1=intermittent:NaN",
            1,
            "needs a share",
        ),
        ("s3=off@8s..5s", "s3=off@8s..5s", 1, "has no window"),
        ("s3=off@..", "s3=off@..", 1, "has no window"),
        ("s3=off@5", "s3=off@5", 1, "has no window"),
        ("s3=off@5s..", "s3=off@5s..", 1, "has no window"),
        ("ring=ok, link=of", "link=of", 10, "is no line: \"of\""),
        ("link=off, link=ok", "link=ok", 11, "names the link again"),
        // Pairs that make no sense.
        (
            "can=saturated",
            "can=saturated",
            1,
            "makes no sense for can",
        ),
        (
            "bus1=wrong:+5",
            "bus1=wrong:+5",
            1,
            "makes no sense for bus1",
        ),
        (
            "bus2=slow:20Hz",
            "bus2=slow:20Hz",
            1,
            "makes no sense for bus2",
        ),
        (
            "mux1=delayed:5ms",
            "mux1=delayed:5ms",
            1,
            "makes no sense for mux1",
        ),
        (
            "mux2=saturated",
            "mux2=saturated",
            1,
            "makes no sense for mux2",
        ),
    ] {
        let error = text.parse::<Faults>().unwrap_err();
        assert_eq!(
            (error.word(), error.place()),
            (word, place),
            "{text}: {error}"
        );
        let said = error.to_string();
        assert!(
            said.starts_with(&format!("\"{word}\" (character {place}) {why}")),
            "{said}"
        );
    }
}

#[test]
fn f01_f10_f14_a_sensor_s_faults_have_their_effect() {
    type Named = fn(SensorState) -> bool;
    let cases: [(&str, f64, Named); 4] = [
        ("off", 0.16, |state| state == SensorState::Missing),
        ("stuck", 1.3, |state| state == SensorState::Stale),
        ("garbage", 2.0, |state| {
            state == SensorState::Faulty(SensorFault::Garbage)
        }),
        ("saturated", 0.16, |state| state == SensorState::TooClose),
    ];
    for (word, named_within_s, is_named) in cases {
        let text = format!("s4={word}@3s");
        let whole = driven(&text);
        assert_trusted_but(&whole, &text, &[4]);
        assert!(
            states(&whole, 4, 1.0, 3.0)
                .iter()
                .all(|state| state.is_trusted())
        );
        let after = states(&whole, 4, 3.0 + named_within_s, 6.0);
        assert!(
            after.iter().any(|state| is_named(*state)),
            "{text}: {after:?}"
        );
        if matches!(word, "off" | "saturated") {
            assert!(
                after.iter().all(|state| is_named(*state)),
                "{text}: {after:?}"
            );
        }
    }
    // What ends, ends: asked again once a second, trusted after ten readings.
    let back = driven("s4=off@3s..4s");
    let after = states(&back, 4, 5.3, 6.0);
    assert!(
        !after.is_empty() && after.iter().all(|state| state.is_trusted()),
        "{after:?}"
    );
}

#[test]
fn a_wrong_sensor_adds_its_counts_and_the_others_are_unchanged() {
    let sound = samples(&driven("ring=ok"));
    let wrong = samples(&driven("s4=wrong:+200@3s..4s"));
    assert_eq!(sound.len(), wrong.len());
    let mut shifted = 0;
    for ((at_s, sound), (_, wrong)) in sound.iter().zip(&wrong) {
        for sensor in 0..SENSORS {
            match (sound[sensor], wrong[sensor]) {
                // A round at either end.
                _ if sensor == 4 && (3.0..3.02).contains(at_s) => {}
                _ if sensor == 4 && (4.0..4.02).contains(at_s) => {}
                (Sample::Counts(sound), Sample::Counts(wrong))
                    if sensor == 4 && (3.02..4.0).contains(at_s) =>
                {
                    assert_eq!(wrong, sound + 200, "{at_s}");
                    shifted += 1;
                }
                (sound, wrong) => assert_eq!(sound, wrong, "s{sensor} at {at_s}"),
            }
        }
    }
    assert!(shifted > 100, "{shifted}");
}

#[test]
fn f15_a_slow_sensor_has_no_sample_most_of_the_time() {
    let text = "s4=slow:20Hz@3s..5s";
    let whole = driven(text);
    assert_trusted_but(&whole, text, &[4]);
    let missing = |from_s: f64, to_s: f64| {
        let samples = samples(&whole);
        let inside = samples
            .iter()
            .filter(|(at_s, _)| (from_s..to_s).contains(at_s));
        let of: Vec<bool> = inside.map(|(_, s)| s[4] == Sample::Missing).collect();
        of.iter().filter(|missing| **missing).count() as f64 / of.len() as f64
    };
    assert!(missing(1.0, 3.0) < 1e-9);
    // A value is young for 16 of its 50 ms; rounds and readings take up to 8 of these.
    let share = missing(3.1, 5.0);
    assert!((0.5..0.95).contains(&share), "{share}");
}

#[test]
fn f15_a_delayed_sensor_gives_earlier_counts() {
    let options = Options {
        noise_factor: 0.0,
        ..Options::default()
    };
    let sound = samples(&driven_with("ring=ok", &options));
    let late = samples(&driven_with("ring=delayed:200ms@1s", &options));
    let mut differed = 0;
    for (at_s, samples) in late.iter().filter(|(at_s, _)| (1.5..6.0).contains(at_s)) {
        for sensor in 0..SENSORS {
            let Sample::Counts(late) = samples[sensor] else {
                continue;
            };
            // A measurement is up to two rounds old when it is given.
            let then = at_s - 0.2;
            let around = sound
                .iter()
                .filter(|(sound_s, _)| (sound_s - then).abs() < 0.02);
            let counts: Vec<i32> = around
                .filter_map(|(_, samples)| match samples[sensor] {
                    Sample::Counts(counts) => Some(counts),
                    _ => None,
                })
                .collect();
            let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
            assert!(
                (least - 1..=most + 1).contains(&late),
                "s{sensor} at {at_s}: {late}"
            );
            let now = sound.iter().find(|(sound_s, _)| sound_s >= at_s);
            differed += usize::from(now.is_some_and(|(_, now)| now[sensor] != samples[sensor]));
        }
    }
    assert!(differed > 100, "{differed}");
}

#[test]
fn f02_a_loose_sensor_fails_in_its_share_of_rounds() {
    let text = "s4=intermittent:0.1@1s";
    let whole = driven(text);
    assert_trusted_but(&whole, text, &[4]);
    let failed = |at_s: f64| {
        let healths = healths(&whole);
        let last = healths.iter().rfind(|(then_s, _)| *then_s <= at_s);
        last.unwrap().1.sensors.map(|sensor| sensor.failed)
    };
    let (before, after) = (failed(1.0), failed(6.0));
    assert_eq!(before, [0; SENSORS]);
    // Of 625 rounds a tenth, 62, less those in which it was not asked: 4 sigma are 30.
    assert!((20..=92).contains(&after[4]), "{after:?}");
    assert_eq!(
        after.iter().filter(|failed| **failed > 0).count(),
        1,
        "{after:?}"
    );
}

#[test]
fn f02_f03_f06_the_words_of_a_bus_and_its_mux_hit_its_four_sensors_and_no_other() {
    for part in ["bus1", "bus2", "mux1", "mux2"] {
        let number = if part.ends_with('1') { 1 } else { 2 };
        let own: Vec<usize> = (0..SENSORS)
            .filter(|sensor| BUS_OF[*sensor] == number)
            .collect();
        for word in ["off", "stuck", "garbage", "intermittent:0.3"] {
            let text = format!("{part}={word}@3s");
            let whole = driven(&text);
            assert_trusted_but(&whole, &text, &own);
            let healths = healths(&whole);
            let before = healths.iter().rfind(|(at_s, _)| *at_s < 3.0).unwrap().1;
            let (_, after) = healths.last().unwrap();
            let other = 2 - number;
            // Sensors fail when the mux is not where it should be, without the bus failing.
            let failed = |health: &Health| {
                let of_sensors = own.iter().map(|sensor| health.sensors[*sensor].failed);
                u32::from(health.buses[number - 1].failed) + of_sensors.map(u32::from).sum::<u32>()
            };
            assert!(failed(after) > failed(&before) + 3, "{text}: {after:?}");
            assert_eq!(after.buses[other].state, BusState::Working, "{text}");
            assert_eq!(
                after.buses[other].failed, before.buses[other].failed,
                "{text}"
            );
            let missing = own.iter().filter(|sensor| {
                let states = states(&whole, **sensor, 3.3, 6.0);
                states.iter().all(|state| *state == SensorState::Missing)
            });
            let missing = missing.count();
            match (part.starts_with("bus"), word) {
                (_, "off") => assert_eq!(missing, 4, "{text}: {after:?}"),
                (true, "stuck") => {
                    assert_eq!(after.buses[number - 1].state, BusState::HeldLow, "{text}");
                    assert_eq!(missing, 4, "{text}: {after:?}");
                }
                // At most the channel on which it stays goes on.
                (false, "stuck") => assert!(missing >= 3, "{text}: {after:?}"),
                _ => {}
            }
        }
    }
}

#[test]
fn what_is_over_on_a_bus_is_over() {
    for text in [
        "bus2=stuck@2s..3s",
        "bus2=off@2s..3s",
        "mux2=off@2s..3s",
        "mux2=stuck@2s..3s",
    ] {
        let whole = driven(text);
        for sensor in 0..SENSORS {
            // Tried again once a second, and ten readings to earn trust.
            let states = states(&whole, sensor, 4.6, 6.0);
            assert!(
                !states.is_empty() && states.iter().all(|state| state.is_trusted()),
                "{text}"
            );
        }
    }
}

/// Times of the drive, seconds, at which steps began.
fn steps_s(mapped: &NodeRun) -> Vec<f64> {
    mapped.steps().map(|step| drive_s(step.stamp_us)).collect()
}

#[test]
fn f20_can_off_suspends_within_375_ms() {
    let steps = steps_s(&mapped("can=off@3s"));
    assert!(
        steps.iter().filter(|at_s| **at_s < 3.0).count() > 10,
        "{steps:?}"
    );
    assert!(steps.iter().all(|at_s| *at_s < 3.375), "{steps:?}");
}

/// Odometry between two times of the drive: when it was heard, when it was reckoned, and
/// its place in micrometres.
fn poses_received(whole: &RobotDrive, from_s: f64, to_s: f64) -> Vec<(f64, f64, [i32; 2])> {
    let received = whole
        .reports
        .iter()
        .filter_map(|report| match report.content {
            ReportContent::Pose {
                input: Input::Odometry { pose, .. },
                updated_us,
            } => Some((
                drive_s(report.at_us),
                drive_s(updated_us),
                [pose.position.x, pose.position.y].map(|m| (m * 1e6) as i32),
            )),
            _ => None,
        });
    received
        .filter(|(at_s, ..)| (from_s..to_s).contains(at_s))
        .collect()
}

#[test]
fn f23_f31_can_s_other_faults_have_their_effect() {
    let sound = poses_received(&driven("ring=ok"), 3.0, 5.0);
    let of = |word: &str| {
        let whole = driven(&format!("can={word}@3s..5s"));
        (poses_received(&whole, 3.0, 5.0), mapped_of(&whole.inputs()))
    };
    let (stuck, _) = of("stuck");
    assert_eq!(stuck.len(), sound.len());
    assert!(stuck.iter().all(|(.., place)| *place == stuck[0].2));
    let (garbage, on_map) = of("garbage");
    // A heading beyond a full turn is no frame; what is left is anywhere.
    assert!((5..25).contains(&garbage.len()), "{}", garbage.len());
    let is_sound = |place| sound.iter().any(|(.., sound)| *sound == place);
    assert!(!garbage.iter().any(|(.., place)| is_sound(*place)));
    assert!(
        driven("can=garbage@3s..5s")
            .healths
            .last()
            .unwrap()
            .1
            .can
            .ignored
            > 5
    );
    let mut refusals = on_map.outcome.refusals.iter();
    assert!(refusals.any(|(_, fault)| *fault == InputError::Implausible));
    let (wrong, on_map) = of("wrong:+500mm");
    for ((.., wrong), (.., sound)) in wrong.iter().zip(&sound) {
        // Two steps of the message, which rounds down.
        assert!(
            (wrong[0] - sound[0] - 500_000).abs() < 600,
            "{wrong:?} {sound:?}"
        );
        assert_eq!(wrong[1], sound[1]);
    }
    let was_reset = |event: &&Event| matches!(event, Event::OdometryReset { .. });
    assert!(on_map.events.iter().filter(was_reset).count() >= 1);
    // Frames come each 63 ms: every fourth is 200 ms after one that came.
    let (slow, _) = of("slow:5Hz");
    assert!(
        slow.windows(2).all(|two| two[1].0 - two[0].0 >= 0.2),
        "{slow:?}"
    );
    assert!((7..=9).contains(&slow.len()), "{slow:?}");
    let (late, _) = of("delayed:300ms");
    // A pose is up to 50 ms old when it is sent.
    let in_time = late
        .iter()
        .filter(|(at_s, updated_s, _)| at_s - updated_s < 0.3);
    assert_eq!(in_time.count(), 0, "{late:?}");
    assert!(
        late.iter()
            .all(|(at_s, updated_s, _)| at_s - updated_s < 0.351)
    );
    let (loose, _) = of("intermittent:0.5");
    // 32 frames, of which a half: 4 sigma are 11.
    assert!(
        (5..=27).contains(&loose.len()) && sound.len() >= 31,
        "{}",
        loose.len()
    );
}

#[test]
fn ok_ends_what_was_named_before() {
    let text = "ring=off@2s, s3=ok, ring=ok@3s";
    let whole = driven(text);
    let three = states(&whole, 3, 1.0, 6.0);
    assert!(three.iter().all(|state| state.is_trusted()), "{three:?}");
    let dead = states(&whole, 4, 2.2, 3.0);
    assert!(
        dead.iter().all(|state| *state == SensorState::Missing),
        "{dead:?}"
    );
    let back = states(&whole, 4, 4.6, 6.0);
    assert!(
        !back.is_empty() && back.iter().all(|state| state.is_trusted()),
        "{back:?}"
    );
    assert_eq!(driven("s4=off, s4=ok"), driven("ring=ok"));
}

#[test]
fn the_same_words_script_buses_without_a_robot() {
    let mut buses = RobotBuses::default();
    faults("bus1=off@1s..2s, mux2=off@3s")
        .active(1)
        .script(&mut buses, 0);
    let answers = |buses: &mut RobotBuses, at_s: u64| {
        buses.advance_to(at_s * 1_000_000_000);
        [0, 1].map(|bus| {
            use embedded_hal::i2c::I2c;
            buses.bus_mut(bus).write(0x77, &[0x04]).is_ok()
        })
    };
    // A second and some bytes: the window begins with it.
    assert_eq!(answers(&mut buses, 0), [true, true]);
    assert_eq!(answers(&mut buses, 1), [false, true]);
    assert_eq!(answers(&mut buses, 2), [true, true]);
    assert_eq!(answers(&mut buses, 3), [true, false]);
}

fn recorded(text: &str, seed_of_faults: u64) -> Vec<u8> {
    let (scenario, faults) = (msod(), faults(text));
    let drive = SimulatedDrive {
        scenario: &scenario,
        text: MSOD,
        seed: SEED,
        options: Options::default(),
        faults: &faults,
        seed_of_faults,
    };
    let (simulation, _) = drive.simulate().unwrap();
    drive.write(&simulation, Vec::new()).unwrap()
}

#[test]
fn equal_seeds_give_equal_files_and_others_do_not() {
    for text in [
        "s4=garbage@2s",
        "s3=intermittent:0.3, bus2=garbage@3s..4s",
        "can=intermittent:0.3, mux1=garbage@2s..3s",
        "link=ber:1e-4",
    ] {
        let first = recorded(text, 1);
        assert!(first == recorded(text, 1), "{text}");
        let inputs = |bytes: &[u8]| read_from(bytes).unwrap().inputs;
        assert!(inputs(&first) != inputs(&recorded(text, 2)), "{text}");
    }
}

#[test]
fn without_faults_of_parts_a_recording_is_the_simulation_and_all_its_true_poses() {
    let simulation = simulate_with(&msod(), SEED, &Options::default());
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_truth(&TruthMessage::Seed(SEED)).unwrap();
    writer.write_scenario(MSOD).unwrap();
    let config = Config {
        seed: SEED,
        ..msod().config(Profile::Paper)
    };
    writer.write_input(&Input::Configure(config)).unwrap();
    let mut poses = simulation.poses.iter();
    for input in &simulation.inputs {
        writer.write_input(input).unwrap();
        // Every reading has its pose.
        if matches!(input, Input::Proximity { .. }) {
            let &(stamp_us, pose) = poses.next().unwrap();
            writer
                .write_truth(&TruthMessage::Pose { stamp_us, pose })
                .unwrap();
        }
    }
    assert!(poses.next().is_none());
    assert!(recorded("ok", 1) == writer.finish().unwrap());
}

#[test]
fn f60_f63_frames_that_a_bad_line_loses_are_reported() {
    let sound = read_from(&recorded("ok", 1)[..]).unwrap();
    let text = "link=drop:1e-4x300+off@2s..3s";
    let recording = read_from(&recorded(text, 1)[..]).unwrap();
    assert_eq!(recording.truth.unwrap().faults, [(text_of(text), 1)]);
    assert!(recording.inputs.len() < sound.inputs.len());
    assert!(
        recording.refusals.count_of(Reason::Lost) > 0,
        "{}",
        recording.refusals
    );
    // What arrived is what was sent.
    let mut sent = sound.inputs.iter();
    assert!(
        recording
            .inputs
            .iter()
            .all(|input| sent.any(|sent| sent == input))
    );
    assert_eq!(recording.config, sound.config);
}

fn text_of(text: &str) -> String {
    faults(text).to_string()
}

#[test]
fn f31_a_recording_whose_odometry_is_random_for_a_third_of_it_is_read() {
    // Positions from random bits look like metres a micrometre each.
    let recording = read_from(&recorded("can=garbage@2s..4s", 1)[..]).unwrap();
    let (steps, refused) = {
        let config = Config {
            particles_per_sensor: 50,
            ..recording.config.unwrap()
        };
        let outcome = run(&config, &recording.inputs, |_| ()).unwrap();
        let refused: Vec<InputError> = outcome.faults().map(|(fault, _)| fault).collect();
        (outcome.steps, refused)
    };
    assert!(steps > 0);
    assert!(refused.contains(&InputError::Implausible), "{refused:?}");
    // From its beginning to its end it is taken for another unit.
    let error = read_from(&recorded("can=garbage", 1)[..]).unwrap_err();
    assert!(error.to_string().contains("look like"), "{error}");
}

#[test]
fn a_recording_with_faults_replays_equal_and_contains_its_faults() {
    // Long enough for two pieces.
    let text = "s3=stuck@5s..8s, can=off@4s..4.5s, s0=wrong:+200@1s..2s, s1=intermittent:0.3, \
                s2=garbage@2s..3s, mux2=off@3s..3.5s";
    let recording = read_from(&recorded(text, 9)[..]).unwrap();
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    let truth = recording.truth.unwrap();
    assert_eq!(truth.faults, [(text.to_owned(), 9)]);
    assert_eq!(truth.faults[0].0.parse(), Ok(faults(text)));
    assert_eq!(truth.seed, Some(SEED));
    // Once with a board's answers, which is again a recording.
    let config = Config {
        particles_per_sensor: 50,
        ..recording.config.unwrap()
    };
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer
        .write_faults(&truth.faults[0].0, truth.faults[0].1)
        .unwrap();
    writer.write_faults("link=off", 10).unwrap();
    writer.write_input(&Input::Configure(config)).unwrap();
    for input in &recording.inputs {
        writer.write_input(input).unwrap();
    }
    let mut board = Encoder::new(1);
    let mut answers = Vec::new();
    run(&config, &recording.inputs, |event| {
        answers.extend_from_slice(board.encode(event));
    })
    .unwrap();
    writer.write_frames(&answers).unwrap();
    let again = read_from(&writer.finish().unwrap()[..]).unwrap();
    let said = &again.truth.as_ref().unwrap().faults;
    assert_eq!(said, &[(text.to_owned(), 9), ("link=off".to_owned(), 10)]);
    let mut comparison = Comparison::default();
    run(&config, &again.inputs, |event| comparison.expect(event)).unwrap();
    again.events().for_each(|event| comparison.meet(event));
    let verdict = comparison.verdict_of_recording();
    assert!(verdict.equal, "{verdict}");
}

#[test]
fn texts_of_faults_without_end_are_not_read() {
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_faults(&"x".repeat(5_000), 1).unwrap();
    writer.write_input(&Input::Tick { stamp_us: 1 }).unwrap();
    let recording = read_from(&writer.finish().unwrap()[..]).unwrap();
    assert_eq!(recording.refusals.count_of(Reason::BadFaults), 1);
    assert!(recording.truth.is_none_or(|truth| truth.faults.is_empty()));
    assert_eq!(recording.inputs.len(), 1);
}

#[test]
fn the_page_s_table_has_every_word_of_every_part_and_no_other() {
    const PAGE: &str = include_str!("../../../docs/faults.md");
    let (_, section) = PAGE.split_once("## Provoke one").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let mut faulty: [Vec<String>; 4] = Default::default();
    for row in rows {
        let cells: Vec<&str> = row.split(" | ").collect();
        let word = cells[0].trim_start_matches("| ").trim_matches('`');
        let name = word.split(':').next().unwrap().to_owned();
        for (words, cell) in faulty.iter_mut().zip(&cells[1..]) {
            if cell.trim_end_matches(" |") != "-" {
                words.push(name.clone());
            }
        }
    }
    for (part, faulty) in ["s0", "bus1", "mux1", "can"].into_iter().zip(faulty) {
        let component = faults(&format!("{part}=ok")).parts()[0].component;
        let words = component.words().iter();
        let names: Vec<&str> = words.map(|word| word.split(':').next().unwrap()).collect();
        assert_eq!(faulty, names, "{part}");
    }
}

/// What a node is told of the simulated drive with faults on its inputs.
fn disturbed(inputs: &[Input], text: &str) -> Vec<Input> {
    faults(text).on_inputs(3, inputs).unwrap()
}

#[test]
fn faults_on_recorded_inputs_have_their_effect() {
    let inputs = simulate_with(&msod(), SEED, &Options::default()).inputs;
    let sensor = |inputs: &[Input]| -> Vec<(u64, Sample)> {
        let readings = inputs.iter().filter_map(|input| match *input {
            Input::Proximity { stamp_us, samples } => Some((stamp_us, samples[4])),
            _ => None,
        });
        readings.collect()
    };
    let sound = sensor(&inputs);
    let inside = |stamp_us: u64| (3_000_000..4_000_000).contains(&stamp_us);
    for word in [
        "off",
        "stuck",
        "garbage",
        "wrong:-7",
        "saturated",
        "intermittent:0.3",
    ] {
        let faulty = disturbed(&inputs, &format!("s4={word}@3s..4s"));
        assert_eq!(
            faulty,
            disturbed(&inputs, &format!("s4={word}@3s..4s")),
            "{word}"
        );
        assert_eq!(faulty.len(), inputs.len(), "{word}");
        let faulty = sensor(&faulty);
        let pairs = || faulty.iter().zip(&sound);
        assert!(
            pairs()
                .filter(|(_, sound)| !inside(sound.0))
                .all(|(a, b)| a == b),
            "{word}"
        );
        let held: Vec<(Sample, Sample)> = pairs()
            .filter(|(_, sound)| inside(sound.0))
            .map(|(faulty, sound)| (faulty.1, sound.1))
            .collect();
        assert!(held.len() >= 7, "{word}: {}", held.len());
        let all = |is: &dyn Fn(Sample, Sample) -> bool| held.iter().all(|(a, b)| is(*a, *b));
        match word {
            "off" => assert!(all(&|faulty, _| faulty == Sample::Missing)),
            "saturated" => assert!(all(&|faulty, _| faulty == Sample::Saturated)),
            "stuck" => assert!(all(&|faulty, _| faulty == held[0].1)),
            "wrong:-7" => assert!(all(&|faulty, sound| match (faulty, sound) {
                (Sample::Counts(faulty), Sample::Counts(sound)) => faulty == sound - 7,
                (faulty, sound) => faulty == sound,
            })),
            "garbage" => {
                let far = held.iter().filter(|(faulty, _)| match faulty {
                    Sample::Counts(counts) => !(-500..500).contains(counts),
                    _ => true,
                });
                assert!(far.count() * 2 > held.len(), "{held:?}");
            }
            _ => assert!(all(
                &|faulty, sound| faulty == sound || faulty == Sample::Missing
            )),
        }
    }
    let loose = sensor(&disturbed(&inputs, "s4=intermittent:0.3"));
    let missing = loose
        .iter()
        .filter(|(_, sample)| *sample == Sample::Missing)
        .count();
    let n = loose.len() as f64;
    let error = missing as f64 - 0.3 * n;
    // Four standard deviations of a binomial count.
    assert!(error.abs() < 4.0 * (0.21 * n).sqrt(), "{missing} of {n}");
}

#[test]
fn f20_f31_odometry_of_recorded_inputs_can_be_lost_late_and_elsewhere() {
    let inputs = simulate_with(&msod(), SEED, &Options::default()).inputs;
    let poses = |inputs: &[Input]| -> Vec<(u64, f32)> {
        let poses = inputs.iter().filter_map(|input| match *input {
            Input::Odometry { stamp_us, pose } => Some((stamp_us, pose.position.x)),
            _ => None,
        });
        poses.collect()
    };
    let sound = poses(&inputs);
    let off = disturbed(&inputs, "can=off@3s");
    assert!(
        poses(&off)
            .iter()
            .all(|(stamp_us, _)| *stamp_us < 3_000_000)
    );
    assert!(steps_s(&mapped_of(&off)).iter().all(|at_s| *at_s < 3.375));
    let jumped = poses(&disturbed(&inputs, "can=wrong:+500mm@3s"));
    for ((stamp_us, jumped), (_, sound)) in jumped.iter().zip(&sound) {
        let by = if *stamp_us < 3_000_000 { 0.0 } else { 0.5 };
        assert!((jumped - sound - by).abs() < 1e-6, "{stamp_us}");
    }
    let late = disturbed(&inputs, "can=delayed:300ms");
    let stamps: Vec<u64> = poses(&late).iter().map(|(stamp_us, _)| *stamp_us).collect();
    let expected = sound.iter().map(|(stamp_us, _)| stamp_us + 300_000);
    assert_eq!(stamps, expected.collect::<Vec<_>>());
    let mut newest_us = 0;
    for input in &late {
        if let Input::Odometry { stamp_us, .. } | Input::Proximity { stamp_us, .. } = *input {
            assert!(stamp_us >= newest_us, "{stamp_us}");
            newest_us = stamp_us;
        }
    }
    let loose = poses(&disturbed(&inputs, "can=intermittent:0.5")).len() as f64;
    let n = sound.len() as f64;
    assert!(
        (loose - 0.5 * n).abs() < 4.0 * (0.25 * n).sqrt(),
        "{loose} of {n}"
    );
}

#[test]
fn words_that_inputs_cannot_show_are_refused_by_name() {
    for text in [
        "s3=slow:20Hz",
        "ring=delayed:50ms@5s",
        "can=stuck",
        "can=garbage",
        "can=slow:5Hz",
        "bus1=off",
        "mux2=stuck@..8s",
    ] {
        let error = faults(&format!("s1=off, {text}"))
            .on_inputs(1, &[])
            .unwrap_err();
        assert!(
            error.to_string().starts_with(&format!("\"{text}\" cannot")),
            "{error}"
        );
    }
    // The line's own and what is well are nobody's loss.
    assert_eq!(faults("link=off, bus1=ok").on_inputs(1, &[]), Ok(vec![]));
}
