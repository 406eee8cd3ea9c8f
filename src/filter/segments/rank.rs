//! The ranking of candidates for a new segment.

use super::birth::{ExplainedReadings, FINALISTS};
use super::fit::SegmentFit;
use super::segment::distance_m;
use super::window::{Placed, huber};
use crate::geometry::Point;
use crate::math;
use crate::model::Wall;

/// Bearings of a candidate's normal off the sensor's axis, degrees.
const NORMALS_DEG: [f32; 7] = [0.0, -22.5, 22.5, -45.0, 45.0, -67.5, 67.5];
/// Bearings of a candidate's middle, degrees.
const BEARINGS_DEG: [f32; 4] = [-15.0, 15.0, -40.0, 40.0];
/// Lengths of candidates, metres.
const LENGTHS_M: [f32; 3] = [0.04, 0.10, 0.22];
/// Least cosine between a candidate's normal and the ray to its middle.
const LEAST_COSINE: f32 = 0.2;
/// Steps of the search for a candidate's distance, and the relative error of the signal
/// at which it ends.
const DISTANCE_STEPS: usize = 4;
const DISTANCE_ERROR: f32 = 0.02;

/// The best candidates and the change of the cost by each, the best first.
type Finalists = [Option<(f32, Wall)>; FINALISTS];

impl SegmentFit<'_> {
    /// The best candidates.
    #[inline(never)]
    pub(super) fn rank(
        &self,
        readings: &ExplainedReadings<'_>,
        placed: &Placed,
        missing: f32,
    ) -> Finalists {
        let mut finalists = [None; FINALISTS];
        for normal in NORMALS_DEG {
            let normal = math::sin_cos(normal.to_radians());
            for bearing in BEARINGS_DEG {
                let bearing = math::sin_cos(bearing.to_radians());
                for length_m in LENGTHS_M {
                    let wall = BirthPlace::of(normal, bearing, length_m)
                        .and_then(|place| self.placed_candidate(&place, placed, missing));
                    if let Some(wall) = wall {
                        insert(&mut finalists, self.change_by(readings, &wall), wall);
                    }
                }
            }
        }
        finalists
    }

    /// Change of the cost by a wall more, which hides nothing and is not hidden.
    #[inline(never)]
    fn change_by(&self, readings: &ExplainedReadings<'_>, wall: &Wall) -> f32 {
        let parameters = &self.model.parameters;
        let law = &self.model.law;
        let mut change = 0.0;
        for reading in readings {
            let seen = reading.placed.see(wall);
            if law.may_see(&seen) {
                let signal = reading.signal + law.signal(&[seen]);
                let residual = reading.measured.residual(signal, parameters);
                change += huber(residual, parameters.huber).0 - reading.cost;
            }
        }
        change
    }

    /// A candidate at the distance at which it returns the missing signal; `None` if that
    /// is out of reach or under the robot.
    #[inline(never)]
    fn placed_candidate(
        &self,
        candidate: &BirthPlace,
        placed: &Placed,
        missing: f32,
    ) -> Option<Wall> {
        let law = &self.model.law;
        let parameters = &self.model.parameters;
        let mut distance = law.endless_distance_m(missing + law.beta_counts(), 0.0)?;
        for _ in 0..DISTANCE_STEPS {
            let ratio = law.signal(&[candidate.wall(distance)]) / missing;
            distance *= math::sqrt(ratio).clamp(0.5, 1.5);
            if (ratio - 1.0).abs() < DISTANCE_ERROR {
                break;
            }
        }
        let ends = candidate.wall(distance);
        let wall = ends.map(|end| placed.position + end.rotated(placed.axis));
        let is_near = distance_m(&wall, Point::default()) < parameters.reach_m;
        let is_clear = || {
            self.rows.iter().all(|row| {
                let off = wall.map(|end| end - row.position);
                distance_m(&off, Point::default()) > parameters.hull_m
            })
        };
        (is_near && is_clear()).then_some(wall)
    }
}

/// The form of a new segment in the frame of its sensor, without its distance.
struct BirthPlace {
    /// The middle at a perpendicular distance of 1 m.
    middle: Point,
    /// From the middle to the second end, metres.
    half: Point,
}

impl BirthPlace {
    /// With sine and cosine of the bearings of the normal and of the middle; `None` where
    /// the sensor would see it from its end.
    fn of(normal: (f32, f32), bearing: (f32, f32), length_m: f32) -> Option<Self> {
        let ((s, c), (sine, cosine)) = (normal, bearing);
        let incidence = c * cosine + s * sine;
        let half = 0.5 * length_m;
        (incidence >= LEAST_COSINE).then(|| Self {
            middle: Point::new(cosine / incidence, sine / incidence),
            half: Point::new(-half * s, half * c),
        })
    }

    /// The wall at a perpendicular distance.
    fn wall(&self, distance_m: f32) -> Wall {
        let middle = Point::new(distance_m * self.middle.x, distance_m * self.middle.y);
        [middle - self.half, middle + self.half]
    }
}

/// Puts a candidate among the best, the best first.
fn insert(finalists: &mut [Option<(f32, Wall)>; FINALISTS], cost: f32, wall: Wall) {
    let mut entry = Some((cost, wall));
    for held in finalists {
        let is_better = match (&entry, &held) {
            (Some((cost, _)), Some((other, _))) => cost < other,
            (Some((cost, _)), None) => cost.is_finite(),
            (None, _) => false,
        };
        if is_better {
            core::mem::swap(held, &mut entry);
        }
    }
}
