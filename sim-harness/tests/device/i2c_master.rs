//! The flash image's I2C master at a model of the silicon's registers.
//!
//! Names that begin with f02 to f05 are entries of the fault catalogue. What the
//! silicon itself does with a shorted wire is not shown here.

use std::cell::RefCell;
use std::rc::Rc;

use amiro_ipf::board::i2c::{
    self, BusFault, BusLine, BusTransaction, I2cMaster, I2cRegister, I2cRegisters, I2cTiming,
    LONGEST_READ, LONGEST_WRITE, TransferProgress,
};

use sim_harness::bus::{At24c01Model, Pca9544aModel, Vcnl4020Model};

use crate::i2c_model::{Bench, FOR_EVER, Fault, POLL_NS, Part, Seen, Stuck};

const ADDRESS: u8 = 0x13;

fn bytes(length: usize) -> Vec<u8> {
    (0..length).map(|index| 0x80 + index as u8).collect()
}

fn answer(length: usize) -> Vec<u8> {
    (0..length as u8).map(Part::byte).collect()
}

fn transaction(write: usize, read: usize) -> BusTransaction {
    BusTransaction::new(ADDRESS, &bytes(write), read as u8)
}

/// What a part sees of a transaction that nothing disturbs.
fn seen(write: usize, read: usize) -> Vec<Seen> {
    let mut seen = Vec::new();
    if write > 0 || read == 0 {
        seen.push(Seen::Address { read: false });
        seen.extend(bytes(write).into_iter().map(Seen::Written));
    }
    if read > 0 {
        seen.push(Seen::Address { read: true });
        seen.extend(answer(read).into_iter().map(Seen::Read));
    }
    seen.push(Seen::Stop);
    seen
}

/// What a part has seen since, without the stop of a recovery that came first.
fn seen_after_recovery(part: &Part) -> Vec<Seen> {
    let mut seen = part.take_seen();
    if seen.first() == Some(&Seen::Stop) {
        seen.remove(0);
    }
    seen
}

/// Every length of writing with every length of reading.
fn shapes() -> impl Iterator<Item = (usize, usize)> {
    (0..=LONGEST_WRITE).flat_map(|write| (0..=LONGEST_READ).map(move |read| (write, read)))
}

/// Addresses and bytes of a transaction.
fn on_the_wire(write: usize, read: usize) -> usize {
    let addresses = 1 + usize::from(write > 0 && read > 0);
    addresses + write + read
}

/// A transaction of every shape on a bench, to which something is done before each.
fn all_shapes_arrive(bench: &mut Bench, part: &Part, story: &str) {
    for (write, read) in shapes() {
        let result = bench.run(&transaction(write, read));
        assert_eq!(result, Ok(answer(read)), "{story}: {write} + {read}");
        assert_eq!(
            part.take_seen(),
            seen(write, read),
            "{story}: {write} + {read}"
        );
        let unit = bench.unit.borrow();
        assert_eq!(unit.wrongs, [""; 0], "{story}: {write} + {read}");
        assert!(unit.is_idle(), "{story}: {write} + {read}");
    }
}

#[test]
fn every_shape_arrives_whole() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 1);
    all_shapes_arrive(&mut bench, &part, "in time");
    assert_eq!(*bench.master.counters(), i2c::MasterCounters::default());
}

#[test]
fn late_interrupts_lose_no_byte() {
    for seed in 1..=5 {
        let part = Part::at(ADDRESS);
        let mut bench = Bench::new(part.clone(), seed);
        bench.lateness_ns = 12_000;
        bench.unit.borrow_mut().interruption_ns = 8_000;
        all_shapes_arrive(&mut bench, &part, &format!("seed {seed}"));
        assert_eq!(bench.master.counters().overdue, 0, "seed {seed}");
    }
}

