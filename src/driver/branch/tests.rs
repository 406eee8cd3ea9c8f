use embedded_hal::i2c::ErrorKind;

use super::super::fake::{Bus, NACK};
use super::super::sensor_state::{SensorFault, SensorState};
use super::super::vcnl4020::SATURATED;
use super::timing::CONFIGURING_CLOCKS;
use super::*;
use crate::driver::BusFault;
use crate::driver::pca9544a::{self, ADDRESS_AMIRO, Channel};
use crate::sensor::Sample;

/// A branch on a bus, with a round every 8 ms and the time of the bus.
struct Bench {
    /// Whether every sensor must be good at every moment.
    strict: bool,
    bus: Bus,
    branch: Branch,
    round_us: u64,
}

impl Bench {
    fn new() -> Self {
        let mut bus = Bus::new();
        for (index, part) in bus.parts.iter_mut().enumerate() {
            // Noise of two counts about a value of each sensor's own.
            let tag = 2_500 + 100 * index as u16;
            part.results = vec![tag, tag + 2, tag + 1, tag, tag + 1];
            // While the bus is idle.
            part.next_ns = 4_000_000 + 500_000 * index as u64;
        }
        Self {
            strict: false,
            bus,
            branch: Branch::new(&Channel::ALL),
            round_us: 0,
        }
    }

    /// A round, and the wait for the next one; the bus time that the round took, ns.
    fn round(&mut self) -> u64 {
        self.bus.wait_until(self.round_us);
        let began_ns = self.bus.now_ns;
        assert!(self.branch.begin_round(self.bus.now_us(), true));
        while let Some(transaction) = self.branch.next(self.bus.now_us()) {
            let result = transaction.run_on(&mut self.bus);
            if self.strict {
                assert_eq!(self.states(), [GOOD; 4], "round of {} us", self.round_us);
            }
            let answer = result.as_deref().map_err(|fault| *fault);
            self.branch.answer(self.bus.now_us(), answer);
        }
        self.round_us += ROUND_PERIOD_US;
        self.bus.now_ns - began_ns
    }

    fn rounds(&mut self, count: u32) {
        for _ in 0..count {
            self.round();
        }
    }

    /// Asks at the end of the last round.
    fn states(&self) -> [SensorState; 4] {
        Channel::ALL.map(|channel| self.branch.sensor(channel).state(self.bus.now_us()))
    }

    fn samples(&self) -> [Sample; 4] {
        Channel::ALL.map(|channel| self.branch.sensor(channel).sample(self.bus.now_us()))
    }

    fn running() -> Self {
        let mut bench = Self::new();
        bench.rounds(12);
        assert_eq!(bench.states(), [SensorState::Good; 4]);
        bench
    }
}

const MISSING: SensorState = SensorState::Missing;
const GOOD: SensorState = SensorState::Good;

#[test]
fn four_sensors_are_configured_and_trusted_within_twelve_rounds() {
    let mut bench = Bench::new();
    bench.round();
    for part in &bench.bus.parts {
        assert_eq!(part.registers[0x82..0x85], [0x06, 0x14, 0x15]);
        assert_eq!(part.registers[0x80] & 7, 7);
    }
    assert_eq!(bench.states(), [SensorState::NoData; 4]);
    bench.rounds(11);
    assert_eq!(bench.states(), [GOOD; 4]);
    for (index, sample) in bench.samples().into_iter().enumerate() {
        let Sample::Counts(counts) = sample else {
            panic!("sensor {index}: {sample:?}")
        };
        let tag = 50 + 100 * index as i32;
        assert!(
            (tag..=tag + 2).contains(&counts),
            "sensor {index}: {counts}"
        );
    }
}

#[test]
fn a_usual_round_takes_the_documented_time() {
    let mut bench = Bench::running();
    let usual_ns = u64::from(USUAL_ROUND_CLOCKS) * bench.bus.clock_ns;
    assert_eq!(USUAL_ROUND_CLOCKS, 852);
    let shortest = (0..10).map(|_| bench.round()).min();
    assert_eq!(shortest, Some(usual_ns));
}

