//! Rounds: their duration, the sensors that they read, and what the ring keeps.

use amiro_ipf::board::acquisition::{AMIRO_CONNECTIONS, BUSES, Bus, ProximityRing};
use amiro_ipf::board::i2c::muxed_bus::{ROUND_PERIOD_US, USUAL_ROUND_CLOCKS, longest_round_us};
use amiro_ipf::board::sensor_state::SensorState;
use amiro_ipf::model::{SENSORS, Sample};
use sim_harness::bus::{InjectedBusFault, MuxFault, Vcnl4020Fault};

use super::at_every_byte;
use super::bench::{Bench, execute};

/// Clocks of the next round on each bus.
fn clocks_of_round(bench: &mut Bench) -> [u32; 2] {
    let mut clocks = [0; 2];
    bench.round_with(true, |_, number, transaction| {
        clocks[number] += transaction.clocks();
    });
    clocks
}

#[test]
fn a_usual_round_takes_the_documented_time() {
    let mut bench = Bench::running(1);
    assert_eq!(clocks_of_round(&mut bench), [USUAL_ROUND_CLOCKS; 2]);
}

#[test]
fn a_round_that_finds_its_sensors_reset_takes_the_documented_time() {
    let mut bench = Bench::running(1);
    (0..SENSORS).for_each(|sensor| bench.strike(sensor, Vcnl4020Fault::Reset));
    // All faults are due at the first byte.
    assert_eq!(clocks_of_round(&mut bench), [4 * 243; 2]);
    for sensor in 0..SENSORS {
        let part = bench.buses.sensor_mut(sensor);
        let configured = [0x82, 0x83, 0x84].map(|register| part.register(register));
        assert_eq!(configured, [0x06, 0x14, 0x15], "sensor {sensor}");
        assert_eq!(part.register(0x80) & 7, 7, "sensor {sensor}");
    }
}

#[test]
fn no_round_at_400_khz_reaches_into_the_next() {
    // The worst: every reading is torn, every last read-back names another channel.
    let mut bench = Bench::running(1);
    for sensor in 0..SENSORS {
        bench.buses.sensor_mut(sensor).queue_signals(2_500..2_600);
    }
    // After the third all are missing.
    for _ in 0..3 {
        let mut clocks = [0; 2];
        let mut channel = 0;
        let mut is_read = false;
        bench.round_with(true, |buses, number, transaction| {
            clocks[number] += transaction.clocks();
            let bus = buses.bus_mut(number);
            let (now_ns, script) = (bus.now_ns(), &mut bus.script);
            match (transaction.address(), transaction.to_write()) {
                (0x77, [control]) if control & 4 != 0 => {
                    channel = control & 3;
                    is_read = false;
                }
                (0x77, []) if is_read => {
                    script.from_time(now_ns, InjectedBusFault::Mux(MuxFault::Reset))
                }
                // A result is ready, and another one comes before each reading of it.
                (0x13, [register @ (0x80 | 0x87)]) => {
                    is_read = *register == 0x87;
                    let fault = Vcnl4020Fault::Measures;
                    script.from_time(now_ns, InjectedBusFault::Sensor { channel, fault });
                }
                _ => {}
            }
        });
        for clocks in clocks {
            let took_us = u64::from(clocks) * 5 / 2;
            assert!(took_us > 5_900, "{took_us} us is not the worst");
            assert!(took_us <= longest_round_us(400_000), "{took_us} us");
        }
    }
    assert!(longest_round_us(400_000) < ROUND_PERIOD_US);
}

#[test]
fn second_readouts_do_not_begin_late() {
    let mut bench = Bench::running(1);
    // On the second bus, channel 3.
    bench.strike(5, Vcnl4020Fault::Unplugged);
    let mut now_us = bench.next_round_us();
    let muxed = bench.ring.bus_mut(Bus::I2c2);
    let bus = bench.buses.bus_mut(1);
    bus.advance_to(now_us * 1_000);
    assert!(muxed.begin_round(now_us, true));
    let mut readouts = 0;
    while let Some(transaction) = muxed.next(now_us) {
        readouts += u32::from(transaction.to_write() == [7]);
        // A slow bus: first readouts end after six milliseconds.
        now_us += 300;
        execute(muxed, bus, &transaction, now_us);
    }
    assert_eq!(readouts, 1);
    assert_eq!(bench.ring.counters()[5].failed, 1);
}

#[test]
fn f01_a_silent_sensor_is_tried_twice_per_round_and_once_per_second_when_it_is_missing() {
    let mut bench = Bench::running(1);
    bench.strike(5, Vcnl4020Fault::Unplugged);
    let mut readouts = || {
        let mut readouts = 0;
        bench.round_with(true, |_, number, transaction| {
            readouts += u32::from(number == 1 && transaction.to_write() == [7]);
        });
        readouts
    };
    assert_eq!([(); 3].map(|()| readouts()), [2, 2, 2]);
    let later: Vec<u32> = (0..1_250).map(|_| readouts()).collect();
    // 10 s: nine or ten times, no second readout.
    let all: u32 = later.iter().sum();
    assert!((9..=10).contains(&all), "{all}");
    assert_eq!(later.iter().max(), Some(&1));
}

