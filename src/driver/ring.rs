//! The AMiRo's ring of eight proximity sensors on two buses.
//!
//! Each bus has a multiplexer and four sensors; [`AMIRO_PLACES`] says which is which.
//! Whoever has interrupts gives each [`Branch`] its bus through
//! [`ProximityRing::branch_mut`]; everyone else calls [`ProximityRing::poll`].
//!
//! # Example
//!
//! ```
//! use amiro_ipf::driver::{ProximityRing, SensorState};
//! use amiro_ipf::sensor::Sample;
//! use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
//!
//! /// A bus that nothing is connected to.
//! struct Bare;
//!
//! impl ErrorType for Bare {
//!     type Error = ErrorKind;
//! }
//!
//! impl I2c for Bare {
//!     fn transaction(&mut self, _: u8, _: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
//!         Err(ErrorKind::Other)
//!     }
//! }
//!
//! let mut ring = ProximityRing::new();
//! for round in 0..3 {
//!     ring.poll(&mut Bare, &mut Bare, round * 8_000, false);
//! }
//! assert_eq!(ring.states(16_000), [SensorState::Missing; 8]);
//! assert_eq!(ring.samples(16_000), [Sample::Missing; 8]);
//! ```

use embedded_hal::i2c::I2c;

use super::branch::{Branch, BranchCounters};
use super::pca9544a::Channel;
use super::proximity_sensor::ProximitySensor;
use super::sensor_state::{SensorCounters, SensorState};
use crate::sensor::{SENSORS, Sample, SensorMask};

/// One of the two buses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Bus {
    /// I2C1 on PB8 and PB9: the four sensors at the back.
    I2c1,
    /// I2C2 on PB10 and PB11: the four sensors at the front and on the right.
    I2c2,
}

/// Where a sensor is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Place {
    /// Its bus.
    pub bus: Bus,
    /// Its channel of the bus's multiplexer.
    pub channel: Channel,
}

impl Place {
    const fn on(bus: Bus, channel: Channel) -> Self {
        Self { bus, channel }
    }
}

/// Where each sensor of the AMiRo is connected, by its index on the ring.
///
/// The index runs clockwise from back left, see [`Ring::AMIRO`](crate::sensor::Ring).
/// As two generations of AMiRo-OS have it; a robot whose buses were swapped in its
/// wiring cannot be told from the buses, only by a hand in front of a sensor.
pub const AMIRO_PLACES: [Place; SENSORS] = [
    Place::on(Bus::I2c1, Channel::One),
    Place::on(Bus::I2c1, Channel::Three),
    Place::on(Bus::I2c1, Channel::Two),
    Place::on(Bus::I2c2, Channel::Zero),
    Place::on(Bus::I2c2, Channel::One),
    Place::on(Bus::I2c2, Channel::Three),
    Place::on(Bus::I2c2, Channel::Two),
    Place::on(Bus::I2c1, Channel::Zero),
];

/// The eight sensors, their states and their values; see the [module](self).
#[derive(Clone, Debug)]
pub struct ProximityRing {
    first: Branch,
    second: Branch,
}

impl ProximityRing {
    /// The whole ring, of which nothing is known yet.
    #[must_use]
    pub fn new() -> Self {
        Self::with(SensorMask::ALL)
    }

    /// A ring of which only these sensors are spoken to; the others have no data.
    #[must_use]
    pub fn with(in_use: SensorMask) -> Self {
        let mut ring = Self {
            first: Branch::new(&[]),
            second: Branch::new(&[]),
        };
        for (index, place) in AMIRO_PLACES.into_iter().enumerate() {
            if in_use.contains(index) {
                ring.branch_mut(place.bus).add(place.channel);
            }
        }
        ring
    }

    /// A bus's sequencer, for what executes its transactions.
    pub fn branch_mut(&mut self, bus: Bus) -> &mut Branch {
        match bus {
            Bus::I2c1 => &mut self.first,
            Bus::I2c2 => &mut self.second,
        }
    }

