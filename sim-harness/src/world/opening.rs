//! Rectangles of the map: its extent, and the passages that it must leave open.

use serde::Deserialize;

use super::bounded::{Coordinate, Distance};
use super::shape::corners;
use crate::geometry::Rectangle;

/// A passage that a map must leave open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Where it is.
    pub rectangle: Rectangle,
    /// Driven distance after which it is judged, metres.
    pub judged_at_m: f64,
}

/// `[x_min, y_min, x_max, y_max]`.
#[derive(Debug, Deserialize)]
#[serde(try_from = "[Coordinate; 4]")]
pub(super) struct Extent(pub(super) Rectangle);

impl TryFrom<[Coordinate; 4]> for Extent {
    type Error = String;

    fn try_from([x_min, y_min, x_max, y_max]: [Coordinate; 4]) -> Result<Self, Self::Error> {
        let (min, max) = corners([x_min, y_min], [x_max, y_max])?;
        Ok(Self(Rectangle { min, max }))
    }
}

/// The keys of an `[[opening]]` table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OpeningKeys {
    min: [Coordinate; 2],
    max: [Coordinate; 2],
    judged_at_m: Distance,
}

/// An opening as a file describes it.
#[derive(Debug, Deserialize)]
#[serde(try_from = "OpeningKeys")]
pub(super) struct OpeningTable(pub(super) Opening);

impl TryFrom<OpeningKeys> for OpeningTable {
    type Error = String;

    fn try_from(keys: OpeningKeys) -> Result<Self, Self::Error> {
        let (min, max) = corners(keys.min, keys.max)?;
        Ok(Self(Opening {
            rectangle: Rectangle { min, max },
            judged_at_m: keys.judged_at_m.value(),
        }))
    }
}
