//! The law of an endless wall, and its inverse.

use super::sight::{BEHIND, LEAST_DISTANCE_M};
use super::{TabulatedWallLaw, difference, share};
use crate::math;

impl TabulatedWallLaw {
    /// G(psi): return of an endless wall whose normal is psi off the axis, as a share of
    /// that of one across the axis at the same distance; even in psi.
    #[must_use]
    pub fn endless_share(&self, normal_rad: f32) -> f32 {
        let (sine, cosine) = math::sin_cos(normal_rad);
        // Only what lies before the sensor: bearings within 90 degrees of the normal.
        let side = |limit: f32| {
            let (x, y) = (-sine * limit, cosine * limit);
            // tan(t / 2) of the wall's direction, cut at the lobe's edge.
            let tangent = if x > 0.0 {
                y / (1.0 + x)
            } else {
                BEHIND * limit
            };
            tangent
                .max(-self.half_tangent_max)
                .min(self.half_tangent_max)
        };
        let (from, _) = self.look_up(side(-1.0));
        let (to, _) = self.look_up(side(1.0));
        share(&difference(&to, &from), cosine, sine).max(0.0)
    }

    /// Counts above beta of an endless wall at a perpendicular distance, metres, whose
    /// normal is psi off the axis: alpha G(psi) / D^2.
    #[must_use]
    pub fn endless_signal(&self, distance_m: f32, normal_rad: f32) -> f32 {
        let distance_m = distance_m.max(LEAST_DISTANCE_M);
        self.alpha_counts_m2 * self.endless_share(normal_rad) / (distance_m * distance_m)
    }

    /// Perpendicular distance of an endless wall that returns the given counts, metres:
    /// D = sqrt(alpha G(psi) / (s - beta)).
    ///
    /// `None` for counts not above beta and for a wall out of the lobe.
    #[must_use]
    pub fn endless_distance_m(&self, counts: f32, normal_rad: f32) -> Option<f32> {
        let signal = counts - self.beta_counts;
        let squared = self.alpha_counts_m2 * self.endless_share(normal_rad) / signal;
        (signal > 0.0 && squared > 0.0 && squared.is_finite()).then(|| math::sqrt(squared))
    }
}