#[test]
fn any_one_interrupt_may_be_300_us_late() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 1);
    for (write, read) in shapes() {
        bench.late_call = None;
        assert!(bench.run(&transaction(write, read)).is_ok());
        part.take_seen();
        for call in 1..=bench.calls {
            bench.late_call = Some((call, 300_000));
            let result = bench.run(&transaction(write, read));
            let story = format!("{write} + {read}, call {call}");
            assert_eq!(result, Ok(answer(read)), "{story}");
            assert_eq!(part.take_seen(), seen(write, read), "{story}");
            assert_eq!(bench.unit.borrow().wrongs, [""; 0], "{story}");
        }
    }
}

/// The three sequences that go through `without_interrupts` need it: with interruptions inside
/// them the model shows a lost or doubled byte.
#[test]
fn reads_go_wrong_where_interrupts_come_between() {
    for read in [1, 2, 5] {
        let part = Part::at(ADDRESS);
        let mut bench = Bench::new(part.clone(), 7);
        bench.unit.borrow_mut().interruption_ns = 60_000;
        bench.unit.borrow_mut().masks = false;
        let good = (0..200)
            .filter(|_| {
                let right = bench.run(&transaction(0, read)) == Ok(answer(read));
                right && part.take_seen() == seen(0, read)
            })
            .count();
        assert!((1..200).contains(&good), "{read} bytes: {good} of 200");
    }
}

#[test]
fn a_transaction_lasts_its_bits_and_a_little() {
    let mut bench = Bench::new(Part::at(ADDRESS), 1);
    for (write, read) in shapes() {
        let begun_ns = bench.now_ns();
        assert!(bench.run(&transaction(write, read)).is_ok());
        let lasted_ns = bench.now_ns() - begun_ns;
        // Nine bits each, a start or two, a stop.
        let bits = 9 * on_the_wire(write, read) as u64 + 5;
        let calls_ns = 500 * u64::from(bench.calls);
        assert!(
            (bits * 2500 - 10_000..bits * 2500 + calls_ns + 2000).contains(&lasted_ns),
            "{write} + {read}: {lasted_ns} ns for {bits} bits, {} calls",
            bench.calls
        );
        // One a byte, one a start, one an address; more only for a repeated start.
        let least = on_the_wire(write, read) as u32 + 1;
        assert!(
            bench.calls <= least + 9,
            "{write} + {read}: {} calls",
            bench.calls
        );
    }
    assert!(bench.longest_call_ns <= 10_000, "{}", bench.longest_call_ns);
}

#[test]
fn the_robots_parts_understand_the_master() {
    let sensors = std::array::from_fn(|_| Vcnl4020Model::default());
    let mut bench = Bench::new(Pca9544aModel::new(0x77, sensors), 12);
    bench.lateness_ns = 10_000;
    // Nobody behind the mux until a channel is selected; it reads back.
    let product = BusTransaction::new(0x13, &[0x81], 1);
    assert_eq!(bench.run(&product), Err(BusFault::NoSuchPart));
    for channel in 0..4 {
        let select = BusTransaction::new(0x77, &[4 | channel], 0);
        assert_eq!(bench.run(&select), Ok(vec![]));
        let back = bench.run(&BusTransaction::new(0x77, &[], 1));
        assert_eq!(back.map(|control| control[0] & 7), Ok(4 | channel));
        // Product 2, revision 1.
        assert_eq!(bench.run(&product), Ok(vec![0x21]));
    }
}

#[test]
fn a_memory_keeps_a_page_that_the_master_wrote() {
    let mut bench = Bench::new(At24c01Model::new(0x50), 13);
    let page = [0x18, 1, 2, 3, 4, 5, 6, 7, 8];
    assert_eq!(bench.run(&BusTransaction::new(0x50, &page, 0)), Ok(vec![]));
    // Deaf while it writes.
    let look = BusTransaction::new(0x50, &[0x18], 8);
    assert_eq!(bench.run(&look), Err(BusFault::NoSuchPart));
    let done_ns = bench.now_ns() + 10_000_000;
    bench.idle_until(done_ns);
    assert_eq!(bench.run(&look), Ok(page[1..].to_vec()));
}

