//! A tracked segment and what earlier readings say about it.

use nalgebra::{Matrix4, Vector4};

use super::SegmentParameters;
use crate::geometry::Point;
use crate::math;
use crate::model::Wall;

/// A straight piece of wall that is tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedSegment {
    pub(super) id: u16,
    pub(super) ends: Wall,
    pub(super) evidence: f32,
    pub(super) age_steps: u16,
    pub(super) is_frozen: bool,
    pub(super) covariance: Matrix4<f32>,
    pub(super) prior: Prior,
}

/// Standard deviations of an end of a segment, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndSigma {
    /// Along the segment.
    pub along_m: f32,
    /// Across it.
    pub across_m: f32,
}

/// The readings that have left the window, as a normal distribution of the ends.
///
/// In the coordinates along and across `along`, of the first end, then of the second;
/// a wall is known well across it and badly along it, and `f32` keeps both apart there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prior {
    /// Direction of the segment when the prior was begun.
    pub(super) along: Point,
    /// Ends that the deviation is counted from.
    pub(super) reference: Wall,
    /// A, 1/m^2.
    pub(super) information: Matrix4<f32>,
    /// A times the deviation of the mean from the reference, 1/m.
    pub(super) pull: Vector4<f32>,
}

impl TrackedSegment {
    pub(super) fn new(id: u16, ends: Wall) -> Self {
        Self {
            id,
            ends,
            evidence: 0.0,
            age_steps: 0,
            is_frozen: false,
            covariance: Matrix4::zeros(),
            prior: Prior::none(&ends),
        }
    }

    /// A number that no other segment has while this one is tracked.
    #[must_use]
    pub fn id(&self) -> u16 {
        self.id
    }

    /// The ends relative to the robot's centre, metres, in the axes of the tracker
    /// ([`SegmentTracker::body_from_track`](super::SegmentTracker::body_from_track)).
    #[must_use]
    pub fn ends(&self) -> Wall {
        self.ends
    }

    /// Covariance of (x0, y0, x1, y1), square metres, in the same axes, all other
    /// segments held. Zero before the first fit.
    #[must_use]
    pub fn covariance(&self) -> &Matrix4<f32> {
        &self.covariance
    }

    /// Standard deviations of the two ends, all other segments held; infinite before the
    /// first fit and where the readings and the prior leave the end open.
    ///
    /// They hold the sensors' noise and the relative error of each signal as if it were
    /// new in every reading. A gain that is off by the same share in all readings moves
    /// the whole wall farther.
    #[must_use]
    pub fn end_sigmas(&self) -> [EndSigma; 2] {
        let Point { x, y } = Prior::none(&self.ends).along;
        let entry = |row: usize, column: usize| {
            let entry = self.covariance.get((row, column));
            entry.copied().unwrap_or(0.0)
        };
        [0, 2].map(|end| {
            let (a, b, d) = (
                entry(end, end),
                entry(end, end + 1),
                entry(end + 1, end + 1),
            );
            EndSigma {
                along_m: deviation_m(x * x * a + 2.0 * x * y * b + y * y * d),
                across_m: deviation_m(y * y * a - 2.0 * x * y * b + x * x * d),
            }
        })
    }

    /// Cost that the segment has saved at readings that have left the window (chi^2).
    #[must_use]
    pub fn evidence(&self) -> f32 {
        self.evidence
    }

    /// Steps since the segment was found.
    #[must_use]
    pub fn age_steps(&self) -> u16 {
        self.age_steps
    }

    /// Whether it is out of reach: it is kept, but not fitted.
    #[must_use]
    pub fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// Moves the segment and what is known of it.
    pub(super) fn translate(&mut self, by: Point) {
        for end in self.ends.iter_mut().chain(&mut self.prior.reference) {
            *end = *end + by;
        }
    }

    /// Length, metres.
    pub(super) fn length_m(&self) -> f32 {
        length_m(&self.ends)
    }

