//! The return of straight walls with ends: the photometric law of extended surfaces.
//!
//! The point law ([`Photometry`]) gives a reading one surface element at one range. A
//! wall fills the lobe of a sensor instead, and all of its elements return light. Under
//! Lambert's law an element at range r returns cos(xi t) cos(i) / r^2, with its bearing t
//! off the axis and the angle of incidence i. A straight wall at perpendicular distance
//! D whose normal has the bearing psi has i = t - psi and r = D / cos(t - psi). Between
//! the bearings t0 and t1 of its ends, clipped to the lobe (+-theta_max), it returns
//!
//! ```text
//! s - beta = alpha / D^2 * [F(t1) - F(t0)] / S0
//! F(t)  = integral of cos(xi t) cos^3(t - psi) dt
//! S0    = integral of cos(xi t) cos^3(t) dt over the lobe
//! ```
//!
//! so that an endless wall across the axis returns alpha / D^2, as a point on the axis
//! does by the point law. Lengths are metres, s and beta counts, alpha counts m^2; delta
//! of the point law is not used. Light counts in the plane only: walls are taken to be
//! higher than the lobe.
//!
//! **Tables.** With c = cos psi and s = sin psi the cube separates:
//!
//! ```text
//! F(t) / S0 = I0 c^3 + I1 c^2 s + I2 c s^2 + I3 s^3
//! Ij(t)     = binomial(3, j) / S0 * integral of cos(xi t) cos^(3-j) t sin^j t dt
//! ```
//!
//! The four Ij are tabulated over u = tan(t / 2) = y / (r + x), which needs no
//! trigonometry. I0 and I2 are odd, I1 and I3 even, so that 65 entries from the axis
//! outward serve both sides.
//!
//! **Several walls.** The bearings of all ends split the lobe into intervals; in each,
//! the nearest wall returns and hides the others. Walls that cross each other are ordered
//! by the middle of the interval.

mod endless;
mod sight;

use self::sight::{Interval, Intervals, NARROW, Sight, Sights, inverse_range, split};
use super::Photometry;
use crate::geometry::Point;
use crate::math;

/// Straight pieces of the tables on each side of the axis.
const PIECES: usize = 64;
/// Most walls that are considered together.
pub const MAX_WALLS: usize = 7;

/// A straight wall: its two ends, in any order.
pub type Wall = [Point; 2];

/// The law of walls for one kind of sensor.
///
/// 1.1 kB. Built once per run with about 70 000 instructions.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedWallLaw {
    /// I0 to I3 at equally spaced tan(t / 2), from the axis outward.
    table: [[f32; 4]; PIECES + 1],
    pieces_per_tangent: f32,
    half_tangent_max: f32,
    tangent_max: f32,
    alpha_counts_m2: f32,
    beta_counts: f32,
}

/// What walls return together, and how it changes as their ends move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallReturn {
    /// Counts above beta.
    pub signal: f32,
    /// Counts per metre that each end of each wall moves, as vectors of the frame that
    /// the walls are given in; zero for ends that are out of view or hidden.
    pub gradient: [[Point; 2]; MAX_WALLS],
}

impl TabulatedWallLaw {
    /// Tabulates the law of `photometry`.
    ///
    /// Error of [`signal`](Self::signal): at most 4e-4 of the return of an endless wall
    /// across the axis at the same perpendicular distance, for 1 <= xi <= 1.45 and
    /// theta_max = 60 degrees.
    #[must_use]
    pub fn of(photometry: &Photometry) -> Self {
        let (sine_max, cosine_max) = math::sin_cos(photometry.theta_max_rad);
        let half_tangent_max = sine_max / (1.0 + cosine_max);
        let spacing = half_tangent_max / PIECES as f32;
        let mut table = [[0.0_f32; 4]; PIECES + 1];
        let mut sum = [0.0_f32; 4];
        for (index, entry) in table.iter_mut().enumerate() {
            if index > 0 {
                add_piece(
                    photometry,
                    (index as f32 - 0.5) * spacing,
                    spacing,
                    &mut sum,
                );
            }
            *entry = sum;
        }
        let [half_lobe, ..] = sum;
        let scale = 0.5 / half_lobe;
        for entry in table.as_flattened_mut() {
            *entry *= scale;
        }
        Self {
            table,
            pieces_per_tangent: 1.0 / spacing,
            half_tangent_max,
            tangent_max: sine_max / cosine_max.max(1e-6),
            alpha_counts_m2: photometry.alpha_counts_m2,
            beta_counts: photometry.beta_counts,
        }
    }

    /// Table, largest tan(t / 2) and alpha, for tests in double precision.
    #[cfg(test)]
    pub(crate) fn parts(&self) -> (&[[f32; 4]], f32, f32) {
        (&self.table, self.half_tangent_max, self.alpha_counts_m2)
    }

    /// Counts that remain when nothing is in range (beta).
    #[must_use]
    #[inline]
    pub fn beta_counts(&self) -> f32 {
        self.beta_counts
    }

