//! The flash image's controller of the robot's bus, against a model of its unit.
//!
//! Names that begin with f and a number are entries of the fault catalogue: CAN.

mod model;

use amiro_ipf::board::can::{
    BitTiming, BodySpeed, CanController, CanControllerHealth, CanFrame, CanMessage, CanState,
    IgnoredFrame, READ_IDS, StandardId, proximity_ring, target_speed,
};
use amiro_ipf::random::Generator;
use model::{Unit, Wire, WireFrame};

/// Between two polls, microseconds.
const POLL_US: u64 = 10_000;
/// Most accesses to registers of one call: 2 us at the bus's 42 MHz and some cycles each.
const MOST_ACCESSES: u32 = 30;

/// A controller, the model that it drives, and a check that no call takes long.
struct Bench {
    unit: Unit,
    controller: CanController<Unit>,
}

impl Bench {
    fn new() -> Self {
        let unit = Unit::out_of_reset();
        let controller = CanController::new(unit.clone(), Some(BitTiming::AT_42_MHZ));
        Self { unit, controller }
    }

    /// A controller that has joined a healthy bus.
    fn on_the_bus() -> Self {
        let mut bench = Self::new();
        bench.run(5);
        assert_eq!(bench.health().state, CanState::On);
        bench
    }

    fn health(&self) -> CanControllerHealth {
        *self.controller.health()
    }

    fn now_us(&self) -> u64 {
        self.unit.0.borrow().now_us
    }

    fn set_wire(&self, wire: Wire) {
        self.unit.0.borrow_mut().wire = wire;
    }

    fn pass(&self, bits: u64) {
        self.unit.0.borrow_mut().pass(bits);
    }

    fn bounded<T>(&mut self, call: impl FnOnce(&mut CanController<Unit>, u64) -> T) -> T {
        let now_us = self.now_us();
        let before = self.unit.0.borrow().accesses;
        let result = call(&mut self.controller, now_us);
        let accesses = self.unit.0.borrow().accesses - before;
        assert!(accesses <= MOST_ACCESSES, "{accesses} accesses");
        result
    }

    fn poll(&mut self) {
        self.bounded(|controller, now_us| controller.poll(now_us));
    }

    /// Polls, each after its time.
    fn run(&mut self, polls: u64) {
        for _ in 0..polls {
            self.pass(POLL_US);
            self.poll();
        }
    }

    fn transmit(&mut self, frame: &CanFrame) -> bool {
        self.bounded(|controller, now_us| controller.transmit(now_us, frame))
    }

    /// What the interrupts of FIFO 0 take until it is quiet, by interrupt.
    fn interrupts(&mut self) -> Vec<Vec<CanFrame>> {
        let mut taken = Vec::new();
        while self.unit.0.borrow().is_interrupting() {
            assert!(taken.len() < 10, "the interrupt stays");
            taken.push(self.bounded(|controller, _| controller.receive().to_vec()));
            self.pass(1);
        }
        taken
    }

    fn receives(&self, frame: &WireFrame) {
        self.unit.0.borrow_mut().receives(frame);
    }

    fn sent(&self) -> Vec<WireFrame> {
        self.unit.0.borrow().on_wire.clone()
    }
}

/// ODOMETRY with a number of its own in x.
fn odometry(number: u8) -> WireFrame {
    WireFrame::data(0x281, [number, 0, 0, 0, 0, 0, 0, 0])
}

fn ring(sensor: usize) -> CanFrame {
    proximity_ring(sensor, 3000 + sensor as u16, 2400).unwrap()
}

#[test]
fn bit_timing_is_that_of_the_robots() {
    // SJW 1, TS2 3, TS1 15, BRP 1: 42 MHz / 2 / (1 + 16 + 4) = 1 Mbit/s.
    assert_eq!(BitTiming::AT_42_MHZ.bits(), 0x013f_0001);
    for hz in [42_000_000, 16_000_000] {
        let bits = BitTiming::at(hz).unwrap().bits();
        let quanta = 3 + (bits >> 16 & 15) + (bits >> 20 & 7);
        assert_eq!(hz / ((bits & 0x3ff) + 1) / quanta, 1_000_000, "{hz}");
    }
    assert_eq!(BitTiming::at(8_000_000), None);
}