/// A running bench whose sensors measure while the buses are idle, at first; their clocks
/// are slower by so many millionths.
fn measuring_between_rounds(error_ppm: i32) -> Bench {
    let mut bench = Bench::new(2);
    for sensor in 0..SENSORS {
        bench.buses.sensor_mut(sensor).set_clock_error(error_ppm);
    }
    bench.rounds(16);
    for (sensor, place) in AMIRO_CONNECTIONS.into_iter().enumerate() {
        let after_ns = 4_000_000 + 500_000 * u64::from(place.channel.number());
        let at_ns = bench.next_round_us() * 1_000 + after_ns;
        bench.buses.sensor_mut(sensor).measure_next_at(at_ns);
    }
    // The delayed measurement is read.
    bench.rounds(2);
    bench
}

#[test]
fn f02_a_refusal_or_lost_arbitration_at_any_byte_costs_no_reading() {
    let expected = measuring_between_rounds(0).readings();
    let expected = expected.map(|readings| readings + 4);
    for fault in [
        InjectedBusFault::NoAcknowledge,
        InjectedBusFault::ArbitrationLost,
    ] {
        at_every_byte(
            || measuring_between_rounds(0),
            fault,
            |bench, story| {
                bench.rounds(4);
                assert_eq!(bench.readings(), expected, "{story}");
            },
        );
    }
}

/// A round in which each reading is stamped with the time of its own bus; `check` is
/// called with that time after each transaction.
fn timed_round(bench: &mut Bench, round_us: u64, check: impl Fn(&ProximityRing, Bus, u64)) {
    bench.buses.advance_to(round_us * 1_000);
    for (number, bus) in BUSES.into_iter().enumerate() {
        let wire = bench.buses.bus_mut(number);
        let now_us = |now_ns: u64| now_ns / 1_000;
        let begins_us = now_us(wire.now_ns());
        bench.ring.bus_mut(bus).begin_round(begins_us, true);
        loop {
            let muxed = bench.ring.bus_mut(bus);
            let Some(transaction) = muxed.next(now_us(wire.now_ns())) else {
                break;
            };
            let result = wire.run(&transaction);
            let after_us = now_us(wire.now_ns());
            check(&bench.ring, bus, after_us);
            let result = result.as_deref().map_err(|error| (*error).into());
            bench.ring.bus_mut(bus).answer(after_us, result);
        }
    }
}

#[test]
fn f15_sensors_a_little_slow_or_fast_are_good_at_every_moment_of_a_round() {
    for error_ppm in [-50_000, -1_250, 0, 1_250, 50_000] {
        let mut bench = measuring_between_rounds(error_ppm);
        let first_us = bench.next_round_us();
        for round in 0..2_000 {
            bench.set_tags();
            timed_round(
                &mut bench,
                first_us + round * ROUND_PERIOD_US,
                |ring, bus, now_us| {
                    let states = ring.states(now_us);
                    for (sensor, place) in AMIRO_CONNECTIONS.into_iter().enumerate() {
                        let is_good = place.bus != bus || states[sensor] == SensorState::Good;
                        assert!(is_good, "{error_ppm} ppm: sensor {sensor} in round {round}");
                    }
                },
            );
        }
    }
}

/// A bench without noise whose sensors measure 2450 and the tenfold of their index.
fn steady(ring: ProximityRing, rounds: u64) -> Bench {
    let mut bench = Bench::new(1);
    bench.ring = ring;
    for sensor in 0..SENSORS {
        bench.buses.set_signal(sensor, 2_450 + 10 * sensor as u16);
    }
    (0..rounds).for_each(|_| bench.round_as_it_is(false));
    bench
}

#[test]
fn offsets_belong_to_their_sensors() {
    let mut ring = ProximityRing::new();
    ring.set_offsets(core::array::from_fn(|index| 2_400 + 10 * index as u16));
    let bench = steady(ring, 13);
    assert_eq!(bench.samples(), [Sample::Counts(50); SENSORS]);
}

#[test]
fn raw_values_have_the_sensors_index_and_only_trusted_ones_are_for_calibration() {
    let bench = steady(ProximityRing::new(), 5);
    assert_eq!(bench.ring.raw(3), Some(2_480));
    assert_eq!(bench.ring.raw(8), None);
    assert_eq!(bench.ring.trusted_raw(bench.now_us()), [None; SENSORS]);
    let bench = steady(ProximityRing::new(), 30);
    let now_us = bench.now_us();
    let expected = core::array::from_fn(|sensor| Some(2_450 + 10 * sensor as u16));
    assert_eq!(bench.ring.trusted_raw(now_us), expected);
    assert_eq!(bench.ring.trusted_raw(now_us + 16_001), [None; SENSORS]);
}
