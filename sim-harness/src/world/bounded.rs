//! A number of a scenario file, checked against its range as it is read.

use serde::de::{Deserialize, Deserializer, Error};

/// A finite number between two bounds, given in thousandths.
///
/// The value is checked while it is read, so that the error shows the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded<const LOW: i64, const HIGH: i64>(f64);

impl<const LOW: i64, const HIGH: i64> Bounded<LOW, HIGH> {
    pub(super) const fn value(self) -> f64 {
        self.0
    }
}

impl<'de, const LOW: i64, const HIGH: i64> Deserialize<'de> for Bounded<LOW, HIGH> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = f64::deserialize(deserializer)?;
        let (low, high) = (LOW as f64 * 1e-3, HIGH as f64 * 1e-3);
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
pub(super) type Coordinate = Bounded<-1_000_000, 1_000_000>;
/// A radius, metres: 1 mm to 10 m.
pub(super) type Radius = Bounded<1, 10_000>;
/// A cell's side, metres: 1 mm to 100 mm.
pub(super) type CellSize = Bounded<1, 100>;
/// A linear speed, metres per second: 1 mm/s to 5 m/s.
pub(super) type Speed = Bounded<1, 5_000>;
/// An angle, degrees: ten turns either way.
pub(super) type Degrees = Bounded<-3_600_000, 3_600_000>;
/// A reflectivity relative to the calibrated surface: 0.001 to 100.
pub(super) type Reflectivity = Bounded<1, 100_000>;
/// A distance driven, metres: up to a kilometre.
pub(super) type Distance = Bounded<0, 1_000_000>;
