//! The ring's driver on the robot's two buses, with faults on the wires.
//!
//! Names that begin with f01 to f18 are entries of the fault catalogue.

mod bench;
mod drivers;
mod rounds;

use amiro_ipf::board::acquisition::Bus;
use amiro_ipf::board::sensor_state::{SensorFault, SensorState};
use amiro_ipf::model::{Photometry, Reading, SENSORS, Sample};
use amiro_ipf::random::{Generator, uniform_below};
use bench::Bench;
use embedded_hal::i2c::I2c;
use sim_harness::bus::{FakeBus, InjectedBusFault, MuxFault, Random, Vcnl4020Fault, Vcnl4020Model};

const ROUND_US: u64 = 8_000;

/// All faults of the multiplexer; a lost write rarely has an effect, so it comes more often.
fn mux_faults() -> Vec<InjectedBusFault> {
    let mut faults = vec![MuxFault::WriteLost; 4];
    faults.extend([0, 1, 2, 3].map(MuxFault::Jump));
    faults.push(MuxFault::Reset);
    faults.into_iter().map(InjectedBusFault::Mux).collect()
}

#[test]
fn without_faults_every_sensor_delivers_in_every_round() {
    let mut bench = Bench::running(1);
    let before = bench.readings();
    for round in 0..1_000 {
        bench.round();
        assert_eq!(
            bench.states(),
            [SensorState::Good; SENSORS],
            "round {round}"
        );
        bench.assert_own_tags("without faults");
    }
    assert_eq!(bench.readings(), before.map(|readings| readings + 1_000));
}

#[test]
fn f01_an_unplugged_sensor_is_missing_within_24_ms_and_the_others_lose_nothing() {
    for unplugged in 0..SENSORS {
        let mut bench = Bench::running(1);
        let before = bench.readings();
        let from_us = bench.next_round_us();
        bench.strike(unplugged, Vcnl4020Fault::Unplugged);
        while bench.states()[unplugged] != SensorState::Missing {
            bench.round();
        }
        // The rounds 0, 8 and 16 ms after it.
        assert!(bench.now_us() - from_us <= 16_000, "sensor {unplugged}");
        bench.rounds(247);
        for (sensor, (before, after)) in before.into_iter().zip(bench.readings()).enumerate() {
            let lost = 250 - (after - before);
            let expected = if sensor == unplugged { 250 } else { 0 };
            assert_eq!(lost, expected, "sensor {sensor} of unplugged {unplugged}");
        }
        bench.strike(unplugged, Vcnl4020Fault::PluggedIn);
        bench.rounds(140);
        assert_eq!(bench.states(), [SensorState::Good; SENSORS]);
    }
}

/// Rounds from power-up or from trust on, with a fault at each byte of one bus in turn.
fn at_every_byte(
    fresh: fn() -> Bench,
    fault: InjectedBusFault,
    mut judge: impl FnMut(&mut Bench, String),
) {
    for bus in 0..2 {
        // How many bytes three rounds have without a fault.
        let mut bench = fresh();
        let first = bench.buses.bus_mut(bus).bytes();
        bench.rounds(3);
        let end = bench.buses.bus_mut(bus).bytes();
        assert!(end - first > 200, "{} bytes", end - first);
        for at in first..end {
            let mut bench = fresh();
            bench.buses.bus_mut(bus).script.at_byte(at, fault);
            judge(&mut bench, format!("{fault:?} at byte {at} of bus {bus}"));
        }
    }
}

#[test]
fn f02_a_refusal_or_lost_arbitration_at_any_byte_gives_no_wrong_reading() {
    let mut hits = 0;
    for fault in [
        InjectedBusFault::NoAcknowledge,
        InjectedBusFault::ArbitrationLost,
    ] {
        for fresh in [|| Bench::new(2), || Bench::running(2)] {
            at_every_byte(fresh, fault, |bench, story| {
                for _ in 0..4 {
                    bench.round();
                    bench.assert_own_tags_and_idle(&story);
                }
                // One fault does not cost any sensor its trust.
                bench.rounds(10);
                assert_eq!(bench.states(), [SensorState::Good; SENSORS], "{story}");
                hits += bench.buses.one.script.hits() + bench.buses.two.script.hits();
            });
        }
    }
    // Each byte once for arbitration; a byte that is read cannot be refused.
    assert!(hits > 1_500, "{hits}");
}