#[test]
fn unit_is_set_up_as_the_robots_have_it() {
    let bench = Bench::on_the_bus();
    let unit = bench.unit.0.borrow();
    assert_eq!(unit.plain(0x1c), 0x013f_0001);
    // ABOM, AWUM, TXFP; neither asleep nor in initialisation.
    assert_eq!(unit.plain(0x00), 1 << 6 | 1 << 5 | 1 << 2);
    // Frames in FIFO 0 interrupt; bus-off is noted.
    assert_eq!(unit.plain(0x14), 1 << 1 | 1 << 10);
    // Three banks; ODOMETRY and ACTUAL_SPEED in the first word.
    assert_eq!(unit.plain(0x21c), 0b111);
    assert_eq!(unit.plain(0x240), 0x281 << 5 | 0x101 << 21);
}

#[test]
fn controller_joins_within_three_polls() {
    let mut bench = Bench::new();
    assert_eq!(bench.health(), CanControllerHealth::default());
    bench.poll();
    assert_eq!(bench.health().state, CanState::Joining);
    bench.run(2);
    assert_eq!(bench.health().state, CanState::On);
    assert_eq!(bench.health().bus_offs, 0);
}

#[test]
fn f22_unit_that_does_not_answer_is_absent_without_a_wait() {
    let mut bench = Bench::new();
    bench.unit.0.borrow_mut().is_present = false;
    bench.poll();
    bench.run(9);
    assert_eq!(bench.health().state, CanState::Joining);
    bench.run(1);
    // 100 ms after the first poll.
    assert_eq!(bench.health().state, CanState::Absent);
    assert!(!bench.transmit(&ring(0)));
    assert!(
        bench
            .bounded(|controller, _| controller.receive())
            .is_empty()
    );
    // Asked again each second, and given up again: 100 ms of 1.1 s.
    let mut attempts = 0;
    let mut last = CanState::Absent;
    for _ in 0..1_100 {
        bench.run(1);
        let state = bench.health().state;
        attempts += u32::from(last == CanState::Absent && state == CanState::Joining);
        last = state;
    }
    assert_eq!(attempts, 10);
    assert_eq!(bench.health().refused, 1);
}

#[test]
fn f22_unit_that_comes_later_is_taken_within_its_second() {
    let mut bench = Bench::new();
    bench.unit.0.borrow_mut().is_present = false;
    bench.run(50);
    bench.unit.0.borrow_mut().is_present = true;
    bench.run(103);
    assert_eq!(bench.health().state, CanState::On);
    assert!(bench.transmit(&ring(0)));
}

#[test]
fn f22_board_without_the_right_clock_leaves_the_bus_alone() {
    let unit = Unit::out_of_reset();
    let mut controller = CanController::new(unit.clone(), None);
    for poll in 0..1000 {
        controller.poll(poll * POLL_US);
    }
    assert_eq!(controller.health().state, CanState::Absent);
    assert_eq!(unit.0.borrow().accesses, 0);
}

#[test]
fn f21_bus_held_dominant_is_joined_when_it_is_free() {
    let mut bench = Bench::new();
    bench.set_wire(Wire::Dominant);
    bench.run(1_000);
    assert_eq!(bench.health().state, CanState::Joining);
    assert!(!bench.transmit(&ring(0)));
    bench.set_wire(Wire::Healthy);
    bench.run(1);
    assert_eq!(bench.health().state, CanState::On);
}

#[test]
fn f21_bus_off_is_counted_and_ends_128_times_11_bits_after_the_bus_heals() {
    let mut bench = Bench::on_the_bus();
    bench.set_wire(Wire::Destroying);
    assert!(bench.transmit(&ring(0)));
    // 32 attempts of 63 bits and 8 errors each: off after 2.1 ms.
    bench.pass(2_100);
    bench.set_wire(Wire::Dominant);
    bench.run(100);
    assert_eq!(bench.health().state, CanState::BusOff);
    assert_eq!(
        (bench.health().bus_offs, bench.health().transmit_errors),
        (1, 255)
    );
    // The frame is given up, and nobody waits for the next.
    assert_eq!((bench.health().given_up, bench.health().sent), (1, 0));
    assert!(!bench.transmit(&ring(1)));

    bench.set_wire(Wire::Healthy);
    bench.pass(128 * 11 - 1);
    bench.poll();
    assert_eq!(bench.health().state, CanState::BusOff);
    bench.pass(1);
    bench.poll();
    assert_eq!(bench.health().state, CanState::On);
    assert_eq!(bench.health().bus_offs, 1);
    assert!(bench.transmit(&ring(2)));
    bench.run(1);
    assert_eq!(bench.sent().len(), 1);
    bench.receives(&odometry(1));
    assert_eq!(bench.interrupts().len(), 1);
}

