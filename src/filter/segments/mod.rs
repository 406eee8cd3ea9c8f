//! Wall segments with ends, fitted to all readings of the last few steps.
//!
//! The particles take each reading by itself. A wall shows itself in several sensors and
//! several steps at once: [`SegmentTracker`] keeps at most [`MAX_SEGMENTS`] straight
//! segments g = (x0, y0, x1, y1) and minimises, with the law of walls
//! ([`TabulatedWallLaw`](crate::model::TabulatedWallLaw)) and occlusion between the segments,
//!
//! ```text
//! cost    sum of rho(r) over the readings of the window + priors of the segments
//! r       (ln(d + d0) - ln(s(g) + d0)) / sd,   d counts above beta, s(g) the law's
//! sd^2    (sigma / (d + d0))^2 + rel^2
//! rho(r)  r^2 for |r| < 3, else 6 |r| - 9 (Huber)
//! priors  (g - m)' A (g - m) + ((length - 0.2 m) / 0.3 m)^2
//! ```
//!
//! Costs are squared deviations in units of their standard deviation (chi^2). The
//! logarithm makes the error of the gain, which is proportional to the signal, a constant
//! one; d0 keeps it finite where nothing is seen.
//!
//! A step, in this order:
//!
//! 1. **Motion.** All positions are relative to the robot's centre and move against it.
//! 2. **Fold.** The readings that leave the window become the priors of the segments:
//!    A = 0.98 A + J'J with the derivatives J, and m follows from J'r. What the readings
//!    say about two segments together is lost (A is block diagonal). The cost that a
//!    segment has saved at these readings is added to its evidence.
//! 3. **Reach.** Segments beyond the sensors' reach are frozen, or forgotten if there is
//!    little evidence; near again, they are revived.
//! 4. **Fit.** One Gauss-Newton iteration over all segments together in a step of at most
//!    20 mm without new segments, and in one in which a birth joins; otherwise at most three
//!    Levenberg-Marquardt iterations, fewer when the cost no longer changes. The equations
//!    at a place give its cost as well, so that an iteration evaluates each reading once,
//!    or twice if the cost has risen.
//! 5. **Hull.** The part of a segment that the robot stands on is cut off.
//! 6. **Upkeep**, every third step: the segment with the least evidence is dropped, unless
//!    its evidence is beyond doubt, and the merge of one collinear pair is tried.
//! 7. **Birth**, in steps that tried no merge: one part of at most one birth. It ranks
//!    candidates for the sensor with the most unexplained signal, in the next step fits
//!    the best three alone, and in the next fits the best one together with the others.
//!    After a failure it pauses for four short steps.
//!
//! **Frame.** The origin is the robot's centre, the axes keep the direction that the
//! body had at the start. Coordinates stay below the reach, so `f32` resolves 3e-8 m
//! after any distance; a motion is one subtraction, and the priors, which are matrices,
//! are never turned. The heading is the sum of the turns, as in the odometry.
//!
//! **Time.** All loops are bounded by the constants here and by [`SegmentParameters`].
//! The unit is a wall in an evaluation of the law; with R = 40 readings and S = 6 segments
//! a step takes at most 8 S^2 (fold) + 7 R S (fit) + R S^2 (drop) and the most of 9 R S
//! (merge), 84 (R + 4) + R S + 24 S (rank), 22 R S (fit alone) and 14 R S (join); the test
//! `a_step_evaluates_the_law_no_more_often_than_its_stages_allow` counts them. Walls
//! beyond the lobe cost a rotation and two comparisons.

mod birth;
mod claims;
mod fit;
mod linear;
mod parameters;
mod rank;
mod segment;
mod tracker;
mod upkeep;
mod window;

#[cfg(test)]
mod precision {
    mod tests;
}
#[cfg(test)]
mod tests;

pub(crate) use claims::SeenSegment;
pub use parameters::SegmentParameters;
pub use segment::{EndSigma, TrackedSegment};
pub use tracker::{SegmentModel, SegmentTracker};

/// Most segments that are tracked, frozen ones included.
pub const MAX_SEGMENTS: usize = 6;
/// Most steps of the window.
pub const MAX_WINDOW: usize = 5;
