//! The AMiRo's ring of eight proximity sensors on two buses.
//!
//! Each bus has a multiplexer and four sensors; [`AMIRO_PLACES`] says which is which.
//! What executes transactions takes those of each bus from its [`Branch`], by
//! [`ProximityRing::branch_mut`].
//!
//! # Example
//!
//! ```
//! use amiro_ipf::driver::{Bus, BusFault, ProximityRing, SensorState};
//! use amiro_ipf::model::Sample;
//!
//! let mut ring = ProximityRing::new();
//! for round in 0..3 {
//!     let now_us = round * 8_000;
//!     for bus in [Bus::I2c1, Bus::I2c2] {
//!         let branch = ring.branch_mut(bus);
//!         branch.begin_round(now_us, false);
//!         while let Some(_transaction) = branch.next(now_us) {
//!             // A bus that no part is connected to.
//!             branch.answer(now_us, Err(BusFault::NoSuchPart));
//!         }
//!     }
//! }
//! assert_eq!(ring.states(16_000), [SensorState::Missing; 8]);
//! assert_eq!(ring.samples(16_000), [Sample::Missing; 8]);
//! ```

use pca9544a::Channel;

use super::branch::{Branch, BranchCounters};
use super::proximity_sensor::ProximitySensor;
use super::sensor_state::{SensorCounters, SensorState};
use crate::model::{SENSORS, Sample, SensorMask};

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
/// The index runs clockwise from back left, see [`Ring::AMIRO`](crate::model::Ring).
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
}

impl Default for ProximityRing {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_has_two_sensors() {
        for (index, place) in AMIRO_PLACES.iter().enumerate() {
            assert!(!AMIRO_PLACES[..index].contains(place), "{place:?}");
        }
    }
}