#[test]
fn f21_bus_off_between_two_polls_is_counted_too() {
    let mut bench = Bench::on_the_bus();
    for bus_offs in 1..=3 {
        bench.set_wire(Wire::Destroying);
        assert!(bench.transmit(&ring(0)));
        bench.pass(2_100);
        bench.set_wire(Wire::Healthy);
        bench.pass(128 * 11 + 500);
        bench.poll();
        let health = bench.health();
        assert_eq!((health.state, health.bus_offs), (CanState::On, bus_offs));
        // The frame was kept through it: less than 20 ms.
        assert_eq!((health.sent, health.given_up), (bus_offs, 0));
    }
}

#[test]
fn f20_unacknowledged_frame_is_given_up_after_20_ms() {
    let mut bench = Bench::on_the_bus();
    assert!(bench.transmit(&ring(0)));
    bench.run(1);
    assert_eq!((bench.health().given_up, bench.health().sent), (0, 1));
    bench.set_wire(Wire::Alone);
    assert!(bench.transmit(&ring(0)));
    bench.run(1);
    assert_eq!(bench.health().given_up, 0);
    bench.run(2);
    assert_eq!((bench.health().given_up, bench.health().sent), (1, 1));
    // Without anybody else the unit becomes passive, never goes off.
    for _ in 0..100 {
        bench.transmit(&ring(0));
        bench.run(4);
    }
    let health = bench.health();
    assert_eq!((health.given_up, health.refused), (101, 0));
    assert_eq!((health.state, health.bus_offs), (CanState::On, 0));
    assert_eq!(health.transmit_errors, 128);
    // Nothing old is left for the one who comes.
    bench.set_wire(Wire::Healthy);
    bench.run(10);
    assert_eq!(bench.sent().len(), 1);
}

#[test]
fn frames_are_sent_as_given_and_in_their_order() {
    let mut bench = Bench::on_the_bus();
    let speed = BodySpeed {
        forward_m_per_s: 0.08,
        turn_rad_per_s: -0.2,
    };
    // TARGET_SPEED has the lowest identifier and would overtake.
    let frames = [ring(7), ring(0), target_speed(&speed)];
    for frame in &frames {
        assert!(bench.transmit(frame));
    }
    assert!(!bench.transmit(&ring(1)), "there are three mailboxes");
    bench.run(1);
    let sent = bench.sent();
    let identifiers: Vec<u32> = sent.iter().map(|frame| frame.identifier).collect();
    assert_eq!(identifiers, [0x1ba, 0x182, 0x084]);
    for (sent, given) in sent.iter().zip(&frames) {
        assert_eq!(sent.bytes, given.bytes());
        assert_eq!(sent.length_code, given.length());
        assert!(!sent.is_extended && !sent.is_remote);
    }
    assert_eq!((bench.health().sent, bench.health().refused), (3, 1));
}

#[test]
fn ring_of_a_minute_is_sent_whole_beside_the_polls() {
    let mut bench = Bench::on_the_bus();
    let mut schedule = amiro_ipf::board::can::RingSchedule::default();
    for _ in 0..60_000 {
        bench.pass(1_000);
        let now_us = bench.now_us();
        if let Some(sensor) = schedule.due(now_us, amiro_ipf::model::SensorMask::ALL) {
            assert!(bench.transmit(&ring(sensor)));
        }
        if now_us.is_multiple_of(POLL_US) {
            bench.poll();
        }
    }
    // 60 s / 63 ms = 952.4 cycles of eight.
    assert_eq!(bench.sent().len(), 953 * 8);
    assert_eq!((bench.health().given_up, bench.health().refused), (0, 0));
}

#[test]
fn f23_filters_let_in_what_is_read_and_nothing_else() {
    let mut bench = Bench::on_the_bus();
    for identifier in 0..0x800_u32 {
        for (is_extended, is_remote) in [(false, false), (false, true), (true, false)] {
            bench.receives(&WireFrame {
                // The same eleven bits at the top of an extended identifier.
                identifier: identifier << if is_extended { 18 } else { 0 },
                is_extended,
                is_remote,
                ..WireFrame::data(0, [0; 8])
            });
            let came = !bench.interrupts().is_empty();
            let is_read = READ_IDS.contains(&StandardId::from_bits(identifier as u16));
            assert_eq!(
                came,
                is_read && !is_extended && !is_remote,
                "{identifier:#x}"
            );
        }
    }
}

