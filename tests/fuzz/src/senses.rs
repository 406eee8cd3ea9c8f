//! Any frames on the robot's bus, any answers on the I2C buses.

use amiro_ipf::can::{Frame, Identifier, StandardId};
use amiro_ipf::driver::{Bus, BusFault, Transaction};
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::Input;
use amiro_ipf::senses::{BUSES, Heard, ROUND_US, Senses};
use sim_harness::bus::RobotBuses;

use crate::framing::Script;

/// Transactions after which a round of one bus is over, whatever is answered: with
/// errors all along, a round of four sensors and second visits is far shorter.
const LONGEST_ROUND: usize = 400;

/// Sound buses bring every sensor's trust back within this time: a second until it is
/// tried again, half a second until garbage is forgotten, ten readings.
const TRUSTED_WITHIN_US: u64 = 3_000_000;
/// Trust is watched for so long: twelve rounds.
const TRUSTED_FOR_US: u64 = 100_000;

const FAULTS: [BusFault; 6] = [
    BusFault::NoSuchPart,
    BusFault::RefusedByte,
    BusFault::ArbitrationLost,
    BusFault::Misplaced,
    BusFault::Overdue,
    BusFault::HeldLow,
];

/// Lives through what the bytes say. If the first byte is odd, the buses are sound
/// afterwards, and every sensor earns trust.
pub fn check(bytes: &[u8]) {
    let mut script = Script(bytes);
    let becomes_sound = script.byte() & 1 == 1;
    let mut life = Life::default();
    while !script.is_over() {
        life.go_on(&mut script);
    }
    life.answer_all_with_faults();
    if becomes_sound {
        life.recover();
    }
}

#[derive(Default)]
struct Life {
    senses: Senses,
    now_us: u64,
    asked: [Option<Transaction>; 2],
    sampled_us: u64,
}

impl Life {
    fn go_on(&mut self, script: &mut Script<'_>) {
        let operation = script.byte();
        let number = usize::from(operation >> 3 & 1);
        match operation & 7 {
            // Most of the time a transaction is asked for and answered.
            0 => self.exchange(number, |transaction| {
                let mut bytes = script.bytes(transaction.to_read()).to_vec();
                bytes.resize(transaction.to_read(), 0);
                Ok(bytes)
            }),
            1 => self.exchange(number, |_| Err(FAULTS[usize::from(operation >> 4) % 6])),
            // An answer of any length, asked for or not.
            2 => {
                let bytes = script.bytes(usize::from(operation >> 4));
                self.answer(number, Ok(bytes));
            }
            3 => self.now_us += u64::from(script.word()),
            4 => self.poll(),
            5 => self.take_frame(script),
            6 => {
                self.now_us += ROUND_US;
                self.poll();
            }
            _ => self.senses.calibrate(),
        }
        // Whoever looks on sees nothing impossible.
        let _ = self.senses.frame_due(self.now_us);
        let _ = self.senses.take_offsets();
        let _ = self.senses.buses();
    }

    fn exchange(
        &mut self,
        number: usize,
        result: impl FnOnce(&Transaction) -> Result<Vec<u8>, BusFault>,
    ) {
        if self.asked[number].is_none() {
            self.asked[number] = self.senses.next(BUSES[number], self.now_us);
        }
        let Some(transaction) = &self.asked[number] else {
            return;
        };
        // One at a time: nothing more before the answer.
        assert_eq!(self.senses.next(BUSES[number], self.now_us), None);
        self.now_us += u64::from(transaction.clocks()) * 5 / 2;
        match result(transaction) {
            Ok(bytes) => self.answer(number, Ok(&bytes)),
            Err(fault) => self.answer(number, Err(fault)),
        }
    }

    fn answer(&mut self, number: usize, result: Result<&[u8], BusFault>) {
        self.asked[number] = None;
        self.senses.answer(BUSES[number], self.now_us, result);
    }

