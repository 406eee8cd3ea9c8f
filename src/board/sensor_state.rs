//! How a sensor is, in words and numbers that fit a status message.

use serde::{Deserialize, Serialize};

/// How one sensor is. Variants are appended, never reordered: they go over the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorState {
    /// It did not answer three rounds in a row; asked again once a second.
    Missing,
    /// It answers, and has not earned trust yet, or has not been asked.
    #[default]
    NoData,
    /// Its register is full: something touches the hull.
    TooClose,
    /// It sees nothing in range.
    Nothing,
    /// It sees something.
    Good,
    /// Its last value is too old, or has been the same for a second of driving.
    Stale,
    /// It answers, and not as a sensor should.
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
    /// Another part answers at its address; asked again once a second.
    WrongIdentity,
    /// Its samples are no measurements.
    Garbage,
    /// Ambient light blinds it.
    Dazzled,
}

/// What happened to one sensor since the start; each stops at its highest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorCounters {
    /// Readings credited to it.
    pub readings: u32,
    /// Rounds that wanted it and ended with an error, unsuccessful probes included.
    pub failed: u16,
    /// Times that it was found to have forgotten its configuration.
    pub resets: u16,
    /// Answers thrown away because the multiplexer named another channel.
    pub discarded_for_mux: u16,
    /// Readings that changed while they were read, and were read anew.
    pub torn: u16,
}