#[test]
fn a_second_transaction_is_refused() {
    let mut bench = Bench::new(Part::at(ADDRESS), 1);
    assert_eq!(
        bench.master.begin(&transaction(1, 0), 0),
        TransferProgress::Running
    );
    assert_eq!(
        bench.master.begin(&transaction(1, 0), 0),
        TransferProgress::Refused
    );
}

#[test]
fn f02_a_refusal_at_any_byte_ends_the_transaction_and_frees_the_bus() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 2);
    bench.lateness_ns = 10_000;
    let mut refusals = 0;
    for (write, read) in shapes() {
        // What the part acknowledges: addresses and bytes written.
        for byte in 0..on_the_wire(write, read) - read {
            let story = format!("{write} + {read}, byte {byte}");
            part.refuse_after(byte);
            let fault = match byte {
                0 => BusFault::NoSuchPart,
                _ if byte == write + 1 => BusFault::NoSuchPart,
                _ => BusFault::RefusedByte,
            };
            assert_eq!(bench.run(&transaction(write, read)), Err(fault), "{story}");
            refusals += 1;
            assert!(bench.unit.borrow().is_idle(), "{story}");
            if byte > 0 && fault == BusFault::RefusedByte {
                assert_eq!(part.take_seen().last(), Some(&Seen::Stop), "{story}");
            }
            part.take_seen();
            assert_eq!(bench.run(&transaction(write, read)), Ok(answer(read)));
            assert_eq!(part.take_seen(), seen(write, read), "after {story}");
        }
    }
    let counters = i2c::MasterCounters {
        nacks: refusals,
        ..i2c::MasterCounters::default()
    };
    assert_eq!(*bench.master.counters(), counters);
    assert_eq!(bench.unit.borrow().wrongs, [""; 0]);
}

#[test]
fn f02_an_absent_part_differs_from_a_present_one() {
    let mut bench = Bench::new(Part::at(ADDRESS), 2);
    let absent = BusTransaction::new(ADDRESS + 1, &[], 0);
    assert_eq!(bench.run(&absent), Err(BusFault::NoSuchPart));
    assert_eq!(bench.run(&transaction(0, 0)), Ok(vec![]));
}

#[test]
fn f02_arbitration_lost_at_any_byte_ends_the_transaction() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 3);
    bench.lateness_ns = 10_000;
    let mut losses = 0;
    for (write, read) in shapes() {
        for byte in 0..on_the_wire(write, read) {
            let story = format!("{write} + {read}, byte {byte}");
            let fault = Fault::ArbitrationLost;
            bench.unit.borrow_mut().strike(byte, fault);
            let result = bench.run(&transaction(write, read));
            assert_eq!(result, Err(BusFault::ArbitrationLost), "{story}");
            losses += 1;
            part.take_seen();
            let result = bench.run(&transaction(write, read));
            assert_eq!(result, Ok(answer(read)), "after {story}");
            assert_eq!(seen_after_recovery(&part), seen(write, read), "{story}");
        }
    }
    // Nobody made a stop: the bus is freed by hand before the next start.
    let counters = i2c::MasterCounters {
        arbitration: losses,
        recoveries: losses,
        ..i2c::MasterCounters::default()
    };
    assert_eq!(*bench.master.counters(), counters);
    assert_eq!(bench.unit.borrow().wrongs, [""; 0]);
}

#[test]
fn f02_a_bus_error_that_is_none_ends_nothing() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 4);
    bench.lateness_ns = 10_000;
    let mut errors = 0;
    for (write, read) in shapes() {
        for byte in 0..on_the_wire(write, read) {
            let story = format!("{write} + {read}, byte {byte}");
            bench
                .unit
                .borrow_mut()
                .strike(byte, Fault::SpuriousBusError);
            let result = bench.run(&transaction(write, read));
            assert_eq!(result, Ok(answer(read)), "{story}");
            assert_eq!(part.take_seen(), seen(write, read), "{story}");
            errors += 1;
        }
    }
    assert_eq!(bench.master.counters().bus_errors, errors);
    assert_eq!(bench.master.counters().recoveries, 0);
}