#[test]
fn a_round_that_finds_its_sensors_reset_takes_the_documented_time() {
    // 20 + 20 to select, 39 + 39 to look, 29 + 47 + 29 to set, 20 to confirm.
    assert_eq!(CONFIGURING_CLOCKS, 243);
    let mut bench = Bench::running();
    for part in &mut bench.bus.parts {
        part.reset();
    }
    let clocks = 4 * CONFIGURING_CLOCKS;
    assert_eq!(bench.round(), u64::from(clocks) * bench.bus.clock_ns);
}

#[test]
fn the_longest_round_is_bounded_at_every_speed_of_the_bus() {
    for (bus_hz, longest_us) in [
        // Twice 1204 clocks, all before second visits are over.
        (1_000_000, 2_408),
        // Begun just before 6 ms, and 301 clocks more.
        (300_000, 6_000 + 1_004),
        // 1204 clocks take 6 ms to the microsecond: no second visit begins.
        (200_667, 6_000),
        // No bus is that slow; nothing is divided by zero.
        (0, 1_204_000_000),
    ] {
        assert_eq!(longest_round_us(bus_hz), longest_us, "{bus_hz} Hz");
    }
}

#[test]
fn no_round_at_400_khz_reaches_into_the_next() {
    assert!(longest_round_us(400_000) < ROUND_PERIOD_US);
    assert_eq!(longest_round_us(400_000), 6_020);
    assert_eq!(longest_round_us(100_000), 12_040);
    // The worst: every reading is torn, every last read-back names another channel.
    let mut bench = Bench::running();
    for part in &mut bench.bus.parts {
        part.period_ns = 100_000;
        part.results = (2_500..2_600).collect();
    }
    bench.bus.mux_fault = |bus, written| {
        bus.mux = written.unwrap_or(bus.mux);
        bus.events += 1;
        if let Some(4..) = written {
            bus.events = 0;
        }
        // After the selection: read-back, command, results, again, once more.
        if bus.events == 5 {
            bus.mux = 0;
        }
    };
    // After the third all are missing.
    for _ in 0..3 {
        let took_us = bench.round() / 1_000;
        assert!(took_us > 5_900, "{took_us} us is not the worst");
        assert!(took_us <= longest_round_us(400_000), "{took_us} us");
    }
}

#[test]
fn second_visits_do_not_begin_late() {
    let mut bench = Bench::running();
    bench.bus.parts[3].present = false;
    assert!(bench.branch.begin_round(bench.round_us, true));
    let mut visits = 0;
    let mut now_us = bench.round_us;
    while let Some(transaction) = bench.branch.next(now_us) {
        visits += u32::from(transaction.to_write() == [7]);
        let result = transaction.run_on(&mut bench.bus);
        // A slow bus: first visits end after six milliseconds.
        now_us += 300;
        let answer = result.as_deref().map_err(|fault| *fault);
        bench.branch.answer(now_us, answer);
    }
    assert_eq!(visits, 1);
    assert_eq!(bench.branch.sensor(Channel::Three).counters().failed, 1);
}

#[test]
fn a_busy_round_is_counted_and_goes_on() {
    let mut bench = Bench::running();
    assert!(bench.branch.begin_round(bench.round_us, true));
    let first = bench.branch.next(bench.round_us);
    assert!(!bench.branch.begin_round(bench.round_us, true));
    assert_eq!(bench.branch.next(bench.round_us), first);
    assert_eq!(bench.branch.counters().late, 1);
    assert_eq!(bench.branch.counters().rounds, 13);
}