    /// Counts above beta of walls given in the sensor's frame: x along the axis, y to its
    /// left, metres.
    ///
    /// Walls beyond [`MAX_WALLS`] are left out. A wall with an end that is no number, or
    /// without a length, returns nothing. Cost: 150 to 300 instructions per wall in view.
    #[must_use]
    #[inline(never)]
    pub fn signal(&self, walls: &[Wall]) -> f32 {
        #[cfg(test)]
        evaluations::count(walls.len());
        let mut sights = Sights::new();
        self.see_all(walls, &mut sights);
        if let [sight] = sights.as_slice() {
            return self.interval_signal(sight, &Interval::whole(sight));
        }
        let mut intervals = Intervals::new();
        split(&sights, &mut intervals);
        intervals.iter().fold(0.0, |sum, interval| {
            sum + sights
                .get(interval.sight)
                .map_or(0.0, |sight| self.interval_signal(sight, interval))
        })
    }

    /// The same with the derivatives for the walls' ends.
    ///
    /// The derivative follows the tables' straight pieces. Where walls overlap, an end
    /// that moves uncovers or hides what is next to it.
    #[must_use]
    #[inline(never)]
    pub fn signal_and_gradient(&self, walls: &[Wall]) -> WallReturn {
        #[cfg(test)]
        evaluations::count(walls.len());
        let mut result = WallReturn {
            signal: 0.0,
            gradient: [[Point::default(); 2]; MAX_WALLS],
        };
        let mut sights = Sights::new();
        self.see_all(walls, &mut sights);
        let mut intervals = Intervals::new();
        if let [sight] = sights.as_slice() {
            let _ = intervals.push(Interval::whole(sight));
        } else {
            split(&sights, &mut intervals);
        }
        for (index, interval) in intervals.iter().enumerate() {
            let Some(sight) = sights.get(interval.sight) else {
                continue;
            };
            let Some(gradient) = result.gradient.get_mut(sight.wall) else {
                continue;
            };
            let (signal, mut ends) = self.interval_gradient(sight, interval);
            result.signal += signal;
            let before = index.checked_sub(1).and_then(|index| intervals.get(index));
            let behind = [
                before.filter(|before| before.to >= interval.from),
                intervals
                    .get(index + 1)
                    .filter(|after| after.from <= interval.to),
            ];
            for (end, behind) in behind.into_iter().enumerate() {
                let behind = behind.and_then(|behind| sights.get(behind.sight));
                self.add_end(sight, interval, end, behind, &mut ends);
            }
            let [first, last] = ends;
            let [own_first, own_last] = gradient;
            if sight.is_swapped {
                *own_first = *own_first + last;
                *own_last = *own_last + first;
            } else {
                *own_first = *own_first + first;
                *own_last = *own_last + last;
            }
        }
        result
    }

    /// I0 to I3 at tan(t / 2) within the lobe, and their slopes there.
    #[inline]
    fn look_up(&self, half_tangent: f32) -> ([f32; 4], [f32; 4]) {
        let place = half_tangent.abs() * self.pieces_per_tangent;
        let index = (place as usize).min(PIECES - 1);
        let share = place - index as f32;
        let Some(&[near, far]) = self
            .table
            .get(index..index + 2)
            .and_then(|two| two.first_chunk())
        else {
            return ([0.0; 4], [0.0; 4]);
        };
        let [r0, r1, r2, r3] = difference(&far, &near);
        let [n0, n1, n2, n3] = near;
        let k = self.pieces_per_tangent;
        let sign = if half_tangent < 0.0 { -1.0 } else { 1.0 };
        (
            [
                sign * (n0 + share * r0),
                n1 + share * r1,
                sign * (n2 + share * r2),
                n3 + share * r3,
            ],
            [k * r0, sign * k * r1, k * r2, sign * k * r3],
        )
    }

    /// alpha / D^2 of a wall.
    fn scale(&self, sight: &Sight) -> f32 {
        self.alpha_counts_m2 / (sight.distance_m * sight.distance_m)
    }

    fn interval_signal(&self, sight: &Sight, interval: &Interval) -> f32 {
        let (from, _) = self.look_up(interval.from);
        let (to, _) = self.look_up(interval.to);
        let Point { x, y } = sight.normal;
        self.scale(sight) * larger(share(&difference(&to, &from), x, y), 0.0)
    }