#[test]
fn f02_an_error_that_comes_while_another_is_served_is_not_cleared() {
    const BERR: u16 = 1 << 8;
    const AF: u16 = 1 << 10;
    let frozen = Frozen {
        status: BERR,
        pins: true,
        ..Frozen::default()
    };
    let written = frozen.written.clone();
    let mut master = I2cMaster::new(frozen, I2cTiming::fast(42_000_000), 0);
    assert_eq!(
        master.begin(&transaction(1, 4), 0),
        TransferProgress::Running
    );
    assert_eq!(master.on_error(1), TransferProgress::Running);
    // Writing zero clears a flag.
    let last = written.borrow().last().copied();
    let (register, value) = last.unwrap();
    assert_eq!(register, I2cRegister::Sr1);
    assert_eq!(value & (BERR | AF), AF);
}

#[test]
fn f02_counters_stay_at_their_greatest_value() {
    let mut bench = Bench::new(Part::at(ADDRESS), 2);
    let absent = BusTransaction::new(ADDRESS + 1, &[], 0);
    for _ in 0..=u32::from(u16::MAX) {
        assert_eq!(bench.run(&absent), Err(BusFault::NoSuchPart));
    }
    assert_eq!(bench.master.counters().nacks, u16::MAX);
}

/// From the fault to its detection.
const DETECT_NS: u64 = 1_000_000;

/// Half clocks of 2.5 us in 2 ms.
const RECOVERY_HALF_CLOCKS: u32 = 800;

#[test]
fn f03_a_part_that_holds_sda_at_any_byte_is_clocked_free() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 5);
    let mut longest_ns = 0;
    for (write, read) in shapes() {
        for byte in 0..on_the_wire(write, read) {
            for clocks in [1, 5, 9] {
                let story = format!("{write} + {read}, byte {byte}, {clocks} clocks");
                bench.unit.borrow_mut().half_clocks = 0;
                bench.unit.borrow_mut().strike(byte, Fault::DataLow(clocks));
                let result = bench.run(&transaction(write, read));
                assert!(
                    matches!(result, Err(BusFault::Overdue | BusFault::ArbitrationLost)),
                    "{story}: {result:?}"
                );
                let by_hand_ns = 2500 * u64::from(bench.unit.borrow().half_clocks);
                let ended_ns = bench.now_ns() - bench.unit.borrow().struck_ns;
                longest_ns = longest_ns.max(ended_ns - by_hand_ns);
                assert!(!bench.master.is_held_low(), "{story}");
                part.take_seen();
                let result = bench.run(&transaction(write, read));
                assert_eq!(result, Ok(answer(read)), "after {story}");
                assert_eq!(seen_after_recovery(&part), seen(write, read), "{story}");
                let half_clocks = bench.unit.borrow().half_clocks;
                assert!(
                    half_clocks <= RECOVERY_HALF_CLOCKS,
                    "{story}: {half_clocks}"
                );
            }
        }
    }
    assert!(longest_ns <= DETECT_NS, "{longest_ns} ns");
    assert_eq!(bench.unit.borrow().wrongs, [""; 0]);
}

#[test]
fn f03_the_start_frees_a_bus_that_a_reset_left_in_mid_byte() {
    for clocks in 1..=9 {
        let part = Part::at(ADDRESS);
        let mut bench = Bench::after(part, 5, |unit| unit.data_held = clocks);
        assert!(!bench.master.is_held_low(), "{clocks} clocks");
        assert_eq!(bench.run(&transaction(1, 4)), Ok(answer(4)));
        assert_eq!(*bench.master.counters(), i2c::MasterCounters::default());
    }
}