    const fn branch(&self, bus: Bus) -> &Branch {
        match bus {
            Bus::I2c1 => &self.first,
            Bus::I2c2 => &self.second,
        }
    }

    /// The sensor at a place.
    #[must_use]
    pub const fn sensor_at(&self, place: Place) -> &ProximitySensor {
        self.branch(place.bus).sensor(place.channel)
    }

    /// Sets each sensor's offset, raw counts with nothing in range.
    pub fn set_offsets(&mut self, offsets: [u16; SENSORS]) {
        for (place, offset) in AMIRO_PLACES.into_iter().zip(offsets) {
            self.branch_mut(place.bus).sensor_mut(place.channel).offset = offset;
        }
    }

    /// Sets how many counts above the offset mean that there is something; 24 until
    /// then. It names a state and changes no value.
    pub fn set_least_counts(&mut self, least_counts: u16) {
        for place in AMIRO_PLACES {
            let sensor = self.branch_mut(place.bus).sensor_mut(place.channel);
            sensor.least_counts = least_counts;
        }
    }

    /// What each sensor delivers now: counts above its offset, or why not.
    #[must_use]
    pub fn samples(&self, now_us: u64) -> [Sample; SENSORS] {
        AMIRO_PLACES.map(|place| self.sensor_at(place).sample(now_us))
    }

    /// How each sensor is now.
    #[must_use]
    pub fn states(&self, now_us: u64) -> [SensorState; SENSORS] {
        AMIRO_PLACES.map(|place| self.sensor_at(place).state(now_us))
    }

    /// The last raw value of sensor `index`, whatever its age and state; `None` if it
    /// has none or the ring no such sensor.
    #[must_use]
    pub fn raw(&self, index: usize) -> Option<u16> {
        let place = AMIRO_PLACES.get(index)?;
        self.sensor_at(*place).raw()
    }

    /// The raw values of the sensors that are trusted now, for
    /// [`OffsetMeasurement`](super::OffsetMeasurement).
    #[must_use]
    pub fn trusted_raw(&self, now_us: u64) -> [Option<u16>; SENSORS] {
        AMIRO_PLACES.map(|place| {
            let sensor = self.sensor_at(place);
            sensor.raw().filter(|_| sensor.state(now_us).is_trusted())
        })
    }

    /// What happened to each sensor since the start.
    #[must_use]
    pub fn counters(&self) -> [SensorCounters; SENSORS] {
        AMIRO_PLACES.map(|place| self.sensor_at(place).counters())
    }

    /// What happened on a bus since the start.
    #[must_use]
    pub const fn branch_counters(&self, bus: Bus) -> BranchCounters {
        self.branch(bus).counters()
    }

    /// Runs a whole round on both buses, one after the other, and waits for it.
    ///
    /// Every 8 ms; takes 2 x 2.13 ms at 400 kHz, 2 x 6.0 ms at most when everything
    /// fails. `now_us` is the stamp of all its readings.
    pub fn poll<I1: I2c, I2: I2c>(
        &mut self,
        bus1: &mut I1,
        bus2: &mut I2,
        now_us: u64,
        moving: bool,
    ) {
        self.first.poll(bus1, now_us, moving);
        self.second.poll(bus2, now_us, moving);
    }
}

impl Default for ProximityRing {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fake::Bus as FakeBus;
    use super::*;

    /// Two buses whose sensors deliver the counts of their ring index times ten.
    fn buses() -> [FakeBus; 2] {
        let mut buses = [FakeBus::new(), FakeBus::new()];
        // By name, as the robot's maker lists them, from back left clockwise.
        let rows = [
            (0, 0, 1), // SSW
            (1, 0, 3), // WSW
            (2, 0, 2), // WNW
            (3, 1, 0), // NNW
            (4, 1, 1), // NNE
            (5, 1, 3), // ENE
            (6, 1, 2), // ESE
            (7, 0, 0), // SSE
        ];
        for (sensor, bus, channel) in rows {
            buses[bus].parts[channel].results = vec![2_450 + 10 * sensor];
        }
        buses
    }