    /// Signal of an interval between fixed bearings, and its derivatives for the ends of
    /// the wall, which move and turn the wall's line.
    fn interval_gradient(&self, sight: &Sight, interval: &Interval) -> (f32, [Point; 2]) {
        let (from, _) = self.look_up(interval.from);
        let (to, _) = self.look_up(interval.to);
        let values = difference(&to, &from);
        let Point { x: c, y: s } = sight.normal;
        let scale = self.scale(sight);
        let signal = scale * larger(share(&values, c, s), 0.0);
        let [i0, i1, i2, i3] = values;
        let per_turn = scale
            * (-3.0 * i0 * c * c * s
                + i1 * (c * c * c - 2.0 * c * s * s)
                + i2 * (2.0 * c * c * s - s * s * s)
                + 3.0 * i3 * c * s * s);
        let per_distance = -2.0 * signal / sight.distance_m;
        // An end that moves by n along the normal moves the foot of the perpendicular by
        // n a / L and turns the line by n / L, with the other end's distance a from the
        // foot, along the wall.
        let [first, last] = sight.ends;
        let along = Point::new(-s, c);
        let (a, b) = (first.dot(along), last.dot(along));
        let length_m = b - a;
        let of_first = (per_distance * b + per_turn) / length_m;
        let of_last = (-per_distance * a - per_turn) / length_m;
        (
            signal,
            [
                scaled(sight.normal, of_first),
                scaled(sight.normal, of_last),
            ],
        )
    }

    /// Adds what follows from a change of an end's bearing.
    fn add_end(
        &self,
        sight: &Sight,
        interval: &Interval,
        end: usize,
        neighbour: Option<&Sight>,
        ends: &mut [Point; 2],
    ) {
        let own = sight.half_tangents.get(end).zip(sight.is_clipped.get(end));
        let Some((&own, false)) = own.map(|(own, clipped)| (own, *clipped)) else {
            return;
        };
        let (bound, sign) = if end == 0 {
            (interval.from, -1.0)
        } else {
            (interval.to, 1.0)
        };
        // Another wall hides the end itself.
        if (bound - own).abs() > NARROW {
            return;
        }
        let (_, slopes) = self.look_up(own);
        let density = |sight: &Sight| {
            self.scale(sight) * larger(share(&slopes, sight.normal.x, sight.normal.y), 0.0)
        };
        let uncovered = neighbour
            .filter(|other| inverse_range(other, own) < inverse_range(sight, own))
            .map_or(0.0, density);
        let per_half_tangent = sign * (density(sight) - uncovered);
        if let (Some(place), Some(gradient)) = (sight.ends.get(end), ends.get_mut(end)) {
            // du = (1 + u^2) / 2 dt, and dt is the part of the motion across the ray over r.
            let factor = per_half_tangent * 0.5 * (1.0 + own * own) / place.norm_squared();
            *gradient = *gradient + Point::new(-place.y * factor, place.x * factor);
        }
    }
}

/// Adds a piece of the four integrals, centred at tan(t / 2), by Gauss's rule of three.
#[inline(never)]
fn add_piece(photometry: &Photometry, centre: f32, width: f32, sum: &mut [f32; 4]) {
    const NODES: [(f32, f32); 3] = [
        (-0.387_298_33, 5.0 / 18.0),
        (0.0, 8.0 / 18.0),
        (0.387_298_33, 5.0 / 18.0),
    ];
    for (place, weight) in NODES {
        let u = centre + place * width;
        let u2 = u * u;
        let (cosine, sine) = ((1.0 - u2) / (1.0 + u2), 2.0 * u / (1.0 + u2));
        let lobe = photometry.directivity(math::acos(cosine)).unwrap_or(0.0);
        // dt = 2 du / (1 + u^2)
        let element = 2.0 * weight * width * lobe / (1.0 + u2);
        let [s0, s1, s2, s3] = sum;
        *s0 += element * cosine * cosine * cosine;
        *s1 += element * 3.0 * cosine * cosine * sine;
        *s2 += element * 3.0 * cosine * sine * sine;
        *s3 += element * sine * sine * sine;
    }
}

/// I0 c^3 + I1 c^2 s + I2 c s^2 + I3 s^3.
#[inline]
fn share(&[i0, i1, i2, i3]: &[f32; 4], c: f32, s: f32) -> f32 {
    ((i0 * c + i1 * s) * c + i2 * s * s) * c + i3 * s * s * s
}

#[inline]
fn difference(&[a0, a1, a2, a3]: &[f32; 4], &[b0, b1, b2, b3]: &[f32; 4]) -> [f32; 4] {
    [a0 - b0, a1 - b1, a2 - b2, a3 - b3]
}

/// The larger of two numbers, the second for what is none.
///
/// The target has no instruction for `f32::max`: it calls a function of 25 instructions.
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, the second for what is none.
#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn scaled(a: Point, factor: f32) -> Point {
    Point::new(a.x * factor, a.y * factor)
}

/// Counts evaluations of the law, for tests of what a step costs.
#[cfg(test)]
pub(crate) mod evaluations {
    use core::cell::Cell;

    std::thread_local! {
        static WALLS: Cell<usize> = const { Cell::new(0) };
    }

    pub(super) fn count(walls: usize) {
        WALLS.set(WALLS.get() + walls);
    }

    /// Walls of all evaluations in this thread since the last call.
    pub(crate) fn take() -> usize {
        WALLS.replace(0)
    }
}

#[cfg(test)]
mod tests;