/// When the bus was tried to be freed while nothing else went on, milliseconds.
fn attempts_ms(bench: &mut Bench, end_ms: u64) -> Vec<u64> {
    let mut attempts = Vec::new();
    let mut before = bench.master.counters().recoveries;
    while bench.now_ns() < end_ms * 1_000_000 {
        let next_ns = bench.now_ns() + POLL_NS;
        bench.idle_until(next_ns);
        let now = bench.master.counters().recoveries;
        if now != before {
            attempts.push(bench.now_ns() / 1_000_000);
            before = now;
        }
    }
    attempts
}

#[test]
fn f03_a_dead_bus_is_tried_again_after_10_ms_doubling_to_1_s() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::after(part.clone(), 6, |unit| unit.data_held = FOR_EVER);
    assert!(bench.master.is_held_low());
    let attempts = attempts_ms(&mut bench, 4_000);
    let waits: Vec<u64> = [0]
        .iter()
        .chain(&attempts)
        .zip(&attempts)
        .map(|(before, after)| after - before)
        .collect();
    let nominal = [10, 20, 40, 80, 160, 320, 640, 1000, 1000];
    assert_eq!(waits.len(), nominal.len(), "{waits:?}");
    for (wait, nominal) in waits.iter().zip(nominal) {
        // A poll late, and whole milliseconds.
        assert!((nominal..=nominal + 2).contains(wait), "{waits:?}");
    }
    // Meanwhile nobody waits for it.
    let before_ns = bench.now_ns();
    assert_eq!(bench.run(&transaction(1, 4)), Err(BusFault::HeldLow));
    assert_eq!(bench.now_ns() - before_ns, 60);
    // Let go, it is found alive by itself; the next fault begins with the short wait.
    bench.unit.borrow_mut().data_held = 0;
    attempts_ms(&mut bench, 5_500);
    assert!(!bench.master.is_held_low());
    assert_eq!(bench.run(&transaction(1, 4)), Ok(answer(4)));
    bench.unit.borrow_mut().data_held = FOR_EVER;
    assert_eq!(bench.run(&transaction(1, 4)), Err(BusFault::HeldLow));
    let dead_ms = bench.now_ns() / 1_000_000;
    let attempts = attempts_ms(&mut bench, dead_ms + 15);
    assert_eq!(attempts.len(), 1);
    assert!((10..=12).contains(&(attempts[0] - dead_ms)), "{attempts:?}");
}

#[test]
fn f03_the_other_bus_bears_a_recovery() {
    // What one bus costs the other is the longest call, for they share a priority.
    let mut faulty_bench = Bench::new(Part::at(ADDRESS), 7);
    faulty_bench
        .unit
        .borrow_mut()
        .strike(2, Fault::DataLow(FOR_EVER));
    assert_eq!(faulty_bench.run(&transaction(0, 4)), Err(BusFault::HeldLow));
    let sick_ns = faulty_bench.longest_call_ns;
    assert!((50_000..150_000).contains(&sick_ns), "{sick_ns} ns");
    let part = Part::at(ADDRESS);
    let mut well = Bench::new(part.clone(), 7);
    for call in 1..=20 {
        well.late_call = Some((call, sick_ns));
        assert_eq!(well.run(&transaction(1, 4)), Ok(answer(4)), "call {call}");
        assert_eq!(part.take_seen(), seen(1, 4), "call {call}");
    }
    assert_eq!(*well.master.counters(), i2c::MasterCounters::default());
}

