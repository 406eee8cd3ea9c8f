//! The gain of one sensor relative to the others of a ring.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Gain of a sensor relative to the photometric law's alpha: 1 as modelled.
///
/// A fixed-point number of 1/16384 in two bytes, so that eight of them fit into the frame
/// of a configuration. 1 is exact, and exact in single precision.
///
/// Sensors of one robot differ by 10 to 15 %. The noise of a sample is that of the
/// electronics, sigma_s counts whatever the gain: a dim sensor has the larger error of a
/// range, and its range limit is reached at a weaker signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gain(u16);

impl Gain {
    /// As modelled.
    pub const ONE: Self = Self(1 << 14);

    /// Least legal gain.
    pub const LEAST: f32 = 0.25;

    /// Largest legal gain; held as the number of 1/16384 below it.
    pub const LARGEST: f32 = 4.0;

    /// The nearest gain to a ratio; `None` outside 0.25 to 4, NaN included.
    #[must_use]
    pub fn of(ratio: f32) -> Option<Self> {
        // A conversion of a float saturates: 65536 becomes 65535.
        (Self::LEAST..=Self::LARGEST)
            .contains(&ratio)
            .then_some(Self((ratio * 16_384.0 + 0.5) as u16))
    }

    /// The gain of a number of 1/16384, legal or not.
    #[must_use]
    pub const fn from_code(code: u16) -> Self {
        Self(code)
    }

    /// The gain as a ratio.
    #[must_use]
    pub fn ratio(self) -> f32 {
        f32::from(self.0) / 16_384.0
    }

    /// Whether it is at least 0.25.
    #[must_use]
    pub const fn is_legal(self) -> bool {
        self.0 >= 1 << 12
    }
}

/// Two bytes, the low one first; a number in text.
impl Serialize for Gain {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return serializer.serialize_f32(self.ratio());
        }
        self.0.to_le_bytes().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Gain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            let ratio = f32::deserialize(deserializer)?;
            let refused = || serde::de::Error::custom("a gain is from 0.25 to 4");
            return Self::of(ratio).ok_or_else(refused);
        }
        <[u8; 2]>::deserialize(deserializer).map(|bytes| Self(u16::from_le_bytes(bytes)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_held_to_half_a_unit_and_one_is_exact() {
        assert_eq!(Gain::of(1.0), Some(Gain::ONE));
        assert_eq!(Gain::ONE.ratio().to_bits(), 1.0_f32.to_bits());
        for step in 0..=375 {
            let ratio = 0.25 + 0.01 * step as f32;
            let held = Gain::of(ratio).unwrap().ratio();
            // Half a unit, and a whole one at 4.
            let bound = if ratio > 3.99 { 1.0 } else { 0.51 } / 16_384.0;
            assert!((held - ratio).abs() <= bound, "{ratio}: {held}");
        }
    }

    #[test]
    fn ratios_outside_the_range_are_no_gains() {
        for ratio in [0.2499, 4.001, -1.0, 0.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Gain::of(ratio), None, "{ratio}");
        }
        assert!(!Gain::from_code(4095).is_legal() && Gain::from_code(4096).is_legal());
    }
}
