//! One leg of a drive: straight on, a turn in place, or an arc.

use serde::Deserialize;

use super::bounded::{Coordinate, Degrees, Radius};

/// Speed of a turn in place, degrees per second.
pub const TURN_DEG_PER_S: f64 = 45.0;

/// One leg of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "LegKeys")]
pub enum Leg {
    /// Along the heading; negative is backward.
    Straight {
        /// Length, metres.
        length_m: f64,
    },
    /// About the robot's centre, at [`TURN_DEG_PER_S`]; positive is to the left.
    Turn {
        /// The turn, degrees.
        angle_deg: f64,
    },
    /// Forward along a circle; positive is to the left.
    Arc {
        /// The turn, degrees.
        angle_deg: f64,
        /// Radius of the circle, metres.
        radius_m: f64,
    },
}

impl Leg {
    /// Distance that the robot's centre covers, metres; 0 for a turn in place.
    #[must_use]
    pub fn length_m(self) -> f64 {
        match self {
            Self::Straight { length_m } => length_m.abs(),
            Self::Turn { .. } => 0.0,
            Self::Arc {
                angle_deg,
                radius_m,
            } => radius_m * angle_deg.abs() * (core::f64::consts::PI / 180.0),
        }
    }

    /// Duration of the leg at the given linear speed, seconds.
    #[must_use]
    pub fn duration_s(self, speed_m_per_s: f64) -> f64 {
        match self {
            Self::Turn { angle_deg } => angle_deg.abs() / TURN_DEG_PER_S,
            Self::Straight { .. } | Self::Arc { .. } => self.length_m() / speed_m_per_s,
        }
    }
}

/// The keys of a `[[drive]]` table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Keys")]
struct LegKeys {
    straight_m: Option<Coordinate>,
    turn_deg: Option<Degrees>,
    arc_deg: Option<Degrees>,
    radius_m: Option<Radius>,
}

impl TryFrom<LegKeys> for Leg {
    type Error = &'static str;

    fn try_from(keys: LegKeys) -> Result<Self, Self::Error> {
        match (keys.straight_m, keys.turn_deg, keys.arc_deg, keys.radius_m) {
            (Some(length), None, None, None) => Ok(Self::Straight {
                length_m: length.value(),
            }),
            (None, Some(angle), None, None) => Ok(Self::Turn {
                angle_deg: angle.value(),
            }),
            (None, None, Some(angle), Some(radius)) => Ok(Self::Arc {
                angle_deg: angle.value(),
                radius_m: radius.value(),
            }),
            _ => Err("a drive leg has straight_m, or turn_deg, or arc_deg with radius_m"),
        }
    }
}
