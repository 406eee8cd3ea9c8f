//! Segments in view of a sensor, and the bearings between which they are seen.

use super::{EndGradient, WallSegment};
use crate::geometry::Vector;

/// Least distance from the line of a wall at which the wall is seen, metres.
const LEAST_DISTANCE_M: f64 = 1e-6;

/// Least length of a wall that is seen, metres.
const LEAST_LENGTH_M: f64 = 1e-6;

/// Narrowest piece of the lobe that is looked at, radians.
pub(super) const LEAST_PIECE_RAD: f64 = 1e-12;

/// A bearing at which a piece of the lobe begins or ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub(super) bearing_rad: f64,
    pub(super) moved_by: Mover,
}

/// What moves a cut.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mover {
    /// Nothing: the edge of the lobe.
    Lobe,
    /// An end of the segment of this index; true for `to`.
    End(usize, bool),
    /// The crossing of two segments in view, by their places in the list of those.
    Crossing(usize, usize),
}

/// A segment in view of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) index: usize,
    /// Perpendicular distance, metres (D).
    pub(super) distance_m: f64,
    /// Bearing of the normal, radians (psi), and the normal itself.
    pub(super) psi: f64,
    pub(super) normal: Vector,
    /// Derivatives of D and psi by the ends.
    pub(super) distance_by_ends: EndGradient,
    pub(super) psi_by_ends: EndGradient,
    pub(super) low: Cut,
    pub(super) high: Cut,
}

impl Seen {
    /// A segment in the sensor's frame, if some of it is inside the lobe.
    pub(super) fn of(index: usize, segment: &WallSegment, edge_rad: f64) -> Option<Self> {
        let way = segment.to - segment.from;
        let length = way.norm();
        if !(length > LEAST_LENGTH_M && length.is_finite()) {
            return None;
        }
        let along = way.scaled(1.0 / length);
        // With the wall's direction along the tangent, the normal is to its right.
        let mut normal = Vector::new(along.y, -along.x);
        let mut distance_m = normal.dot(segment.from);
        let is_reversed = distance_m < 0.0;
        if is_reversed {
            normal = normal.scaled(-1.0);
            distance_m = -distance_m;
        }
        if distance_m < LEAST_DISTANCE_M {
            return None;
        }
        let tangent = Vector::new(-normal.y, normal.x);
        let places = [tangent.dot(segment.from), tangent.dot(segment.to)];
        let psi = libm::atan2(normal.y, normal.x);
        let [u, other] = places;
        let cut = |place: f64, is_to: bool| {
            let bearing_rad = psi + libm::atan2(place, distance_m);
            Cut {
                bearing_rad: bearing_rad.clamp(-edge_rad, edge_rad),
                moved_by: if bearing_rad.abs() < edge_rad {
                    Mover::End(index, is_to)
                } else {
                    Mover::Lobe
                },
            }
        };
        let (low, high) = if is_reversed {
            (cut(other, true), cut(u, false))
        } else {
            (cut(u, false), cut(other, true))
        };
        if high.bearing_rad - low.bearing_rad < LEAST_PIECE_RAD {
            return None;
        }
        let span = other - u;
        let by_ends = |from: f64, to: f64| {
            let (from, to) = (normal.scaled(from), normal.scaled(to));
            [from.x, from.y, to.x, to.y]
        };
        Some(Self {
            index,
            distance_m,
            psi,
            normal,
            distance_by_ends: by_ends(other / span, -u / span),
            psi_by_ends: by_ends(1.0 / span, -1.0 / span),
            low,
            high,
        })
    }

    /// Distance of the wall's line under a bearing, metres.
    pub(super) fn range_m(&self, bearing_rad: f64) -> f64 {
        self.distance_m / libm::cos(bearing_rad - self.psi)
    }

    /// Return per radian under a bearing, for a gain of 1, 1/m^2.
    pub(super) fn density(&self, xi: f64, bearing_rad: f64) -> f64 {
        let cosine = libm::cos(bearing_rad - self.psi);
        let squared = self.distance_m * self.distance_m;
        libm::cos(xi * bearing_rad) * cosine * cosine * cosine / squared
    }

    /// The normal divided by the distance: its product with a direction is the inverse of
    /// the range in that direction.
    pub(super) fn reciprocal(&self) -> Vector {
        self.normal.scaled(1.0 / self.distance_m)
    }

    /// The bearing inside both segments at which they cross, if their order changes.
    pub(super) fn crossing(&self, other: &Self) -> Option<f64> {
        let low = self.low.bearing_rad.max(other.low.bearing_rad);
        let high = self.high.bearing_rad.min(other.high.bearing_rad);
        if high - low < LEAST_PIECE_RAD {
            return None;
        }
        let difference = self.reciprocal() - other.reciprocal();
        let at = |bearing_rad: f64| {
            let (sine, cosine) = libm::sincos(bearing_rad);
            difference.dot(Vector::new(cosine, sine))
        };
        if at(low) * at(high) >= 0.0 {
            return None;
        }
        let across = libm::atan2(difference.y, difference.x);
        let quarter = core::f64::consts::FRAC_PI_2;
        [-3.0, -1.0, 1.0, 3.0]
            .map(|quarters| across + quarters * quarter)
            .into_iter()
            .find(|bearing_rad| (low..=high).contains(bearing_rad))
    }

    /// Derivatives of the reciprocal normal's product with a direction, by the ends.
    pub(super) fn reciprocal_by_ends(&self, direction: Vector) -> EndGradient {
        let along_normal = self.normal.dot(direction) / (self.distance_m * self.distance_m);
        let along_tangent = self.normal.cross(direction) / self.distance_m;
        let mut gradient = [0.0; 4];
        for ((slot, distance), psi) in gradient
            .iter_mut()
            .zip(self.distance_by_ends)
            .zip(self.psi_by_ends)
        {
            *slot = psi * along_tangent - distance * along_normal;
        }
        gradient
    }
}

/// The nearest of the segments under a bearing.
pub(super) fn nearest(seen: &[Seen], bearing_rad: f64) -> Option<&Seen> {
    let here = seen
        .iter()
        .filter(|one| (one.low.bearing_rad..=one.high.bearing_rad).contains(&bearing_rad));
    here.min_by(|a, b| a.range_m(bearing_rad).total_cmp(&b.range_m(bearing_rad)))
}
