//! The counts of one step.

use super::Outcome;
use crate::geometry::Point;

/// What a step did, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tally {
    /// Particles that were weighed; each has exactly one outcome.
    pub live: u32,
    /// Outcomes "survived past the gate".
    pub past_gate: u32,
    /// Outcomes "survived below the gate".
    pub below_gate: u32,
    /// Outcomes "rejected, free".
    pub free: u32,
    /// Outcomes "rejected, unobserved".
    pub unobserved: u32,
    /// Particles that left the local radius: removed, without an outcome.
    pub departed: u32,
    /// Sum of the weights, 65535 for 1; below 2^32 up to 65 537 particles. Zero with
    /// live particles is the degenerate set: no particle survives, all are redrawn.
    pub weight_sum: u32,
    /// The particle past the gate that is nearest to the robot's centre, body frame.
    pub nearest: Option<Point>,
}

impl Tally {
    /// Particles that survived the step.
    #[must_use]
    pub fn survived(&self) -> u32 {
        self.past_gate + self.below_gate
    }

    /// Counts a weighed particle and adds its weight to the sum.
    #[inline]
    pub(super) fn add_weight(&mut self, weight: u16) {
        self.live += 1;
        self.weight_sum = self.weight_sum.saturating_add(u32::from(weight));
    }

    /// Counts the outcome of a particle at `position`.
    #[inline]
    pub(super) fn count(&mut self, outcome: Outcome, position: Point) {
        match outcome {
            Outcome::SurvivedPastGate => {
                self.past_gate += 1;
                let is_nearer = self
                    .nearest
                    .is_none_or(|nearest| position.norm_squared() < nearest.norm_squared());
                if is_nearer {
                    self.nearest = Some(position);
                }
            }
            Outcome::SurvivedBelowGate => self.below_gate += 1,
            Outcome::RejectedFree => self.free += 1,
            Outcome::RejectedUnobserved => self.unobserved += 1,
        }
    }
}