#[test]
fn f03_a_data_line_held_low_from_any_byte_on_gives_no_wrong_reading() {
    for clocks in [9, 18] {
        at_every_byte(
            || Bench::running(3),
            InjectedBusFault::SdaLow { clocks },
            |bench, story| {
                for _ in 0..4 {
                    bench.round();
                    bench.assert_own_tags_and_idle(&story);
                }
                // A command register that was read as 0 has cost a configuration.
                bench.rounds(10);
                assert_eq!(bench.states(), [SensorState::Good; SENSORS], "{story}");
            },
        );
    }
}

#[test]
fn f06_without_a_mux_its_four_sensors_are_missing_and_come_back() {
    let mut bench = Bench::running(1);
    let before = bench.readings();
    let from_us = bench.next_round_us();
    let (from_ns, to_ns) = (from_us * 1_000, (from_us + 100 * ROUND_US) * 1_000);
    let script = &mut bench.buses.one.script;
    script.between(from_ns, to_ns, InjectedBusFault::NoAcknowledge);
    bench.rounds(3);
    let of_one = [true, true, true, false, false, false, false, true];
    let missing = bench.states().map(|state| state == SensorState::Missing);
    assert_eq!(missing, of_one);
    assert_eq!(bench.ring.bus_counters(Bus::I2c1).mux_failures, 3);
    assert_eq!(bench.ring.bus_counters(Bus::I2c2).mux_failures, 0);
    assert!(bench.now_us() - from_us <= 16_000);
    bench.rounds(97);
    for (sensor, mute) in of_one.into_iter().enumerate() {
        let readings = bench.readings()[sensor] - before[sensor];
        assert_eq!(readings, if mute { 0 } else { 100 }, "sensor {sensor}");
    }
    bench.rounds(140);
    assert_eq!(bench.states(), [SensorState::Good; SENSORS]);
}

#[test]
fn f07_a_mux_fault_at_any_byte_credits_no_reading_to_another_sensor() {
    let mut hits = 0;
    for fault in [0, 1, 2, 3].map(MuxFault::Jump) {
        for fault in [fault, MuxFault::WriteLost, MuxFault::Reset] {
            at_every_byte(
                || Bench::running(4),
                InjectedBusFault::Mux(fault),
                |bench, story| {
                    for _ in 0..2 {
                        bench.round();
                        bench.assert_own_tags(&story);
                    }
                    hits += bench.buses.one.script.hits() + bench.buses.two.script.hits();
                },
            );
        }
    }
    assert!(hits > 2_000, "{hits}");
}

/// Rounds until so many mux faults have changed something.
fn under_random_mux_faults(seed: u64, hits: u64) {
    let mut bench = Bench::running(seed);
    let before = bench.readings();
    for bus in 0..2 {
        // A readout has 22 bytes, with a deselection 26: no two faults in the same one. No
        // read-back can detect a jump away and back within a readout.
        let faults = Random::new(mux_faults(), 27..=50, seed + bus as u64);
        bench.buses.bus_mut(bus).script.at_random(Some(faults));
    }
    let mut struck = 0;
    while struck < hits {
        bench.round();
        bench.assert_own_tags(&format!("seed {seed}"));
        struck = bench.buses.one.script.hits() + bench.buses.two.script.hits();
    }
    let mut discarded = 0;
    for (sensor, before) in before.into_iter().enumerate() {
        let counters = bench.ring.counters()[sensor];
        discarded += u64::from(counters.discarded_for_mux);
        let read = counters.readings - before;
        assert!(u64::from(read) > hits / 100, "sensor {sensor} read {read}");
    }
    assert!(discarded > hits / 50, "{discarded} of {struck}");
}

#[test]
fn f07_of_half_a_million_random_mux_faults_none_credits_a_reading_to_another_sensor() {
    under_random_mux_faults(1, 500_000);
}