#[test]
fn an_answer_that_nobody_asked_for_changes_nothing() {
    let mut bench = Bench::running();
    let before = format!("{:?}", bench.branch);
    bench.branch.answer(1, Ok(&[1, 2, 3]));
    bench.branch.answer(1, Err(BusFault::HeldLow));
    assert_eq!(format!("{:?}", bench.branch), before);
}

#[test]
fn answers_of_a_wrong_length_are_failures_and_end() {
    let mut bench = Bench::running();
    for length in [0, 1, 2, 3, 5, 16] {
        assert!(bench.branch.begin_round(0, true));
        let mut transactions = 0;
        while bench.branch.next(0).is_some() {
            bench.branch.answer(0, Ok(&[0x07; 16][..length]));
            transactions += 1;
            assert!(transactions <= 80, "{length} bytes");
        }
    }
}

#[test]
fn whatever_the_bus_answers_a_round_ends_within_eighty_transactions() {
    let mut random = Bus::new();
    let mut branch = Branch::new(&Channel::ALL);
    let rounds = if cfg!(miri) { 50 } else { 100_000 };
    for round in 0..rounds {
        let now_us = round * ROUND_PERIOD_US;
        assert!(branch.begin_round(now_us, true));
        let mut transactions = 0;
        while let Some(transaction) = branch.next(now_us) {
            // Mostly what keeps the round going: channels, identities, ready bits.
            let byte = match random.below(4) {
                0 => random.below(256) as u8,
                1 => 0x04 | random.below(4) as u8,
                2 => [0x00, 0x21, 0x87, 0xa7][random.below(4) as usize],
                _ => transaction.to_write().first().copied().unwrap_or(0x04),
            };
            let result = match random.below(40) {
                0 => Err(BusFault::NoSuchPart),
                1 => Err(BusFault::Misplaced),
                _ => Ok(vec![byte; transaction.to_read()]),
            };
            let answer = result.as_deref().map_err(|fault| *fault);
            branch.answer(now_us, answer);
            transactions += 1;
            assert!(transactions <= 80, "round {round}");
        }
    }
}

#[test]
fn f01_an_unplugged_sensor_is_missing_in_the_third_round_and_the_others_lose_nothing() {
    let mut bench = Bench::running();
    let before = bench.branch.sensor(Channel::Zero).counters().readings;
    bench.bus.parts[2].present = false;
    bench.rounds(2);
    assert_ne!(bench.states()[2], MISSING);
    bench.round();
    assert_eq!(bench.states(), [GOOD, GOOD, MISSING, GOOD]);
    assert_eq!(bench.samples()[2], Sample::Missing);
    bench.rounds(1_000);
    let after = bench.branch.sensor(Channel::Zero).counters();
    assert_eq!(u64::from(after.readings - before), 1_003);
    assert_eq!(after.failed, 0);
    // Three rounds, then once a second.
    let failed = bench.branch.sensor(Channel::Two).counters().failed;
    assert_eq!(failed, 3 + 7, "every 126 rounds of 1000");
}

#[test]
fn f01_a_sensor_that_comes_back_is_found_within_a_second_and_trusted_after_ten_readings() {
    let mut bench = Bench::running();
    bench.bus.parts[2].present = false;
    bench.rounds(10);
    bench.bus.parts[2].present = true;
    bench.bus.parts[2].reset();
    let found = (1..).find(|_| {
        bench.round();
        bench.states()[2] != MISSING
    });
    assert!(found.unwrap() <= 126, "{found:?} rounds");
    for _ in 0..9 {
        bench.round();
        assert_eq!(bench.states()[2], SensorState::NoData);
    }
    bench.rounds(2);
    assert_eq!(bench.states()[2], GOOD);
}