#[test]
fn f04_scl_held_low_at_any_byte_makes_the_bus_dead_within_a_millisecond() {
    for (write, read) in [(0, 0), (0, 1), (0, 2), (0, 3), (1, 4), (9, 0), (9, 16)] {
        for byte in 0..on_the_wire(write, read) {
            let story = format!("{write} + {read}, byte {byte}");
            let part = Part::at(ADDRESS);
            let mut bench = Bench::new(part.clone(), 8);
            bench.unit.borrow_mut().strike(byte, Fault::ClockLow);
            let half_clocks = bench.unit.borrow().half_clocks;
            let result = bench.run(&transaction(write, read));
            assert_eq!(result, Err(BusFault::HeldLow), "{story}");
            let ended_ns = bench.now_ns() - bench.unit.borrow().struck_ns;
            assert!(ended_ns <= DETECT_NS, "{story}: {ended_ns} ns");
            let half_clocks = bench.unit.borrow().half_clocks - half_clocks;
            assert!(half_clocks <= RECOVERY_HALF_CLOCKS, "{story}");
            assert!(bench.master.is_held_low(), "{story}");
            assert_eq!(bench.master.counters().overdue, 1, "{story}");
            // Let go, it is back after the first wait.
            bench.unit.borrow_mut().clock_held = false;
            let back_ns = bench.now_ns() + 11_000_000;
            bench.idle_until(back_ns);
            part.take_seen();
            let result = bench.run(&transaction(write, read));
            assert_eq!(result, Ok(answer(read)), "after {story}");
            assert_eq!(part.take_seen(), seen(write, read), "after {story}");
        }
    }
}

#[test]
fn f05_a_busy_flag_that_is_stuck_costs_no_transaction() {
    for stuck in [Stuck::Busy, Stuck::Filter] {
        let mut bench = Bench::new(Part::at(ADDRESS), 9);
        for round in 1..=3 {
            bench.unit.borrow_mut().stuck = stuck;
            bench.unit.borrow_mut().half_clocks = 0;
            let result = bench.run(&transaction(1, 4));
            assert_eq!(result, Ok(answer(4)), "{stuck:?}");
            assert_eq!(bench.master.counters().recoveries, round, "{stuck:?}");
            assert!(bench.unit.borrow().half_clocks <= 10, "{stuck:?}");
        }
        assert_eq!(bench.unit.borrow().wrongs, [""; 0]);
    }
}

#[test]
fn f05_a_refused_start_costs_one_transaction_and_a_millisecond() {
    let mut bench = Bench::new(Part::at(ADDRESS), 10);
    for round in 1..=3 {
        bench.unit.borrow_mut().stuck = Stuck::Start;
        let begun_ns = bench.now_ns();
        assert_eq!(bench.run(&transaction(1, 4)), Err(BusFault::Overdue));
        assert!(bench.now_ns() - begun_ns <= DETECT_NS);
        assert_eq!(bench.master.counters().overdue, round);
        assert_eq!(bench.master.counters().recoveries, round);
        assert_eq!(bench.run(&transaction(1, 4)), Ok(answer(4)));
    }
}

#[test]
fn f05_a_stuck_unit_is_well_after_the_start() {
    for stuck in [Stuck::Busy, Stuck::Filter, Stuck::Start] {
        let part = Part::at(ADDRESS);
        let mut bench = Bench::after(part, 11, |unit| unit.stuck = stuck);
        assert_eq!(bench.run(&transaction(1, 4)), Ok(answer(4)), "{stuck:?}");
    }
}

/// A machine whose status never changes, and what was written to it.
#[derive(Default)]
struct Frozen {
    status: u16,
    pins: bool,
    written: Rc<RefCell<Vec<(I2cRegister, u16)>>>,
    half_clocks: Rc<RefCell<u32>>,
}

impl I2cRegisters for Frozen {
    fn read(&mut self, register: I2cRegister) -> u16 {
        match register {
            I2cRegister::Sr1 => self.status,
            _ => 0,
        }
    }

    fn write(&mut self, register: I2cRegister, value: u16) {
        self.written.borrow_mut().push((register, value));
    }

    fn take_pins(&mut self) {}

    fn return_pins(&mut self) {}

    fn pull(&mut self, _: BusLine) {}

    fn release(&mut self, _: BusLine) {}