#[test]
fn f07_nor_does_one_of_half_a_million_others() {
    under_random_mux_faults(1_001, 500_000);
}

#[test]
fn f09_a_full_register_is_too_close_and_no_distance() {
    let mut bench = Bench::running(1);
    for _ in 0..300 {
        bench.buses.set_signal(5, u16::MAX);
        bench.round_as_it_is(true);
        let sample = bench.samples()[5];
        assert!(matches!(
            sample,
            Sample::Saturated | Sample::Counts(450..=660)
        ));
    }
    assert_eq!(bench.states()[5], SensorState::TooClose);
    assert_eq!(
        Photometry::VCNL4020.read(bench.samples()[5]),
        Reading::TooClose
    );
}

#[test]
fn f10_a_stuck_sensor_is_stale_after_a_second_of_driving_and_not_of_standing() {
    for (moving, expected) in [(true, Some(124..=150)), (false, None)] {
        let mut bench = Bench::running(1);
        let found = (0..400).find(|_| {
            bench.set_tags();
            bench.buses.set_signal(2, Bench::tag(2));
            bench.round_as_it_is(moving);
            bench.states()[2] == SensorState::Stale
        });
        match expected {
            Some(rounds) => assert!(rounds.contains(&found.unwrap()), "{found:?} rounds"),
            None => assert_eq!(found, None),
        }
        let stale = bench.states().map(|state| state == SensorState::Stale);
        let expected = core::array::from_fn(|sensor| moving && sensor == 2);
        assert_eq!(stale, expected);
    }
}

#[test]
fn f11_spikes_pass_unchanged_and_the_sensor_stays_trusted() {
    let mut bench = Bench::running(1);
    for round in 0..3_000 {
        bench.set_tags();
        // Three in every fifteen samples.
        let spikes = round % 15 < 3;
        if spikes {
            bench.buses.set_signal(4, 20_000);
        }
        bench.round_as_it_is(true);
        assert!(bench.states()[4].is_trusted(), "round {round}");
        let raw = bench.ring.raw(4).unwrap();
        let own = Bench::tag(4)..=Bench::tag(4) + 2;
        assert!(raw == 20_000 || own.contains(&raw), "{raw}");
    }
}

#[test]
fn f12_a_sensor_in_saturating_light_is_faulty_after_its_next_ambient_measurement() {
    let mut bench = Bench::running(1);
    bench.rounds(63);
    bench.buses.sensor_mut(6).set_ambient(45_000);
    let dazzled = SensorState::Faulty(SensorFault::Dazzled);
    // Two ambient results a second.
    let rounds = (1..).find(|_| {
        bench.round();
        bench.states()[6] == dazzled
    });
    assert!(rounds.unwrap() <= 64, "{rounds:?} rounds");
    assert_eq!(bench.samples()[6], Sample::Missing);
    assert_eq!(bench.states()[5], SensorState::Good);
}

/// The range, millimetres; contact is 0.
fn range_mm(reading: Reading) -> f32 {
    match reading {
        Reading::Range(echo) | Reading::NothingInRange(echo) => {
            assert!(echo.range_m.is_finite() && echo.sigma_m.is_finite());
            assert!(echo.range_m > 0.0 && echo.sigma_m > 0.0, "{echo:?}");
            echo.range_m * 1e3
        }
        Reading::TooClose => 0.0,
        // No comparison holds.
        Reading::Faulty => f32::NAN,
    }
}

