//! The return of straight walls with ends into the lobe of a reflective infrared sensor.
//!
//! A Lambert surface returns, per bearing t off the sensor's axis, light in proportion to
//! cos(xi t) cos(i) / d^2, with its distance d and the angle of incidence i. Let D be the
//! perpendicular distance of a straight wall and psi the bearing of its normal, which
//! points from the sensor to the wall. Then d = D / cos(t - psi) and i = t - psi, and the
//! part of the wall between two bearings returns
//!
//! ```text
//! s           = alpha / S0 (F(t1, psi) - F(t0, psi)) / D^2
//! F(t, psi)   = int cos(xi t) cos^3(t - psi) dt  =  0.375 A1 + 0.125 A3
//! Ak          = sin((xi + k) t - k psi) / (xi + k) + sin((xi - k) t + k psi) / (xi - k)
//! S0          = F(t_max, 0) - F(-t_max, 0)
//! ```
//!
//! with the counts s above the sensor's dark value. The ends' bearings are clipped to the
//! lobe, +-t_max. An endless wall across the axis returns alpha / D^2: the law of
//! [`Photometry`] on the axis, without its delta.
//!
//! **Several walls.** The bearings are split at all ends, and where two walls cross; the
//! nearest wall counts in each piece. Occlusion is exact for straight walls.
//!
//! **Derivatives.** For fixed bearings, an end that moves by v changes
//!
//! ```text
//! dD   = n.v u' / (u' - u)        dpsi = n.v / (u' - u)
//! dt   = (x v_y - y v_x) / d^2    for the bearing of the end itself
//! ```
//!
//! with the normal n and the places u of this end and u' of the other one along the wall,
//! from the foot of the perpendicular. A bearing that separates two pieces moves return
//! from one to the other: it adds the difference of their densities times dt.

mod seen;
#[cfg(test)]
mod tests;

use amiro_ipf::model::Photometry;

use self::seen::{Cut, LEAST_PIECE_RAD, Mover, Seen, nearest};
use crate::geometry::{Pose2, Vector};

/// Least distance of xi from 1 and from 3, where the closed form divides by zero.
const LEAST_DIVISOR: f64 = 1e-6;

/// A straight wall between two ends, seen from either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallSegment {
    /// One end, metres.
    pub from: Vector,
    /// The other end, metres.
    pub to: Vector,
}

/// The derivatives of a return by the ends of a segment, counts per metre: by x and y of
/// `from`, then by x and y of `to`.
pub type EndGradient = [f64; 4];

/// The law of straight walls for one kind of sensor and surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLaw {
    /// alpha / S0, counts m^2.
    gain_counts_m2: f64,
    xi: f64,
    /// Half width of the lobe, radians (t_max).
    edge_rad: f64,
}

impl WallSegment {
    /// The segment between two ends.
    #[must_use]
    pub const fn new(from: Vector, to: Vector) -> Self {
        Self { from, to }
    }

    /// Length, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The place at a share of the way between the ends.
    #[must_use]
    pub fn at(&self, share: f64) -> Vector {
        self.from + (self.to - self.from).scaled(share)
    }

    /// The same segment of the outer frame in the inner one.
    #[must_use]
    pub fn viewed_from(&self, outer_from_inner: &Pose2) -> Self {
        Self::new(
            outer_from_inner.view(self.from),
            outer_from_inner.view(self.to),
        )
    }
}

/// Antiderivative F(t, psi) and its derivative by psi.
fn antiderivative(xi: f64, bearing_rad: f64, psi: f64) -> [f64; 2] {
    let mut value = [0.0; 2];
    for (k, share) in [(1.0, 0.375), (3.0, 0.125)] {
        let (sine_sum, cosine_sum) = libm::sincos((xi + k) * bearing_rad - k * psi);
        let (sine_less, cosine_less) = libm::sincos((xi - k) * bearing_rad + k * psi);
        let [f, by_psi] = &mut value;
        *f += share * (sine_sum / (xi + k) + sine_less / (xi - k));
        *by_psi += share * k * (cosine_less / (xi - k) - cosine_sum / (xi + k));
    }
    value
}