    /// Deviation of the length from the expected one, in standard deviations, and its
    /// derivatives for the coordinates of the prior.
    pub(super) fn length_residual(&self, parameters: &SegmentParameters) -> (f32, [f32; 4]) {
        let length_m = self.length_m();
        let residual = (length_m - parameters.length_m) / parameters.length_sigma_m;
        let [from, to] = self.ends;
        let scale = 1.0 / (length_m.max(1e-6) * parameters.length_sigma_m);
        let way = self.prior.local(to - from);
        let (x, y) = (scale * way.x, scale * way.y);
        (residual, [-x, -y, x, y])
    }

    /// Cost of the prior, but for a constant, and of the length.
    pub(super) fn prior_cost(&self, parameters: &SegmentParameters) -> f32 {
        let deviation = self.prior.deviation(&self.ends);
        let (length, _) = self.length_residual(parameters);
        deviation.dot(&(self.prior.information * deviation - 2.0 * self.prior.pull))
            + length * length
    }

    /// Moves the ends by a step in the coordinates of the prior, each by at most so much.
    pub(super) fn step(&mut self, step: &[f32], most_m: f32) {
        for (end, step) in self.ends.iter_mut().zip(step.chunks_exact(2)) {
            if let [along, across] = step {
                let step = Point::new(*along, *across);
                let norm = step.norm();
                let factor = if norm > most_m { most_m / norm } else { 1.0 };
                *end = *end
                    + self
                        .prior
                        .global(Point::new(factor * step.x, factor * step.y));
            }
        }
    }
}

impl Prior {
    /// Nothing is known.
    pub(super) fn none(ends: &Wall) -> Self {
        let [from, to] = *ends;
        let way = to - from;
        let norm = way.norm();
        let along = if norm > 1e-6 {
            Point::new(way.x / norm, way.y / norm)
        } else {
            Point::new(1.0, 0.0)
        };
        Self {
            along,
            reference: *ends,
            information: Matrix4::zeros(),
            pull: Vector4::zeros(),
        }
    }

    /// A vector along and across.
    #[inline]
    pub(super) fn local(&self, vector: Point) -> Point {
        let Point { x: c, y: s } = self.along;
        Point::new(c * vector.x + s * vector.y, c * vector.y - s * vector.x)
    }

    /// The inverse of [`local`](Self::local).
    #[inline]
    pub(super) fn global(&self, vector: Point) -> Point {
        let Point { x: c, y: s } = self.along;
        Point::new(c * vector.x - s * vector.y, s * vector.x + c * vector.y)
    }

    /// Deviation of given ends from the reference.
    pub(super) fn deviation(&self, ends: &Wall) -> Vector4<f32> {
        let [first, last] = self.reference;
        let [from, to] = *ends;
        let (a, b) = (self.local(from - first), self.local(to - last));
        Vector4::new(a.x, a.y, b.x, b.y)
    }

    /// Counts deviations from given ends on, and lets the information fade.
    pub(super) fn rebase(&mut self, ends: &Wall, fade: f32) {
        let deviation = self.deviation(ends);
        self.pull = (self.pull - self.information * deviation) * fade;
        self.information *= fade;
        self.reference = *ends;
    }

    /// Adds a residual with its derivatives and weight, taken at the reference.
    pub(super) fn add(&mut self, slopes: &[f32; 4], residual: f32, weight: f32) {
        let slopes = Vector4::from(*slopes);
        self.information += slopes * slopes.transpose() * weight;
        self.pull -= slopes * (weight * residual);
    }