#[test]
fn f13_every_code_of_every_sensor_means_a_finite_range_and_more_counts_a_nearer_one() {
    let mut bench = Bench::new(1);
    // Not so high that low codes are taken for those of a broken sensor.
    let offset = |sensor: usize| 125 * (1 + sensor as u16);
    bench.ring.set_offsets(core::array::from_fn(offset));
    for sensor in 0..SENSORS {
        bench.buses.set_signal(sensor, 0);
    }
    (0..20).for_each(|_| bench.round_as_it_is(false));
    let mut before = [f32::INFINITY; SENSORS];
    let mut last = [0; SENSORS];
    // What is measured before a sensor's turn is read in the same round, else in the next.
    for code in (0..=u16::MAX).chain([u16::MAX]) {
        for sensor in 0..SENSORS {
            bench.buses.set_signal(sensor, code);
        }
        bench.round_as_it_is(false);
        for (sensor, sample) in bench.samples().into_iter().enumerate() {
            let raw = bench.ring.raw(sensor).unwrap();
            assert!(raw - last[sensor] <= 1, "sensor {sensor} leaves {raw} out");
            last[sensor] = raw;
            let expected = match raw {
                u16::MAX => Sample::Saturated,
                raw => Sample::Counts(i32::from(raw) - i32::from(offset(sensor))),
            };
            assert_eq!(sample, expected, "sensor {sensor}: {raw}");
            let range = range_mm(Photometry::VCNL4020.read(sample));
            assert!(range <= before[sensor], "sensor {sensor}: {raw}");
            before[sensor] = range;
        }
    }
    assert_eq!(last, [u16::MAX; SENSORS]);
}

#[test]
fn f14_garbage_is_left_out_within_two_seconds() {
    for seed in 1..=3 {
        let mut bench = Bench::running(seed);
        let garbage = SensorState::Faulty(SensorFault::Garbage);
        let found = (1..=250).find(|_| {
            bench.set_tags();
            let random = bench.below(1 << 16) as u16;
            bench.buses.set_signal(1, random);
            bench.round_as_it_is(true);
            bench.states()[1] == garbage
        });
        assert!(found.is_some(), "seed {seed}");
        assert_eq!(bench.samples()[1], Sample::Missing);
        let faulty = bench.states().map(|state| state == garbage);
        assert_eq!(faulty.iter().filter(|is| **is).count(), 1, "seed {seed}");
    }
}

#[test]
fn f15_sensors_whose_clocks_are_five_percent_off_never_go_stale() {
    for seed in 1..=3 {
        let mut bench = Bench::new(seed);
        bench.buses.scatter_clocks(seed);
        bench.rounds(16);
        for round in 0..2_000 {
            bench.round();
            assert_eq!(
                bench.states(),
                [SensorState::Good; SENSORS],
                "{seed}, {round}"
            );
        }
    }
}

#[test]
fn f15_no_value_older_than_16_ms_is_used() {
    let mut bench = Bench::running(1);
    // The sensor pauses for up to nine rounds.
    let (mut readings, mut taken_us) = (bench.readings()[3], bench.now_us());
    let mut unused = 0;
    for _ in 0..300 {
        let pause = u64::from(bench.below(10));
        let next_ns = (bench.next_round_us() + pause * ROUND_US) * 1_000;
        bench.buses.sensor_mut(3).measure_next_at(next_ns);
        for _ in 0..10 {
            bench.round();
            let new = bench.readings()[3];
            if new != readings {
                (readings, taken_us) = (new, bench.now_us());
            }
            for later_us in [0, 1, 4_000, 7_999] {
                let now_us = bench.now_us() + later_us;
                let is_used = bench.ring.samples(now_us)[3] != Sample::Missing;
                assert!(!is_used || now_us - taken_us <= 16_000);
                unused += u32::from(!is_used);
            }
        }
    }
    assert!(unused > 1_000, "{unused}");
}

#[test]
fn f16_a_sensor_that_lost_its_configuration_delivers_again_within_1_2_seconds() {
    for sensor in 0..SENSORS {
        let mut bench = Bench::running(1);
        bench.strike(sensor, Vcnl4020Fault::Reset);
        let from_us = bench.next_round_us();
        bench.round();
        assert_eq!(bench.samples()[sensor], Sample::Missing);
        // Configured in the round that found it so; two rounds later at the latest.
        bench.rounds(2);
        assert_eq!(bench.states()[sensor], SensorState::Good, "sensor {sensor}");
        assert!(bench.now_us() - from_us <= 1_200_000, "sensor {sensor}");
        assert_eq!(bench.ring.counters()[sensor].resets, 1);
        let configured = [0x82, 0x83, 0x84].map(|at| bench.buses.sensor_mut(sensor).register(at));
        assert_eq!(configured, [0x06, 0x14, 0x15]);
    }
}

