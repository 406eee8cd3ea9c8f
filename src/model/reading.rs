//! What a sensor delivers and what it means: both enums, never a magic number.

use serde::{Deserialize, Serialize};

use super::RangeEstimate;

/// What one sensor delivered, before any model is applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Sample {
    /// Counts above the sensor's stored offset; noise takes them below zero.
    Counts(i32),
    /// The sensor's 16-bit register was full: something touches the hull.
    Saturated,
    /// No usable value: absent, masked, stale or broken.
    Missing,
}

/// A sample interpreted: the nearest surface in the sensor's lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A surface on the arc that the echo describes.
    Range(RangeEstimate),
    /// No surface up to the range limit; the echo describes that limit.
    NothingInRange(RangeEstimate),
    /// A surface closer than the model covers.
    TooClose,
    /// No information.
    Faulty,
}