    fn is_high(&mut self, _: BusLine) -> bool {
        self.pins
    }

    fn wait_half_clock(&mut self) {
        *self.half_clocks.borrow_mut() += 1;
    }

    fn without_interrupts<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        work(self)
    }
}

#[test]
fn f04_a_machine_without_the_unit_is_a_dead_bus() {
    let frozen = Frozen::default();
    let half_clocks = frozen.half_clocks.clone();
    let mut master = I2cMaster::new(frozen, I2cTiming::fast(42_000_000), 0);
    let mut now_us = 0;
    for _ in 0..10_000 {
        assert_eq!(
            master.begin(&transaction(1, 4), now_us),
            TransferProgress::Done
        );
        assert_eq!(master.result(), Err(BusFault::HeldLow));
        now_us += 500;
        assert_eq!(master.poll(now_us), TransferProgress::Idle);
    }
    // Five seconds: at 0 and after 10, 20, 40, ... 640 ms, then each second.
    assert_eq!(master.counters().recoveries, 7 + 3);
    assert!(*half_clocks.borrow() <= 11 * 30, "{half_clocks:?}");
}

#[test]
fn f05_a_unit_that_never_answers_is_overdue_within_a_millisecond() {
    let frozen = Frozen {
        pins: true,
        ..Frozen::default()
    };
    let mut master = I2cMaster::new(frozen, I2cTiming::fast(42_000_000), 0);
    for transactions in 1..=100 {
        let begun_us = transactions * 10_000;
        let begun = master.begin(&transaction(1, 4), begun_us);
        assert_eq!(begun, TransferProgress::Running);
        assert_eq!(master.poll(begun_us + 399), TransferProgress::Running);
        assert_eq!(master.poll(begun_us + 400), TransferProgress::Done);
        assert_eq!(master.result(), Err(BusFault::Overdue));
        assert_eq!(u64::from(master.counters().recoveries), transactions);
    }
}

#[test]
fn f05_an_event_that_never_goes_away_does_not_stop_polling() {
    const ITEVTEN: u16 = 1 << 9;
    let frozen = Frozen {
        status: 1 << 2,
        pins: true,
        ..Frozen::default()
    };
    let written = frozen.written.clone();
    let mut master = I2cMaster::new(frozen, I2cTiming::fast(42_000_000), 0);
    assert_eq!(
        master.begin(&transaction(1, 4), 0),
        TransferProgress::Running
    );
    let listens = || {
        let written = written.borrow();
        let last = written
            .iter()
            .rfind(|(register, _)| *register == I2cRegister::Cr2);
        last.is_some_and(|(_, value)| value & ITEVTEN != 0)
    };
    let calls = (0..1000)
        .take_while(|_| listens() && master.on_event(1) == TransferProgress::Running)
        .count();
    assert_eq!(calls, 32);
    assert_eq!(master.poll(500), TransferProgress::Done);
    assert_eq!(master.result(), Err(BusFault::Overdue));
}

#[test]
fn timing_follows_the_peripheral_bus() {
    // FREQ in MHz, CCR in thirds of a clock, TRISE of 300 ns; worked out by hand.
    for (bus_hz, megahertz, thirds, rise) in [
        (42_000_000, 42, 35, 13),
        (16_000_000, 16, 14, 5),
        (50_000_000, 50, 42, 16),
        (4_000_000, 4, 4, 2),
        (0, 4, 4, 2),
        (u32::MAX, 50, 42, 16),
    ] {
        let frozen = Frozen::default();
        let written = frozen.written.clone();
        I2cMaster::new(frozen, I2cTiming::fast(bus_hz), 0);
        let written = written.borrow();
        for wanted in [
            (I2cRegister::Cr2, megahertz),
            (I2cRegister::Ccr, 0x8000 | thirds),
            (I2cRegister::Trise, rise),
        ] {
            assert!(written.contains(&wanted), "{bus_hz}: {wanted:?}");
        }
    }
}
