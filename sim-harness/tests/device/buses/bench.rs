//! The ring on the robot's buses, round after round.

use amiro_ipf::board::acquisition::{BUSES, ProximityRing};
use amiro_ipf::board::i2c::BusTransaction;
use amiro_ipf::board::i2c::muxed_bus::{MuxedBus, ROUND_PERIOD_US};
use amiro_ipf::board::sensor_state::SensorState;
use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::random::{Generator, uniform_below};
use sim_harness::bus::{FakeBus, RobotBuses, RobotParts, Vcnl4020Fault, on_sensor};

/// Rounds after which sound sensors have become trusted: one configures, ten readings,
/// and one more for clocks that have not ticked yet.
const TO_TRUST: u64 = 13;

/// A robot's buses, its ring, and what each sensor measures.
pub(crate) struct Bench {
    pub(crate) buses: RobotBuses,
    pub(crate) ring: ProximityRing,
    round: u64,
    generator: Generator,
}

impl Bench {
    /// Power has just come up.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            buses: RobotBuses::default(),
            ring: ProximityRing::new(),
            round: 0,
            generator: Generator::seeded(seed),
        }
    }

    /// All sensors are trusted.
    pub(crate) fn running(seed: u64) -> Self {
        let mut bench = Self::new(seed);
        bench.rounds(TO_TRUST);
        assert!(bench.states().iter().all(|state| state.is_trusted()));
        bench
    }

    /// What a sensor's measurements lie at: it and two counts above it.
    pub(crate) fn tag(sensor: usize) -> u16 {
        2_600 + 100 * sensor as u16
    }

    pub(crate) fn below(&mut self, bound: u32) -> u32 {
        uniform_below(&mut self.generator, bound)
    }

    /// A round of a moving robot in which each sensor measures its tag.
    pub(crate) fn round(&mut self) {
        self.set_tags();
        self.round_as_it_is(true);
    }

    /// Lets each sensor measure its tag with noise.
    pub(crate) fn set_tags(&mut self) {
        for sensor in 0..SENSORS {
            let noise = self.below(3) as u16;
            self.buses.set_signal(sensor, Self::tag(sensor) + noise);
        }
    }

    pub(crate) fn rounds(&mut self, rounds: u64) {
        (0..rounds).for_each(|_| self.round());
    }

    /// A round in which the sensors measure what was set before.
    pub(crate) fn round_as_it_is(&mut self, moving: bool) {
        self.round_with(moving, |_, _, _| {});
    }

    /// The same, with a call before each transaction: the number of its bus, and itself.
    pub(crate) fn round_with(
        &mut self,
        moving: bool,
        mut before: impl FnMut(&mut RobotBuses, usize, &BusTransaction),
    ) {
        let now_us = self.next_round_us();
        self.buses.advance_to(now_us * 1_000);
        for (number, bus) in BUSES.into_iter().enumerate() {
            let muxed = self.ring.bus_mut(bus);
            muxed.begin_round(now_us, moving);
            while let Some(transaction) = muxed.next(now_us) {
                before(&mut self.buses, number, &transaction);
                execute(muxed, self.buses.bus_mut(number), &transaction, now_us);
            }
        }
        self.round += 1;
    }

    /// When the next round begins, if the ones before have ended by then.
    pub(crate) fn next_round_us(&self) -> u64 {
        (self.round * ROUND_PERIOD_US).max(self.buses.now_ns().div_ceil(1_000))
    }

    /// When the last round began.
    pub(crate) fn now_us(&self) -> u64 {
        self.round.saturating_sub(1) * ROUND_PERIOD_US
    }

    pub(crate) fn states(&self) -> [SensorState; SENSORS] {
        self.ring.states(self.now_us())
    }

    pub(crate) fn samples(&self) -> [Sample; SENSORS] {
        self.ring.samples(self.now_us())
    }

    pub(crate) fn readings(&self) -> [u32; SENSORS] {
        self.ring.counters().map(|counters| counters.readings)
    }

    /// Something happens to a sensor now.
    pub(crate) fn strike(&mut self, sensor: usize, fault: Vcnl4020Fault) {
        let bus = self.buses.bus_of_mut(sensor);
        let now_ns = bus.now_ns();
        bus.script.from_time(now_ns, on_sensor(sensor, fault));
    }

    /// The same, and both buses are idle.
    pub(crate) fn assert_own_tags_and_idle(&self, story: &str) {
        self.assert_own_tags(story);
        assert!(self.buses.one.is_idle(), "{story}");
        assert!(self.buses.two.is_idle(), "{story}");
    }

    /// No sensor has been credited with anything but its own measurements.
    pub(crate) fn assert_own_tags(&self, story: &str) {
        for sensor in 0..SENSORS {
            let tag = Self::tag(sensor);
            let raw = self.ring.raw(sensor);
            assert!(
                raw.is_none_or(|raw| (tag..=tag + 2).contains(&raw)),
                "{story}: sensor {sensor} has {raw:?}\nI2C1 {}\nI2C2 {}",
                self.buses.one.transcript(),
                self.buses.two.transcript()
            );
        }
    }
}

/// Executes a transaction of a muxed bus on its bus, and gives it the result.
pub(crate) fn execute(
    muxed: &mut MuxedBus,
    bus: &mut FakeBus<RobotParts>,
    transaction: &BusTransaction,
    now_us: u64,
) {
    let result = bus.run(transaction);
    muxed.answer(now_us, result.as_deref().map_err(|error| (*error).into()));
}