    /// The prior of a segment that joins the given end of this one and of another.
    pub(super) fn joined(ends: &Wall, parts: [(&Self, usize); 2]) -> Self {
        let mut joined = Self::none(ends);
        for (end, (part, of)) in parts.into_iter().enumerate() {
            // Turns the end's own block from the part's directions into the new ones.
            let at = |row: usize, column: usize| {
                let entry = part.information.get((2 * of + row, 2 * of + column));
                entry.copied().unwrap_or(0.0)
            };
            let (a, b, d) = (at(0, 0), at(0, 1), at(1, 1));
            let turn = joined.local(part.along);
            let (c, s) = (turn.x, turn.y);
            let block = [
                [
                    c * c * a - 2.0 * c * s * b + s * s * d,
                    c * s * (a - d) + (c * c - s * s) * b,
                ],
                [
                    c * s * (a - d) + (c * c - s * s) * b,
                    s * s * a + 2.0 * c * s * b + c * c * d,
                ],
            ];
            for (row, values) in block.iter().enumerate() {
                for (column, value) in values.iter().enumerate() {
                    let place = (2 * end + row, 2 * end + column);
                    if let Some(entry) = joined.information.get_mut(place) {
                        *entry = *value;
                    }
                }
            }
        }
        joined
    }
}

/// The root of a variance, metres; infinite for what is no variance.
fn deviation_m(variance: f32) -> f32 {
    if variance > 0.0 && variance.is_finite() {
        math::sqrt(variance)
    } else {
        f32::INFINITY
    }
}

/// Length of a wall, metres.
pub(super) fn length_m([from, to]: &Wall) -> f32 {
    (*to - *from).norm()
}

/// Distance of a point from a wall, metres.
pub(super) fn distance_m([from, to]: &Wall, place: Point) -> f32 {
    let way = *to - *from;
    let off = place - *from;
    let squared = way.norm_squared();
    let share = if squared > 0.0 {
        ((way.x * off.x + way.y * off.y) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (off - Point::new(share * way.x, share * way.y)).norm()
}

/// What is left of a wall outside of a circle about the origin: its longer part.
pub(super) fn outside([from, to]: &Wall, radius_m: f32) -> Option<Wall> {
    let way = *to - *from;
    let length_m = way.norm();
    if length_m <= 0.0 {
        return None;
    }
    let along = Point::new(way.x / length_m, way.y / length_m);
    let start = along.x * from.x + along.y * from.y;
    let across = along.x * from.y - along.y * from.x;
    let half = radius_m * radius_m - across * across;
    if half <= 0.0 {
        return Some([*from, *to]);
    }
    let half = math::sqrt(half);
    // The circle covers the lengths between these two.
    let (enter, leave) = (-half - start, half - start);
    if leave <= 0.0 || enter >= length_m {
        return Some([*from, *to]);
    }
    let at = |length: f32| *from + Point::new(along.x * length, along.y * length);
    if enter >= length_m - leave {
        (enter > 0.0).then(|| [*from, at(enter)])
    } else {
        (leave < length_m).then(|| [at(leave), *to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn end_deviations_are_those_along_and_across_the_segment() {
        // A wall along y: across is x.
        let ends = [Point::new(0.1, 0.0), Point::new(0.1, 0.3)];
        let mut segment = TrackedSegment::new(1, ends);
        let unknown = segment.end_sigmas().map(|end| (end.along_m, end.across_m));
        assert_eq!(unknown, [(f32::INFINITY, f32::INFINITY); 2], "no fit yet");
        let variances = [0.001, 0.02, 0.003, 0.04].map(|sigma: f32| sigma * sigma);
        segment.covariance = Matrix4::from_diagonal(&Vector4::from(variances));
        for (end, (along_m, across_m)) in segment
            .end_sigmas()
            .into_iter()
            .zip([(0.02, 0.001), (0.04, 0.003)])
        {
            assert!((end.along_m - along_m).abs() < 1e-6, "{end:?}");
            assert!((end.across_m - across_m).abs() < 1e-6, "{end:?}");
        }
        segment.covariance = Matrix4::from_element(f32::NAN);
        let unknown = segment.end_sigmas().map(|end| (end.along_m, end.across_m));
        assert_eq!(unknown, [(f32::INFINITY, f32::INFINITY); 2], "no number");
    }
}
