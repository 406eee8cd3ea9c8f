//! Which walls a sensor has in view, and which of them is the nearest where.

use heapless::Vec;

use super::{MAX_WALLS, TabulatedWallLaw, Wall, larger, smaller};
use crate::geometry::Point;

/// Most intervals of the lobe: all ends split it.
const MAX_INTERVALS: usize = 2 * MAX_WALLS + 1;
/// Least perpendicular distance, metres. A wall that passes a sensor so closely, seen
/// from its end, returns less than a count; one that faces it has filled the register.
pub(super) const LEAST_DISTANCE_M: f32 = 0.004;
/// Least length of a wall, metres.
const LEAST_LENGTH_M: f32 = 1e-4;
/// A tangent beyond all lobes, for bearings of a right angle and more.
pub(super) const BEHIND: f32 = 1e3;
/// Width below which an interval of tan(t / 2) is empty.
pub(super) const NARROW: f32 = 1e-6;

/// A wall as a sensor sees it, its ends in the order of their bearings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Which of the walls.
    pub(super) wall: usize,
    /// Whether the ends are in the opposite order of the wall's.
    pub(super) is_swapped: bool,
    pub(super) ends: Wall,
    /// Direction of the normal, away from the sensor.
    pub(super) normal: Point,
    pub(super) distance_m: f32,
    /// tan(t / 2) of the ends, clipped to the lobe.
    pub(super) half_tangents: [f32; 2],
    pub(super) is_clipped: [bool; 2],
}

/// An interval of tan(t / 2) in which one wall is the nearest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) sight: usize,
    pub(super) from: f32,
    pub(super) to: f32,
}

impl Interval {
    /// All of the only wall in view.
    pub(super) fn whole(sight: &Sight) -> Self {
        let [from, to] = sight.half_tangents;
        Self { sight: 0, from, to }
    }
}

pub(super) type Sights = Vec<Sight, MAX_WALLS>;
pub(super) type Intervals = Vec<Interval, MAX_INTERVALS>;

impl TabulatedWallLaw {
    /// Collects the walls in view.
    #[inline(never)]
    pub(super) fn see_all(&self, walls: &[Wall], sights: &mut Sights) {
        for (index, wall) in walls.iter().enumerate().take(MAX_WALLS) {
            if self.may_see(wall)
                && let Some(sight) = self.see(index, wall)
            {
                let _ = sights.push(sight);
            }
        }
    }

    /// Whether something of a wall, given in the sensor's frame, can be in the lobe:
    /// `false` if it lies beyond one edge of it.
    #[inline]
    pub(crate) fn may_see(&self, [a, b]: &Wall) -> bool {
        let (edge_a, edge_b) = (self.tangent_max * a.x, self.tangent_max * b.x);
        !(a.y > edge_a && b.y > edge_b || -a.y > edge_a && -b.y > edge_b)
    }

    /// A wall in the lobe; `None` if nothing of it is.
    fn see(&self, wall: usize, &[a, b]: &Wall) -> Option<Sight> {
        let cross = a.x * b.y - a.y * b.x;
        let is_swapped = cross < 0.0;
        let ends = if is_swapped { [b, a] } else { [a, b] };
        let [from, to] = ends;
        let length_m = (to - from).norm();
        // Not a number, or too short.
        if !(length_m >= LEAST_LENGTH_M && length_m.is_finite()) {
            return None;
        }
        let max = self.half_tangent_max;
        let [first, last] = ends.map(half_tangent);
        let (is_clipped, half_tangents) = if last >= first {
            (
                [first < -max, last > max],
                [larger(first, -max), smaller(last, max)],
            )
        } else if first < max {
            // The wall passes behind the sensor: one of its ends may be in the lobe.
            ([false, true], [first, max])
        } else {
            ([true, false], [-max, last])
        };
        let [from_u, to_u] = half_tangents;
        if to_u - from_u <= NARROW {
            return None;
        }
        let along = Point::new((to.x - from.x) / length_m, (to.y - from.y) / length_m);
        let normal = Point::new(along.y, -along.x);
        let distance_m = cross.abs() / length_m;
        if distance_m < LEAST_DISTANCE_M {
            let is_between = from.dot(along) < 0.0 && to.dot(along) > 0.0;
            if !is_between {
                return None;
            }
        }
        Some(Sight {
            wall,
            is_swapped,
            ends,
            normal,
            distance_m: larger(distance_m, LEAST_DISTANCE_M),
            half_tangents,
            is_clipped,
        })
    }
}

/// tan(t / 2) of the bearing of a point; far beyond every lobe from a right angle on.
#[inline]
fn half_tangent(place: Point) -> f32 {
    if place.x > 0.0 {
        place.y / (place.norm() + place.x)
    } else {
        BEHIND.copysign(place.y)
    }
}

/// A measure of 1 / r on the ray at tan(t / 2): larger is nearer.
#[inline]
pub(super) fn inverse_range(sight: &Sight, u: f32) -> f32 {
    ((1.0 - u * u) * sight.normal.x + 2.0 * u * sight.normal.y) / sight.distance_m
}

/// Collects the intervals in which each of several walls is the nearest.
#[inline(never)]
pub(super) fn split(sights: &[Sight], intervals: &mut Intervals) {
    // Two side by side, as in a corridor.
    if let [a, b] = sights
        && let ([from_a, to_a], [from_b, to_b]) = (a.half_tangents, b.half_tangents)
        && (to_a <= from_b || to_b <= from_a)
    {
        let (first, second) = if to_a <= from_b { (0, 1) } else { (1, 0) };
        for place in [first, second] {
            if let Some(sight) = sights.get(place) {
                let [from, to] = sight.half_tangents;
                let sight = place;
                let _ = intervals.push(Interval { sight, from, to });
            }
        }
        return;
    }
    let mut cuts: Vec<f32, { 2 * MAX_WALLS }> = Vec::new();
    for sight in sights {
        for cut in sight.half_tangents {
            insert(&mut cuts, cut);
        }
    }
    for (&from, &to) in cuts.iter().zip(cuts.iter().skip(1)) {
        if to - from <= NARROW {
            continue;
        }
        let middle = 0.5 * (from + to);
        let mut nearest: Option<(usize, f32)> = None;
        for (index, sight) in sights.iter().enumerate() {
            let [first, last] = sight.half_tangents;
            if first < middle && middle < last {
                let inverse = inverse_range(sight, middle);
                if nearest.is_none_or(|(_, most)| inverse > most) {
                    nearest = Some((index, inverse));
                }
            }
        }
        let Some((sight, _)) = nearest else {
            continue;
        };
        match intervals.last_mut() {
            Some(last) if last.sight == sight && from - last.to <= NARROW => last.to = to,
            _ => {
                let _ = intervals.push(Interval { sight, from, to });
            }
        }
    }
}

/// Inserts into numbers in ascending order.
fn insert(cuts: &mut Vec<f32, { 2 * MAX_WALLS }>, cut: f32) {
    let mut carried = cut;
    for held in cuts.iter_mut() {
        if carried < *held {
            core::mem::swap(held, &mut carried);
        }
    }
    let _ = cuts.push(carried);
}