#[test]
fn f02_a_failure_of_any_transaction_costs_no_reading_and_no_wrong_value() {
    let kinds = [
        NACK,
        ErrorKind::ArbitrationLoss,
        ErrorKind::Bus,
        ErrorKind::NoAcknowledge(embedded_hal::i2c::NoAcknowledgeSource::Data),
    ];
    // Beyond a usual round's 24 transactions, to show that there are no more.
    for at in 0..26 {
        for kind in kinds {
            let mut bench = Bench::running();
            let readings = |bench: &Bench| {
                Channel::ALL.map(|channel| bench.branch.sensor(channel).counters().readings)
            };
            let before = readings(&bench);
            bench.bus.failing = vec![(bench.bus.transactions + at, kind)];
            bench.round();
            let one_more = before.map(|readings| readings + 1);
            assert_eq!(readings(&bench), one_more, "{kind:?} at {at}");
            for (index, sample) in bench.samples().into_iter().enumerate() {
                let Sample::Counts(counts) = sample else {
                    panic!("{kind:?} at {at}: sensor {index} is {sample:?}")
                };
                assert!((0..=2).contains(&(counts - 50 - 100 * index as i32)));
            }
        }
    }
}

#[test]
fn f03_a_held_line_ends_the_round_at_once() {
    for fault in [BusFault::HeldLow, BusFault::Overdue] {
        let mut bench = Bench::running();
        assert!(bench.branch.begin_round(bench.round_us, true));
        assert!(bench.branch.next(bench.round_us).is_some());
        bench.branch.answer(bench.round_us, Err(fault));
        assert_eq!(bench.branch.next(bench.round_us), None);
        assert_eq!(bench.branch.counters().line_failures, 1);
        for channel in Channel::ALL {
            assert_eq!(bench.branch.sensor(channel).counters().failed, 1);
        }
        // Nothing is assumed about the multiplexer afterwards.
        bench.branch.begin_round(bench.round_us, true);
        let next = bench.branch.next(bench.round_us);
        assert_eq!(next, Some(pca9544a::deselect(ADDRESS_AMIRO)));
    }
}

#[test]
fn f06_without_the_multiplexer_all_four_are_missing_after_three_rounds() {
    let mut bench = Bench::running();
    bench.bus.mux_present = false;
    bench.rounds(2);
    assert!(!bench.states().contains(&MISSING));
    bench.round();
    assert_eq!(bench.states(), [MISSING; 4]);
    // Now and then a deselection is tried, nothing else.
    let before = bench.bus.transactions;
    bench.rounds(1_250);
    assert_eq!(bench.bus.transactions - before, 9);
    bench.bus.mux_present = true;
    bench.rounds(126 + 12);
    assert_eq!(bench.states(), [GOOD; 4]);
}

#[test]
fn f06_at_boot_as_well() {
    let mut bench = Bench::new();
    bench.bus.mux_present = false;
    bench.rounds(3);
    assert_eq!(bench.states(), [MISSING; 4]);
    assert_eq!(bench.branch.counters().mux_failures, 3);
}

#[test]
fn f07_each_read_back_that_names_another_channel_is_counted() {
    let mut bench = Bench::running();
    // Takes no selection: four sensors, two visits each.
    bench.bus.mux_fault = |bus, _| bus.mux = 0;
    bench.round();
    assert_eq!(bench.branch.counters().wrong_channel, 8);
}

#[test]
fn f01_a_silent_sensor_is_visited_twice_a_round_and_once_a_second_when_it_is_missing() {
    let mut bench = Bench::running();
    bench.bus.parts[3].present = false;
    bench.bus.mux_fault = |bus, written| {
        bus.mux = written.unwrap_or(bus.mux);
        bus.events += u64::from(written == Some(7));
    };
    let mut visits = || {
        bench.bus.events = 0;
        bench.round();
        bench.bus.events
    };
    assert_eq!([(); 3].map(|()| visits()), [2, 2, 2]);
    let later: Vec<u64> = (0..1_250).map(|_| visits()).collect();
    // 10 s: nine or ten times, no second visit.
    let all: u64 = later.iter().sum();
    assert!((9..=10).contains(&all), "{all}");
    assert_eq!(later.iter().max(), Some(&1));
}

