//! New segments where a sensor has more signal than the segments explain.

use super::fit::{SegmentFit, WallSegments, seen};
use super::segment::{WallSegment, distance_m};
use super::window::{Placed, huber};
use super::{MAX_SEGMENTS, MAX_WINDOW};
use crate::geometry::Point;
use crate::math;
use crate::model::{SENSORS, Wall};

/// Bearings of a candidate's normal off the sensor's axis, degrees.
const NORMALS_DEG: [f32; 7] = [0.0, -22.5, 22.5, -45.0, 45.0, -67.5, 67.5];
/// Bearings of a candidate's middle, degrees.
const BEARINGS_DEG: [f32; 4] = [-15.0, 15.0, -40.0, 40.0];
/// Lengths of candidates, metres.
const LENGTHS_M: [f32; 3] = [0.04, 0.10, 0.22];
/// Candidates that are fitted.
const FINALISTS: usize = 3;
/// Least cosine between a candidate's normal and the ray to its middle.
const LEAST_COSINE: f32 = 0.2;
/// Steps of the search for a candidate's distance.
const DISTANCE_STEPS: usize = 4;

/// Signals of the segments at the readings of the window, in their order.
type Signals = [f32; MAX_WINDOW * SENSORS];

impl SegmentFit<'_> {
    /// Tries to explain the sensor with the most unexplained signal by a new segment;
    /// whether one was added.
    #[inline(never)]
    pub(super) fn give_birth(&self, segments: &mut WallSegments, id: u16) -> bool {
        let Some((placed, missing)) = self.unexplained(segments) else {
            return false;
        };
        let signals = self.signals(segments);
        let mut finalists: [Option<(f32, Wall)>; FINALISTS] = [None; FINALISTS];
        for normal in NORMALS_DEG {
            for bearing in BEARINGS_DEG {
                for length_m in LENGTHS_M {
                    let candidate = BirthPlace {
                        normal_rad: normal.to_radians(),
                        bearing_rad: bearing.to_radians(),
                        length_m,
                    };
                    let wall = self.placed_candidate(&candidate, &placed, missing);
                    if let Some(wall) = wall {
                        insert(&mut finalists, self.cost_with(&signals, &wall), wall);
                    }
                }
            }
        }
        let before = self.cost(segments);
        let mut best: Option<(f32, WallSegments)> = None;
        for (_, wall) in finalists.into_iter().flatten() {
            let mut with = segments.clone();
            if with.push(WallSegment::new(id, wall)).is_err() {
                return false;
            }
            let cost = self.refine(&mut with, self.model.parameters.birth_iterations);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, with));
            }
        }
        match best {
            Some((cost, with)) if before - cost > self.model.parameters.birth_gain => {
                *segments = with;
                true
            }
            _ => false,
        }
    }

    /// The sensor with the most unexplained chi^2 over the last steps, where it is now,
    /// and its missing signal.
    #[inline(never)]
    fn unexplained(&self, segments: &[WallSegment]) -> Option<(Placed, f32)> {
        let parameters = &self.model.parameters;
        let newest = self.rows.last()?;
        let steps = usize::from(parameters.unexplained_steps);
        let mut most: Option<(f32, Placed, f32)> = None;
        for (sensor, mount) in self.model.mounts.iter().enumerate() {
            let mut sum = 0.0;
            let mut missing = 0.0;
            for row in self.rows.iter().rev().take(steps) {
                let Some(measured) = row.measured.get(sensor) else {
                    continue;
                };
                if measured.inverse_sigma <= 0.0 {
                    continue;
                }
                let placed = row.place(mount);
                let signal = self.model.law.signal(&seen(&placed, segments, None));
                let residual = measured.residual(signal, parameters).max(0.0);
                sum += residual * residual;
                if core::ptr::eq(row, newest) {
                    missing = measured.signal - signal;
                }
            }
            let is_most = most.is_none_or(|(other, ..)| sum > other);
            if sum > parameters.unexplained && missing > 0.0 && is_most {
                most = Some((sum, newest.place(mount), missing));
            }
        }
        most.map(|(_, placed, missing)| (placed, missing))
    }

    #[inline(never)]
    fn signals(&self, segments: &[WallSegment]) -> Signals {
        let mut signals = [0.0; MAX_WINDOW * SENSORS];
        for (held, (placed, _)) in signals.iter_mut().zip(self.readings()) {
            *held = self.model.law.signal(&seen(&placed, segments, None));
        }
        signals
    }

    /// Cost of the readings with a wall more, which hides nothing and is not hidden.
    #[inline(never)]
    fn cost_with(&self, signals: &Signals, wall: &Wall) -> f32 {
        let parameters = &self.model.parameters;
        let readings = self.readings().zip(signals);
        readings.fold(0.0, |sum, ((placed, measured), signal)| {
            let signal = signal + self.model.law.signal(&[placed.see(wall)]);
            sum + huber(measured.residual(signal, parameters), parameters.huber).0
        })
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
            let signal = law.signal(&[candidate.wall(distance)?]);
            distance *= math::sqrt(signal / missing).clamp(0.5, 1.5);
        }
        let ends = candidate.wall(distance)?;
        let wall = ends.map(|end| placed.position + end.rotated(placed.axis));
        let is_clear = self.rows.iter().all(|row| {
            let off = wall.map(|end| end - row.position);
            distance_m(&off, Point::default()) > parameters.hull_m
        });
        let is_near = distance_m(&wall, Point::default()) < parameters.reach_m;
        (is_clear && is_near).then_some(wall)
    }
}

/// The form of a new segment in the frame of its sensor, without its distance.
struct BirthPlace {
    normal_rad: f32,
    bearing_rad: f32,
    length_m: f32,
}

impl BirthPlace {
    /// The wall at a perpendicular distance.
    fn wall(&self, distance_m: f32) -> Option<Wall> {
        let (s, c) = math::sin_cos(self.normal_rad);
        let (sine, cosine) = math::sin_cos(self.bearing_rad);
        let incidence = c * cosine + s * sine;
        if incidence < LEAST_COSINE {
            return None;
        }
        let range = distance_m / incidence;
        let middle = Point::new(range * cosine, range * sine);
        let half = 0.5 * self.length_m;
        let half = Point::new(-half * s, half * c);
        Some([middle - half, middle + half])
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

/// Whether there is a place for a new segment; the frozen one with the least evidence
/// makes room, which is then returned.
pub(super) fn make_room(segments: &mut WallSegments) -> Result<Option<WallSegment>, ()> {
    if segments.len() < MAX_SEGMENTS {
        return Ok(None);
    }
    let frozen = segments.iter().enumerate().filter(|(_, s)| s.is_frozen);
    let least = frozen.min_by(|(_, a), (_, b)| a.evidence.total_cmp(&b.evidence));
    let index = least.map(|(index, _)| index).ok_or(())?;
    Ok(take(segments, index))
}

/// Takes a segment out; the order of the others stays.
#[inline(never)]
pub(super) fn take(segments: &mut WallSegments, index: usize) -> Option<WallSegment> {
    let taken = segments.get(index).copied();
    let mut place = 0;
    segments.retain(|_| {
        place += 1;
        place != index + 1
    });
    taken
}