#[test]
fn f16_another_part_in_a_sensors_place_is_not_written_to() {
    let mut bench = Bench::new(1);
    bench.buses.sensor_mut(0).set_identity(0x32);
    bench.rounds(300);
    assert_eq!(
        bench.states()[0],
        SensorState::Faulty(SensorFault::WrongIdentity)
    );
    let part = bench.buses.sensor_mut(0);
    assert_eq!(
        [0x80, 0x82, 0x83].map(|at| part.register(at)),
        [0x80, 0, 0x02]
    );
    part.set_identity(0x21);
    bench.rounds(140);
    assert_eq!(bench.states(), [SensorState::Good; SENSORS]);
}

/// Two results of which no mixture is either.
const WHOLE: [u16; 2] = [0x0aff, 0x0b00];

#[test]
fn f17_of_a_million_random_update_phases_none_gives_a_torn_value() {
    let mut bench = Bench::running(1);
    // The first of them replace the tags.
    for sensor in 0..SENSORS {
        bench.buses.set_signal(sensor, WHOLE[0]);
    }
    (0..2).for_each(|_| bench.round_as_it_is(true));
    let mut readings = bench.readings();
    let mut read = 0;
    let mut torn = 0;
    while read < 1_000_000 {
        for sensor in 0..SENSORS {
            let next_ns = bench.next_round_us() * 1_000 + u64::from(bench.below(8_000_000));
            let part = bench.buses.sensor_mut(sensor);
            part.queue_signals(WHOLE);
            part.measure_next_at(next_ns);
        }
        bench.round_as_it_is(true);
        for (sensor, before) in readings.iter_mut().enumerate() {
            let raw = bench.ring.raw(sensor).unwrap();
            let new = bench.readings()[sensor] - *before;
            *before += new;
            read += u64::from(new);
            torn += u64::from(new > 0 && !WHOLE.contains(&raw));
        }
    }
    assert_eq!(torn, 0);
    let noticed: u32 = (bench.ring.counters().iter())
        .map(|counters| u32::from(counters.torn))
        .sum();
    assert!(noticed > 1_000, "{noticed}");
}

#[test]
fn f17_the_ready_bit_alone_does_not_prevent_torn_values() {
    let mut bus = FakeBus::new(Vcnl4020Model::default());
    let mut generator = Generator::seeded(1);
    bus.write(0x13, &[0x82, 0x06]).unwrap();
    bus.write(0x13, &[0x80, 0x03]).unwrap();
    let (mut read, mut torn) = (0_u32, 0_u32);
    while read < 200_000 {
        bus.parts_mut().queue_signals(WHOLE);
        // At a pace of its own, slower than the sensor's: a result is always ready.
        bus.advance(8_000_000 + u64::from(uniform_below(&mut generator, 8_000_000)));
        let mut command = [0];
        bus.write_read(0x13, &[0x80], &mut command).unwrap();
        assert_eq!(command[0] & 0x20, 0x20);
        let mut halves = [0; 2];
        bus.write_read(0x13, &[0x87], &mut halves).unwrap();
        read += 1;
        torn += u32::from(!WHOLE.contains(&u16::from_be_bytes(halves)));
    }
    // One byte's 22.5 us in the 8 ms of a period: 562, with a sigma of 24.
    assert!((466..=658).contains(&torn), "{torn} of {read}");
}

#[test]
fn f18_with_all_eight_missing_nothing_is_delivered() {
    let mut bench = Bench::running(1);
    for sensor in 0..SENSORS {
        bench.strike(sensor, Vcnl4020Fault::Unplugged);
    }
    let before = bench.readings();
    bench.rounds(3);
    assert_eq!(bench.states(), [SensorState::Missing; SENSORS]);
    bench.rounds(300);
    assert_eq!(bench.samples(), [Sample::Missing; SENSORS]);
    assert_eq!(bench.readings(), before);
}