impl WallLaw {
    /// The law of a sensor: its alpha, xi and the half width of its lobe.
    ///
    /// The lobe ends at `theta_max_rad`, or where cos(xi t) is zero if that is nearer. Its
    /// delta is not part of this law. A xi within 1e-6 of 1 or 3 is moved to that distance,
    /// which changes the return by less than 1e-6 of itself.
    #[must_use]
    pub fn new(photometry: &Photometry) -> Self {
        Self::of_lobe(
            f64::from(photometry.alpha_counts_m2),
            f64::from(photometry.xi),
            f64::from(photometry.theta_max_rad),
        )
    }

    /// The same law from its numbers: alpha in counts m^2, xi, and the largest bearing of
    /// the lobe in radians.
    #[must_use]
    pub fn of_lobe(alpha_counts_m2: f64, xi: f64, theta_max_rad: f64) -> Self {
        let mut xi = xi;
        for pole in [1.0, 3.0] {
            if (xi - pole).abs() < LEAST_DIVISOR {
                xi = pole + LEAST_DIVISOR;
            }
        }
        let closes_at = core::f64::consts::FRAC_PI_2 / xi;
        let edge_rad = theta_max_rad.min(closes_at);
        let [high, _] = antiderivative(xi, edge_rad, 0.0);
        let [low, _] = antiderivative(xi, -edge_rad, 0.0);
        Self {
            gain_counts_m2: alpha_counts_m2 / (high - low),
            xi,
            edge_rad,
        }
    }

    /// Counts above the dark value that an endless wall returns: alpha G(psi) / D^2, with
    /// its perpendicular distance D in metres and the bearing psi of its normal.
    #[must_use]
    pub fn endless_wall_counts(&self, distance_m: f64, normal_rad: f64) -> f64 {
        let seen = core::f64::consts::FRAC_PI_2;
        let low_rad = (normal_rad - seen).max(-self.edge_rad);
        let high_rad = (normal_rad + seen).min(self.edge_rad);
        if high_rad <= low_rad {
            return 0.0;
        }
        let [above, _] = antiderivative(self.xi, high_rad, normal_rad);
        let [below, _] = antiderivative(self.xi, low_rad, normal_rad);
        self.gain_counts_m2 * (above - below) / (distance_m * distance_m)
    }

    /// Half width of the lobe, radians.
    #[must_use]
    pub fn edge_rad(&self) -> f64 {
        self.edge_rad
    }

    /// Counts that a bearing's width of a surface returns: per radian, at a distance, with
    /// light that falls on it square.
    #[must_use]
    pub fn facing_counts_per_rad(&self, bearing_rad: f64, distance_m: f64) -> f64 {
        let lobe = libm::cos(self.xi * bearing_rad).max(0.0);
        self.gain_counts_m2 * lobe / (distance_m * distance_m)
    }

    /// Counts above the dark value that segments return; they are in the sensor's frame,
    /// whose x is its axis.
    ///
    /// Cost: for n segments in view 4 sines and cosines for each of up to n (n + 3) cuts;
    /// two for a single one.
    #[must_use]
    pub fn signal(&self, segments: &[WallSegment]) -> f64 {
        let mut sum = 0.0;
        let seen = self.seen(segments);
        self.pieces(&seen, |owner, low, high| {
            let [above, _] = antiderivative(self.xi, high.bearing_rad, owner.psi);
            let [below, _] = antiderivative(self.xi, low.bearing_rad, owner.psi);
            sum += (above - below) / (owner.distance_m * owner.distance_m);
        });
        self.gain_counts_m2 * sum
    }

    /// The same, with the derivatives by the ends of each segment, added to `gradients`:
    /// one for each segment, of those that are missing nothing is said.
    ///
    /// Where the order of the ends' bearings changes the return has a corner, and these are
    /// the derivatives on one side of it.
    pub fn linearised(&self, segments: &[WallSegment], gradients: &mut [EndGradient]) -> f64 {
        let mut sum = 0.0;
        let seen = self.seen(segments);
        let gain = self.gain_counts_m2;
        self.pieces(&seen, |owner, low, high| {
            let [above, above_by_psi] = antiderivative(self.xi, high.bearing_rad, owner.psi);
            let [below, below_by_psi] = antiderivative(self.xi, low.bearing_rad, owner.psi);
            let squared = owner.distance_m * owner.distance_m;
            let part = (above - below) / squared;
            sum += part;
            let by_distance = -2.0 * part / owner.distance_m;
            let by_psi = (above_by_psi - below_by_psi) / squared;
            add(
                gradients,
                owner.index,
                &owner.distance_by_ends,
                gain * by_distance,
            );
            add(gradients, owner.index, &owner.psi_by_ends, gain * by_psi);
            for (cut, sign) in [(high, gain), (low, -gain)] {
                let density = sign * owner.density(self.xi, cut.bearing_rad);
                move_cut(segments, &seen, cut, density, gradients);
            }
        });
        gain * sum
    }