#[test]
fn f23_random_frames_reach_the_decoder_only_under_its_identifiers() {
    let mut bench = Bench::on_the_bus();
    let mut random = Generator::seeded(23);
    let mut came = 0;
    for _ in 0..200_000 {
        let [head, low, high] = [(); 3].map(|()| random.bits());
        let is_extended = head & 3 == 0;
        let identifier = match head & 3 {
            0 => head >> 3,
            1 => head >> 21,
            _ => u32::from(READ_IDS[(head >> 8) as usize % READ_IDS.len()].bits()),
        };
        let mut bytes = [0; 8];
        bytes[..4].copy_from_slice(&low.to_le_bytes());
        bytes[4..].copy_from_slice(&high.to_le_bytes());
        bench.receives(&WireFrame {
            identifier,
            is_extended,
            is_remote: head >> 29 == 0,
            length_code: (head >> 4 & 15) as u8,
            bytes,
        });
        for frame in bench.interrupts().into_iter().flatten() {
            came += 1;
            let unread = [
                IgnoredFrame::Extended,
                IgnoredFrame::NotData,
                IgnoredFrame::UnknownId,
            ];
            if let Err(reason) = CanMessage::decode(&frame) {
                assert!(!unread.contains(&reason), "{frame:?}: {reason}");
            }
        }
    }
    assert_eq!(bench.health().received, came);
    assert!(came > 50_000, "{came}");
    assert_eq!(bench.health().overruns, 0);
}

#[test]
fn f24_flood_of_others_costs_no_interrupt() {
    let bench = Bench::on_the_bus();
    // A second of the shortest frames, 47 bits each, under the highest priority.
    for _ in 0..21_276 {
        bench.receives(&WireFrame::data(0, [0; 8]));
        bench.pass(47);
        assert!(!bench.unit.0.borrow().is_interrupting());
    }
    assert_eq!((bench.health().received, bench.health().overruns), (0, 0));
}

#[test]
fn f24_flood_of_odometry_is_taken_by_three_and_the_newest_comes_last() {
    for is_release_slow in [false, true] {
        let mut bench = Bench::on_the_bus();
        bench.unit.0.borrow_mut().is_release_slow = is_release_slow;
        for number in 0..200 {
            bench.receives(&odometry(number));
        }
        let taken = bench.interrupts();
        assert!(taken.iter().all(|frames| frames.len() <= 3), "{taken:?}");
        let numbers: Vec<u8> = taken
            .iter()
            .flatten()
            .map(|frame| frame.bytes()[0])
            .collect();
        assert_eq!(numbers, [0, 1, 199]);
        assert_eq!((bench.health().received, bench.health().overruns), (3, 1));
        // A slow release gives a frame an interrupt, and none twice.
        assert_eq!(taken.len(), if is_release_slow { 3 } else { 1 });
        // The line is quiet again: every frame comes.
        for number in 0..100 {
            bench.receives(&odometry(number));
            let numbers: Vec<u8> = bench
                .interrupts()
                .concat()
                .iter()
                .map(|f| f.bytes()[0])
                .collect();
            assert_eq!(numbers, [number]);
        }
        assert_eq!(bench.health().overruns, 1);
    }
}

#[test]
fn f24_shutdown_comes_through_a_flood_of_odometry() {
    let mut bench = Bench::on_the_bus();
    let mut shutdowns = 0;
    for turn in 0..9_000_u32 {
        // Full load: a frame of 111 bits each, and the interrupt in time for each second.
        bench.receives(&odometry(turn as u8));
        bench.pass(111);
        if turn % 100 == 50 {
            let mut shutdown = WireFrame::data(0x404, [0x55, 0xaa, 0, 0, 0, 0, 0, 0]);
            shutdown.length_code = 2;
            bench.receives(&shutdown);
        }
        if turn % 2 == 1 {
            for frame in bench.interrupts().into_iter().flatten() {
                shutdowns += u32::from(matches!(
                    CanMessage::decode(&frame),
                    Ok(CanMessage::Shutdown(_))
                ));
            }
        }
    }
    assert_eq!(shutdowns, 90);
    assert_eq!(bench.health().overruns, 0);
}