    fn poll(&mut self) {
        let Some(input) = self.senses.poll(self.now_us) else {
            return;
        };
        let Input::Proximity { stamp_us, samples } = input else {
            panic!("{input:?}");
        };
        assert!(stamp_us >= self.sampled_us && stamp_us <= self.now_us);
        self.sampled_us = stamp_us;
        assert!(samples.iter().any(|sample| *sample != Sample::Missing));
        let states = self.senses.ring().states(self.now_us);
        for (sample, state) in samples.iter().zip(states) {
            assert!(
                *sample == Sample::Missing || state.is_trusted(),
                "{sample:?} of a sensor that is {state:?}"
            );
        }
    }

    fn take_frame(&mut self, script: &mut Script<'_>) {
        let (bits, kind) = (script.word(), script.byte());
        let identifier = if kind & 0x20 == 0 {
            Identifier::Standard(StandardId::from_bits(bits))
        } else {
            Identifier::Extended(u32::from(bits))
        };
        let mut bytes = [0; 8];
        bytes.fill_with(|| script.byte());
        let frame = Frame::received(identifier, kind & 0x10 != 0, kind & 0xf, bytes);
        match self.senses.take_frame(self.now_us, &frame) {
            Heard::Input(Input::Odometry { stamp_us, pose }) => {
                assert!(pose.is_finite() && stamp_us <= self.now_us);
            }
            Heard::Input(other) => panic!("{other:?}"),
            Heard::Shutdown => assert!(
                kind & 0x30 == 0 && (0x401..=0x404).contains(&(bits & 0x7ff)),
                "{frame:?}"
            ),
            Heard::Nothing => {}
        }
    }

    /// A round ends whatever the bus answers.
    fn answer_all_with_faults(&mut self) {
        for number in [0, 1] {
            let mut exchanges = 0;
            while self.asked[number].is_some() || self.is_asked(number) {
                self.exchange(number, |_| Err(BusFault::NoSuchPart));
                exchanges += 1;
                assert!(exchanges < LONGEST_ROUND, "{:?} never ends", BUSES[number]);
            }
        }
    }

    fn is_asked(&mut self, number: usize) -> bool {
        self.asked[number] = self.senses.next(BUSES[number], self.now_us);
        self.asked[number].is_some()
    }

    /// On sound buses every sensor is trusted again within three seconds, and stays so.
    ///
    /// It ends there: a round on these buses costs as much as a long script's answers.
    fn recover(&mut self) {
        let mut buses = RobotBuses::default();
        let start_us = self.now_us;
        // What was trusted at the start may lose it to parts that were just powered up.
        let mut trusted_since_us = None;
        loop {
            self.pass_a_millisecond(&mut buses, start_us);
            let since_us = *trusted_since_us.get_or_insert(self.now_us);
            let states = self.senses.ring().states(self.now_us);
            if !states.iter().all(|state| state.is_trusted()) {
                trusted_since_us = None;
                assert!(self.now_us < start_us + TRUSTED_WITHIN_US, "{states:?}");
            } else if self.now_us >= since_us + TRUSTED_FOR_US {
                return;
            }
        }
    }

    fn pass_a_millisecond(&mut self, buses: &mut RobotBuses, start_us: u64) {
        let since_us = self.now_us - start_us;
        self.now_us += 1_000;
        buses.advance_to((since_us + 1_000) * 1_000);
        if since_us.is_multiple_of(ROUND_US) {
            let noise = (since_us / ROUND_US % 3) as u16;
            (0..SENSORS).for_each(|sensor| buses.set_signal(sensor, 2_600 + noise));
        }
        self.poll();
        for bus in BUSES {
            let number = usize::from(bus == Bus::I2c2);
            while let Some(transaction) = self.senses.next(bus, self.now_us) {
                let result = buses.bus_mut(number).run(&transaction);
                let result = result.as_deref().map_err(|error| (*error).into());
                self.senses.answer(bus, self.now_us, result);
            }
        }
    }
}