    fn seen(&self, segments: &[WallSegment]) -> Vec<Seen> {
        let all = segments.iter().enumerate();
        all.filter_map(|(index, segment)| Seen::of(index, segment, self.edge_rad))
            .collect()
    }

    /// Calls back with each piece of the lobe in which one segment is the nearest.
    fn pieces(&self, seen: &[Seen], mut piece: impl FnMut(&Seen, &Cut, &Cut)) {
        if let [only] = seen {
            return piece(only, &only.low, &only.high);
        }
        let mut cuts: Vec<Cut> = seen.iter().flat_map(|one| [one.low, one.high]).collect();
        for (first, one) in seen.iter().enumerate() {
            for (second, other) in seen.iter().enumerate().skip(first + 1) {
                cuts.extend(one.crossing(other).map(|bearing_rad| Cut {
                    bearing_rad,
                    moved_by: Mover::Crossing(first, second),
                }));
            }
        }
        cuts.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        // A piece goes on as long as its segment stays the nearest.
        let mut open: Option<(&Seen, Cut)> = None;
        let mut before: Option<Cut> = None;
        for cut in cuts {
            if let Some(last) =
                before.filter(|last| cut.bearing_rad - last.bearing_rad >= LEAST_PIECE_RAD)
            {
                let nearest = nearest(seen, 0.5 * (last.bearing_rad + cut.bearing_rad));
                let goes_on = match (&open, nearest) {
                    (Some((owner, _)), Some(nearest)) => owner.index == nearest.index,
                    (None, None) => true,
                    _ => false,
                };
                if !goes_on {
                    if let Some((owner, begun)) = open {
                        piece(owner, &begun, &last);
                    }
                    open = nearest.map(|nearest| (nearest, last));
                }
            }
            before = Some(cut);
        }
        if let (Some((owner, begun)), Some(last)) = (open, before) {
            piece(owner, &begun, &last);
        }
    }
}

fn add(gradients: &mut [EndGradient], index: usize, by_ends: &EndGradient, factor: f64) {
    if let Some(gradient) = gradients.get_mut(index) {
        for (slot, value) in gradient.iter_mut().zip(by_ends) {
            *slot += factor * value;
        }
    }
}

/// Adds what a cut that moves does to a piece with the given density beside the cut.
fn move_cut(
    segments: &[WallSegment],
    seen: &[Seen],
    cut: &Cut,
    density: f64,
    gradients: &mut [EndGradient],
) {
    match cut.moved_by {
        Mover::Lobe => {}
        Mover::End(index, is_to) => {
            let Some(segment) = segments.get(index) else {
                return;
            };
            let end = if is_to { segment.to } else { segment.from };
            let squared = end.dot(end);
            let by_end = [-end.y / squared, end.x / squared];
            let [x, y] = by_end;
            let by_ends = if is_to {
                [0.0, 0.0, x, y]
            } else {
                [x, y, 0.0, 0.0]
            };
            add(gradients, index, &by_ends, density);
        }
        Mover::Crossing(first, second) => {
            let (Some(first), Some(second)) = (seen.get(first), seen.get(second)) else {
                return;
            };
            let (sine, cosine) = libm::sincos(cut.bearing_rad);
            let across = Vector::new(-sine, cosine);
            let slope = (first.reciprocal() - second.reciprocal()).dot(across);
            let direction = Vector::new(cosine, sine);
            let factor = -density / slope;
            let by_ends = first.reciprocal_by_ends(direction);
            add(gradients, first.index, &by_ends, factor);
            let by_ends = second.reciprocal_by_ends(direction);
            add(gradients, second.index, &by_ends, -factor);
        }
    }
}
