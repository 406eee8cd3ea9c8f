//! The state of a proximity sensor and its counters.

use serde::{Deserialize, Serialize};

/// State of one sensor. Variants are appended, never reordered: they go over the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorState {
    /// It did not answer three rounds in a row; probed once per second.
    Missing,
    /// It answers and is not trusted yet, or was not read yet.
    #[default]
    NoData,
    /// Its register is full: something touches the hull.
    TooClose,
    /// Nothing is in range.
    Nothing,
    /// Something is in range.
    Good,
    /// Its last value is too old, or was the same for a second of driving.
    Stale,
    /// It answers, but its readings are unusable.
    Faulty(SensorFault),
}

impl SensorState {
    /// Whether its value may be used.
    #[must_use]
    pub const fn is_trusted(self) -> bool {
        matches!(self, Self::TooClose | Self::Nothing | Self::Good)
    }
}

/// What is wrong with a sensor. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorFault {
    /// Another part answers at its address; probed once per second.
    WrongIdentity,
    /// Its samples cannot be measurements.
    Garbage,
    /// Ambient light saturates it.
    Dazzled,
}

/// Counters of one sensor since the start; each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorCounters {
    /// Readings that were taken.
    pub readings: u32,
    /// Rounds that ended without an answer of a due sensor, failed probes included.
    pub failed: u16,
    /// Configurations lost to a reset of the sensor.
    pub resets: u16,
    /// Answers discarded because the multiplexer named another channel.
    pub discarded_for_mux: u16,
    /// Readings that changed while they were read, and were read again.
    pub torn: u16,
}
