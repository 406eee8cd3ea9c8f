//! A number of a file about a world, checked against its range as it is read.

use serde::de::{Deserialize, Deserializer, Error};

/// A finite number between two bounds, given in thousandths.
///
/// The value is checked while it is read, so that the error shows the line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded<const LOW: i64, const HIGH: i64>(f64);

impl<const LOW: i64, const HIGH: i64> Bounded<LOW, HIGH> {
    /// The smallest and the largest value.
    pub(crate) const RANGE: (f64, f64) = (LOW as f64 * 1e-3, HIGH as f64 * 1e-3);

    pub(crate) const fn value(self) -> f64 {
        self.0
    }
}

impl<'de, const LOW: i64, const HIGH: i64> Deserialize<'de> for Bounded<LOW, HIGH> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = f64::deserialize(deserializer)?;
        let (low, high) = Self::RANGE;
        // NaN lies in no range.
        if (low..=high).contains(&value) {
            Ok(Self(value))
        } else {
            Err(D::Error::custom(format!(
                "{value} is outside {low} to {high}"
            )))
        }
    }
}

/// A coordinate or the length of a leg, metres: up to a kilometre either way.
pub(crate) type Coordinate = Bounded<-1_000_000, 1_000_000>;
/// A radius, metres: 1 mm to 10 m.
pub(crate) type Radius = Bounded<1, 10_000>;
/// A cell's side, metres: 1 mm to 100 mm.
pub(crate) type CellSize = Bounded<1, 100>;
/// A linear speed, metres per second: 1 mm/s to 5 m/s.
pub(crate) type Speed = Bounded<1, 5_000>;
/// An angle, degrees: ten turns either way.
pub(crate) type Degrees = Bounded<-3_600_000, 3_600_000>;
/// A reflectivity relative to the calibrated surface: 0.001 to 100.
pub(crate) type Reflectivity = Bounded<1, 100_000>;
/// A distance driven, metres: up to a kilometre.
pub(crate) type Distance = Bounded<0, 1_000_000>;