#[test]
fn f07_of_a_million_mux_faults_none_credits_a_reading_to_the_wrong_sensor() {
    let mut bench = Bench::new();
    bench.rounds(12);
    // A fault at five eighths of the selections and of 32 deselections: the write is
    // lost, hits another channel or takes effect late; the register forgets or jumps
    // later in the visit.
    bench.bus.mux_fault = |bus, written| {
        if let Some((after, mux)) = bus.jump {
            bus.jump = after.checked_sub(1).map(|after| (after, mux));
            if after == 0 {
                bus.mux = mux;
                bus.events += 1;
            }
        }
        let Some(register) = written else { return };
        bus.jump = None;
        let is_selection = register & 4 != 0;
        let kind = bus.below(if is_selection { 8 } else { 32 });
        let another = 4 | (register + 1 + bus.below(3) as u8) & 3;
        bus.mux = register;
        match kind {
            0 => bus.mux = another,
            1 => bus.mux = 0,
            2 => bus.jump = Some((bus.below(5) as u32, 0)),
            3 => bus.jump = Some((bus.below(5) as u32, another)),
            4 => {
                bus.mux = another;
                bus.jump = Some((bus.below(5) as u32, register));
            }
            _ => {}
        }
        // Deselecting, a zero is what was wanted.
        let missed = bus.mux != register;
        bus.events += u64::from(missed);
    };
    while bench.bus.events < 1_000_000 {
        bench.round();
        for (index, channel) in Channel::ALL.into_iter().enumerate() {
            let tag = 2_500 + 100 * index as u16;
            if let Some(raw) = bench.branch.sensor(channel).raw() {
                let events = bench.bus.events;
                assert!((tag..=tag + 2).contains(&raw), "{raw} after {events}");
            }
        }
    }
    let counters = Channel::ALL.map(|channel| bench.branch.sensor(channel).counters());
    for counters in counters {
        assert!(counters.discarded_for_mux > 10_000, "{counters:?}");
        assert!(counters.readings > 100_000, "{counters:?}");
    }
}

#[test]
fn f09_a_saturated_sensor_is_too_close() {
    let mut bench = Bench::running();
    bench.bus.parts[1].results = vec![SATURATED];
    bench.rounds(300);
    assert_eq!(bench.states()[1], SensorState::TooClose);
    assert_eq!(bench.samples()[1], Sample::Saturated);
}

#[test]
fn f10_a_stuck_sensor_is_stale_within_1_2_seconds_of_driving() {
    let mut bench = Bench::running();
    bench.bus.parts[1].results = vec![2_601];
    let found = (1..).find(|_| {
        bench.round();
        bench.states()[1] == SensorState::Stale
    });
    assert!((125..=150).contains(&found.unwrap()), "{found:?} rounds");
    bench.rounds(10);
    assert_eq!(bench.states(), [GOOD, SensorState::Stale, GOOD, GOOD]);
}

#[test]
fn f12_a_dazzled_sensor_says_so_in_the_next_round() {
    let mut bench = Bench::running();
    bench.bus.parts[0].ambient = 45_000;
    bench.rounds(2);
    let dazzled = SensorState::Faulty(SensorFault::Dazzled);
    assert_eq!(bench.states(), [dazzled, GOOD, GOOD, GOOD]);
}

#[test]
fn f14_garbage_is_left_out_within_two_seconds() {
    let mut bench = Bench::running();
    let garbage = (0..997).map(|_| bench.bus.below(65_536) as u16).collect();
    bench.bus.parts[3].results = garbage;
    bench.rounds(250);
    let found = SensorState::Faulty(SensorFault::Garbage);
    assert_eq!(bench.states(), [GOOD, GOOD, GOOD, found]);
    assert_eq!(bench.samples()[3], Sample::Missing);
}