    fn run(ring: &mut ProximityRing, buses: &mut [FakeBus; 2], rounds: u64) -> u64 {
        let [first, second] = buses;
        let mut now_us = 0;
        for round in 0..rounds {
            now_us = round * 8_000;
            first.wait_until(now_us);
            second.wait_until(now_us);
            ring.poll(first, second, now_us, false);
        }
        now_us
    }

    #[test]
    fn every_row_of_the_table_is_the_robots() {
        let mut ring = ProximityRing::new();
        let now_us = run(&mut ring, &mut buses(), 12);
        for (index, sample) in ring.samples(now_us).into_iter().enumerate() {
            assert_eq!(sample, Sample::Counts(10 * index as i32), "sensor {index}");
        }
    }

    #[test]
    fn no_place_has_two_sensors() {
        for (index, place) in AMIRO_PLACES.iter().enumerate() {
            assert!(!AMIRO_PLACES[..index].contains(place), "{place:?}");
        }
    }

    #[test]
    fn offsets_and_the_threshold_belong_to_their_sensors() {
        let mut ring = ProximityRing::new();
        ring.set_offsets(core::array::from_fn(|index| 2_400 + 10 * index as u16));
        ring.set_least_counts(51);
        let now_us = run(&mut ring, &mut buses(), 12);
        assert_eq!(ring.samples(now_us), [Sample::Counts(50); SENSORS]);
        assert_eq!(ring.states(now_us), [SensorState::Nothing; SENSORS]);
        ring.set_least_counts(50);
        assert_eq!(ring.states(now_us), [SensorState::Good; SENSORS]);
    }

    #[test]
    fn raw_values_are_told_by_index_and_only_trusted_ones_for_calibration() {
        let mut ring = ProximityRing::new();
        let mut buses = buses();
        let now_us = run(&mut ring, &mut buses, 5);
        assert_eq!(ring.raw(3), Some(2_480));
        assert_eq!(ring.raw(8), None);
        assert_eq!(ring.trusted_raw(now_us), [None; SENSORS]);
        let now_us = run(&mut ring, &mut buses, 30);
        assert_eq!(ring.trusted_raw(now_us)[3], Some(2_480));
        assert_eq!(ring.trusted_raw(now_us + 16_001), [None; SENSORS]);
    }

    #[test]
    fn f03_a_dead_bus_leaves_the_other_one_alone() {
        let mut ring = ProximityRing::new();
        let mut buses = buses();
        buses[0].mux_present = false;
        let now_us = run(&mut ring, &mut buses, 100);
        let states = ring.states(now_us);
        for (index, place) in AMIRO_PLACES.into_iter().enumerate() {
            let is_missing = states[index] == SensorState::Missing;
            assert_eq!(is_missing, place.bus == Bus::I2c1, "sensor {index}");
        }
        assert_eq!(ring.branch_counters(Bus::I2c1).mux_failures, 3);
        assert_eq!(ring.branch_counters(Bus::I2c2).mux_failures, 0);
        assert_eq!(ring.counters()[4].readings, 99);
    }

    #[test]
    fn a_masked_sensor_is_not_spoken_to() {
        let mut ring = ProximityRing::with(SensorMask::NONE.with(2).complement());
        let mut buses = buses();
        let now_us = run(&mut ring, &mut buses, 12);
        let states = ring.states(now_us);
        assert_eq!(states[2], SensorState::NoData);
        assert_eq!(buses[0].parts[2].registers[0x80], 0x80, "reset value");
        assert_eq!(states.iter().filter(|state| state.is_trusted()).count(), 7);
    }
}
