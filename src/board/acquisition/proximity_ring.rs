//! The AMiRo's ring of eight proximity sensors on two buses.
//!
//! Each bus has a multiplexer and four sensors, see [`AMIRO_CONNECTIONS`]. The
//! transactions of each bus come from its [`MuxedBus`], see [`ProximityRing::bus_mut`].
//!
//! # Example
//!
//! ```
//! use amiro_ipf::board::acquisition::{Bus, ProximityRing};
//! use amiro_ipf::board::i2c::BusFault;
//! use amiro_ipf::board::sensor_state::SensorState;
//! use amiro_ipf::model::Sample;
//!
//! let mut ring = ProximityRing::new();
//! for round in 0..3 {
//!     let now_us = round * 8_000;
//!     for bus in [Bus::I2c1, Bus::I2c2] {
//!         let muxed = ring.bus_mut(bus);
//!         muxed.begin_round(now_us, false);
//!         while let Some(_transaction) = muxed.next(now_us) {
//!             // No part is connected to the bus.
//!             muxed.answer(now_us, Err(BusFault::NoSuchPart));
//!         }
//!     }
//! }
//! assert_eq!(ring.states(16_000), [SensorState::Missing; 8]);
//! assert_eq!(ring.samples(16_000), [Sample::Missing; 8]);
//! ```

use pca9544a::Channel;

use crate::board::i2c::muxed_bus::{MuxedBus, MuxedBusCounters};
use crate::board::proximity_sensor::ProximitySensor;
use crate::board::sensor_state::{SensorCounters, SensorState};
use crate::model::{SENSORS, Sample};

/// One of the two I2C buses.
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
pub struct SensorConnection {
    /// Its bus.
    pub bus: Bus,
    /// Its channel of the bus's multiplexer.
    pub channel: Channel,
}

impl SensorConnection {
    const fn on(bus: Bus, channel: Channel) -> Self {
        Self { bus, channel }
    }
}

/// Where each sensor of the AMiRo is connected, by its index on the ring.
///
/// The index runs clockwise from back left, see [`Ring::AMIRO`](crate::model::Ring). Two
/// generations of AMiRo-OS agree on this table. A robot with swapped buses shows only when
/// a hand is held in front of a sensor.
pub const AMIRO_CONNECTIONS: [SensorConnection; SENSORS] = [
    SensorConnection::on(Bus::I2c1, Channel::One),
    SensorConnection::on(Bus::I2c1, Channel::Three),
    SensorConnection::on(Bus::I2c1, Channel::Two),
    SensorConnection::on(Bus::I2c2, Channel::Zero),
    SensorConnection::on(Bus::I2c2, Channel::One),
    SensorConnection::on(Bus::I2c2, Channel::Three),
    SensorConnection::on(Bus::I2c2, Channel::Two),
    SensorConnection::on(Bus::I2c1, Channel::Zero),
];

/// The eight sensors, their states and their values.
#[derive(Clone, Debug)]
pub struct ProximityRing {
    first: MuxedBus,
    second: MuxedBus,
}

impl ProximityRing {
    /// The whole ring before its first round.
    #[must_use]
    pub fn new() -> Self {
        Self {
            first: MuxedBus::new(),
            second: MuxedBus::new(),
        }
    }

    /// The sequence of a bus, for what executes its transactions.
    pub fn bus_mut(&mut self, bus: Bus) -> &mut MuxedBus {
        match bus {
            Bus::I2c1 => &mut self.first,
            Bus::I2c2 => &mut self.second,
        }
    }

    const fn bus(&self, bus: Bus) -> &MuxedBus {
        match bus {
            Bus::I2c1 => &self.first,
            Bus::I2c2 => &self.second,
        }
    }

    /// The sensor at a connection.
    #[must_use]
    pub const fn sensor(&self, connection: SensorConnection) -> &ProximitySensor {
        self.bus(connection.bus).sensor(connection.channel)
    }

    /// Sets each sensor's offset, raw counts with nothing in range.
    pub fn set_offsets(&mut self, offsets: [u16; SENSORS]) {
        for (at, offset) in AMIRO_CONNECTIONS.into_iter().zip(offsets) {
            self.bus_mut(at.bus).sensor_mut(at.channel).offset = offset;
        }
    }

    /// Each sensor's sample now: counts above its offset, saturated or missing.
    #[must_use]
    pub fn samples(&self, now_us: u64) -> [Sample; SENSORS] {
        AMIRO_CONNECTIONS.map(|at| self.sensor(at).sample(now_us))
    }

    /// Each sensor's state now.
    #[must_use]
    pub fn states(&self, now_us: u64) -> [SensorState; SENSORS] {
        AMIRO_CONNECTIONS.map(|at| self.sensor(at).state(now_us))
    }

    /// The last raw value of sensor `index`, of any age and state; `None` if it
    /// has none or the ring has no such sensor.
    #[must_use]
    pub fn raw(&self, index: usize) -> Option<u16> {
        let at = AMIRO_CONNECTIONS.get(index)?;
        self.sensor(*at).raw()
    }

    /// The raw values of the sensors that are trusted now, for
    /// [`OffsetMeasurement`](crate::board::calibration::OffsetMeasurement).
    #[must_use]
    pub fn trusted_raw(&self, now_us: u64) -> [Option<u16>; SENSORS] {
        AMIRO_CONNECTIONS.map(|at| {
            let sensor = self.sensor(at);
            sensor.raw().filter(|_| sensor.state(now_us).is_trusted())
        })
    }

    /// Each sensor's counters since the start.
    #[must_use]
    pub fn counters(&self) -> [SensorCounters; SENSORS] {
        AMIRO_CONNECTIONS.map(|at| self.sensor(at).counters())
    }

    /// A bus's counters since the start.
    #[must_use]
    pub const fn bus_counters(&self, bus: Bus) -> MuxedBusCounters {
        self.bus(bus).counters()
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
    fn no_connection_has_two_sensors() {
        for (index, at) in AMIRO_CONNECTIONS.iter().enumerate() {
            assert!(!AMIRO_CONNECTIONS[..index].contains(at), "{at:?}");
        }
    }
}