#[test]
fn f15_sensors_a_little_slow_or_fast_never_go_stale() {
    for period_ns in [7_600_000, 7_990_000, 8_000_000, 8_010_000, 8_400_000] {
        let mut bench = Bench::new();
        for part in &mut bench.bus.parts {
            part.period_ns = period_ns;
        }
        bench.rounds(15);
        // At every moment, not only when all was read.
        bench.strict = true;
        bench.rounds(if cfg!(miri) { 20 } else { 5_000 });
    }
}

#[test]
fn f15_a_sensor_that_ceases_to_measure_is_stale_after_16_ms() {
    let mut bench = Bench::running();
    bench.bus.parts[1].period_ns = u64::MAX / 4;
    bench.rounds(5);
    assert_eq!(bench.states(), [GOOD, SensorState::Stale, GOOD, GOOD]);
    assert_eq!(bench.samples()[1], Sample::Missing);
}

#[test]
fn f16_a_reset_sensor_delivers_again_two_rounds_later() {
    let mut bench = Bench::running();
    bench.bus.parts[1].reset();
    bench.round();
    assert_eq!(bench.states(), [GOOD, SensorState::NoData, GOOD, GOOD]);
    bench.rounds(2);
    assert_eq!(bench.states(), [GOOD; 4]);
    assert_eq!(bench.branch.sensor(Channel::One).counters().resets, 1);
    assert_eq!(bench.bus.parts[1].registers[0x82..0x85], [0x06, 0x14, 0x15]);
}

#[test]
fn f16_a_stranger_is_never_written_to() {
    let mut bench = Bench::new();
    bench.bus.parts[1].registers[0x81] = 0x32;
    bench.rounds(300);
    let stranger = SensorState::Faulty(SensorFault::WrongIdentity);
    assert_eq!(bench.states(), [GOOD, stranger, GOOD, GOOD]);
    assert_eq!(bench.bus.parts[1].registers[0x80], 0x80);
    // It was exchanged for a sensor.
    bench.bus.parts[1].registers[0x81] = 0x21;
    bench.rounds(126 + 12);
    assert_eq!(bench.states(), [GOOD; 4]);
}

#[test]
fn f17_of_a_million_random_update_phases_none_gives_a_torn_value() {
    let mut bench = Bench::new();
    // Each mixture of these bytes is another number.
    for part in &mut bench.bus.parts {
        part.results = vec![0x0aff, 0x0b00];
    }
    bench.rounds(12);
    for round in 0..250_000 {
        for index in 0..4 {
            let jitter = bench.bus.below(8_000_000);
            let part = &mut bench.bus.parts[index];
            part.next_ns = bench.round_us * 1_000 + jitter;
        }
        bench.round();
        for channel in Channel::ALL {
            let raw = bench.branch.sensor(channel).raw();
            assert!(matches!(raw, Some(0x0aff | 0x0b00)), "{raw:?} in {round}");
        }
    }
    let torn: u32 = Channel::ALL
        .map(|channel| u32::from(bench.branch.sensor(channel).counters().torn))
        .iter()
        .sum();
    assert!(torn > 1_000, "{torn}");
}

#[test]
fn only_the_channels_in_use_are_visited() {
    let mut bench = Bench::new();
    bench.branch = Branch::new(&[Channel::Two]);
    bench.rounds(12);
    let none = SensorState::NoData;
    assert_eq!(bench.states(), [none, none, GOOD, none]);
    assert_eq!(bench.bus.parts[0].registers[0x80], 0x80);
}

#[test]
fn a_waiting_bus_runs_the_same_round() {
    let mut bus = Bus::new();
    let mut branch = Branch::new(&Channel::ALL);
    for round in 0..12 {
        let now_us = round * ROUND_PERIOD_US;
        bus.wait_until(now_us);
        assert!(branch.poll(&mut bus, now_us, false));
    }
    for channel in Channel::ALL {
        assert_eq!(branch.sensor(channel).sample(90_000), Sample::Counts(0));
    }
}
