//! The wall segments of a drive, with those that are no longer tracked.

use std::collections::BTreeMap;

use amiro_ipf::filter::{SegmentTracker, TrackedSegment};
use amiro_ipf::geometry::Pose;
use amiro_ipf::node::Walls;
use serde::Serialize;

use crate::geometry::Vector;

/// Segments that are kept after they were tracked: 16 MB.
const MAX_PAST: usize = 100_000;

/// Distance beyond which a segment is another one of the same number, metres: a step
/// moves a segment by millimetres, and messages that are lost do not move it.
const ELSEWHERE_M: f64 = 0.2;

/// A half millimetre, the unit of the messages.
const UNIT_M: f64 = 0.0005;

/// Place and certainty of a wall segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallState {
    /// The ends in the world, metres.
    pub ends: [Vector; 2],
    /// Standard deviation of each end along the segment, metres; `None` if it is open.
    pub along_m: [Option<f64>; 2],
    /// The same across the segment.
    pub across_m: [Option<f64>; 2],
    /// Cost that the segment has saved (chi^2).
    pub evidence: f64,
}

impl WallState {
    /// A tracked segment in the world of a robot's pose.
    #[must_use]
    pub fn of(tracker: &SegmentTracker, segment: &TrackedSegment, pose: &Pose) -> Self {
        let sigmas = segment.end_sigmas();
        let finite = |metres: f32| metres.is_finite().then_some(f64::from(metres));
        let place = |end| Vector::from(pose.world_from_body(tracker.body_from_track(end)));
        Self {
            ends: segment.ends().map(place),
            along_m: sigmas.map(|end| finite(end.along_m)),
            across_m: sigmas.map(|end| finite(end.across_m)),
            evidence: f64::from(segment.evidence()),
        }
    }
}

/// The step of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WallStep {
    /// Steps since the configuration, from 0.
    pub index: u32,
    /// Stamp of the readings, microseconds, if it is known.
    pub stamp_us: Option<u64>,
}

/// What became of a wall segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallFate {
    /// It is within reach of the sensors.
    Tracked,
    /// It is out of reach, and tracked again when the robot comes back.
    OutOfReach,
    /// It stays where it was; if the robot comes back it is found anew.
    LeftBehind,
    /// The readings did not need it, or another segment took its place.
    GivenUp,
}

/// A wall segment with its last state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownWall {
    /// The tracker's number, which a later segment may have again.
    pub id: u16,
    /// When it was last within reach.
    pub state: WallState,
    /// The step that found it.
    pub first: WallStep,
    /// The step of the state.
    pub last: WallStep,
    /// What became of it.
    pub fate: WallFate,
}

/// Follows the segments of a tracker, or of its messages, over a drive.
#[derive(Clone, Debug)]
pub struct KnownWalls {
    least_evidence: f64,
    tracked: BTreeMap<u16, KnownWall>,
    past: Vec<KnownWall>,
    refused: u64,
    last_index: Option<u32>,
}

impl KnownWalls {
    /// No segments. The evidence is the least of a segment that counts as left behind
    /// where the tracker does not report it: at a reset, and when messages are lost.
    #[must_use]
    pub fn new(least_evidence: f64) -> Self {
        Self {
            least_evidence,
            tracked: BTreeMap::new(),
            past: Vec::new(),
            refused: 0,
            last_index: None,
        }
    }

    /// Takes the message of a step, with the stamp of the step where it is known.
    pub fn take(&mut self, message: &Walls, stamp_us: Option<u64>) {
        let step = WallStep {
            index: message.index,
            stamp_us,
        };
        let seen = message.seen.iter().map(|wall| {
            let ends = message.ends_half_mm(wall);
            let metres = |units: i32| UNIT_M * f64::from(units);
            let state = WallState {
                ends: ends.map(|[x, y]| Vector::new(metres(x), metres(y))),
                along_m: wall.along.map(sigma_m),
                across_m: wall.across.map(sigma_m),
                evidence: f64::from(wall.evidence),
            };
            (wall.id, state)
        });
        let left = message.left.iter().copied();
        let left: Vec<u16> = left.filter(|id| self.is_sure(*id)).collect();
        self.step(step, seen, &message.out_of_reach, &left);
    }

    /// Takes a step: the segments with a state, those that are out of reach where they
    /// were, and those of the step before that are left behind and count.
    ///
    /// Any other segment of the step before was given up; if steps are missing before
    /// this one, it was left behind if there was enough evidence for it.
    pub fn step(
        &mut self,
        step: WallStep,
        seen: impl Iterator<Item = (u16, WallState)>,
        out_of_reach: &[u16],
        left: &[u16],
    ) {
        let before = self.last_index.replace(step.index);
        let is_next = before.is_some_and(|before| before.wrapping_add(1) == step.index);
        for id in left {
            if let Some(wall) = self.tracked.remove(id) {
                self.close(wall, WallFate::LeftBehind);
            }
        }
        let mut before = std::mem::take(&mut self.tracked);
        for (id, state) in seen {
            let mut known = before.remove(&id);
            if let Some(other) = known.take_if(|known| is_elsewhere(&known.state, &state)) {
                self.close_unreported(other);
            }
            let wall = KnownWall {
                id,
                state,
                first: known.map_or(step, |known| known.first),
                last: step,
                fate: WallFate::Tracked,
            };
            self.tracked.insert(id, wall);
        }
        for id in out_of_reach {
            if let Some(mut wall) = before.remove(id) {
                wall.fate = WallFate::OutOfReach;
                self.tracked.insert(*id, wall);
            }
        }
        for wall in before.into_values() {
            if is_next {
                self.close(wall, WallFate::GivenUp);
            } else {
                self.close_unreported(wall);
            }
        }
    }

    /// The tracker forgets everything: the segments stay in the world as it was.
    pub fn reset(&mut self) {
        for wall in std::mem::take(&mut self.tracked).into_values() {
            self.close_unreported(wall);
        }
    }

    /// Whether no message has come.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.last_index.is_none()
    }

    /// All segments, those that were given up too, in the order in which they were found.
    #[must_use]
    pub fn all(&self) -> Vec<&KnownWall> {
        let mut all: Vec<_> = self.past.iter().chain(self.tracked.values()).collect();
        all.sort_by_key(|wall| (wall.first.index, wall.id));
        all
    }

    /// The segments that were not given up: those left behind, then the tracked ones.
    pub fn standing(&self) -> impl Iterator<Item = &KnownWall> {
        let all = self.past.iter().chain(self.tracked.values());
        all.filter(|wall| wall.fate != WallFate::GivenUp)
    }

    /// Number of segments that were not kept because there are too many.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    fn is_sure(&self, id: u16) -> bool {
        let wall = self.tracked.get(&id);
        wall.is_some_and(|wall| wall.state.evidence >= self.least_evidence)
    }

    /// Closes a segment of which the tracker has not reported what became of it.
    fn close_unreported(&mut self, wall: KnownWall) {
        let is_sure = wall.state.evidence >= self.least_evidence;
        let fate = if is_sure {
            WallFate::LeftBehind
        } else {
            WallFate::GivenUp
        };
        self.close(wall, fate);
    }

    fn close(&mut self, wall: KnownWall, fate: WallFate) {
        // Those that stand come first, also after years.
        let most = match fate {
            WallFate::GivenUp => MAX_PAST / 2,
            _ => MAX_PAST,
        };
        if self.past.len() < most {
            self.past.push(KnownWall { fate, ..wall });
        } else {
            self.refused += 1;
        }
    }
}

/// A standard deviation of a message.
fn sigma_m(units: u8) -> Option<f64> {
    (units < u8::MAX).then(|| UNIT_M * f64::from(units))
}

/// Whether two segments lie so far apart that they are not one.
fn is_elsewhere(one: &WallState, other: &WallState) -> bool {
    let ends_from = |ends: &[Vector; 2], [from, to]: [Vector; 2]| {
        let distances = ends.map(|end| end.distance_from_segment(from, to));
        distances.into_iter().fold(f64::INFINITY, f64::min)
    };
    let distance_m = ends_from(&one.ends, other.ends).min(ends_from(&other.ends, one.ends));
    distance_m > ELSEWHERE_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::node::TrackedWall;

    /// A message with walls of so much evidence, one beside the other.
    fn message(index: u32, seen: &[(u16, u8)]) -> Walls {
        let wall = |(id, evidence): &(u16, u8)| TrackedWall {
            id: *id,
            ends: [[0, 100 * *id as i16], [400, 100 * *id as i16]],
            along: [20, 255],
            across: [2, 3],
            evidence: *evidence,
        };
        Walls {
            index,
            seen: seen.iter().map(wall).collect(),
            ..Walls::default()
        }
    }

    fn after(messages: &[Walls]) -> KnownWalls {
        let mut walls = KnownWalls::new(12.0);
        for message in messages {
            walls.take(message, Some(1000 * u64::from(message.index)));
        }
        walls
    }

    fn fates(walls: &KnownWalls) -> Vec<(u16, WallFate)> {
        let all = walls.all().into_iter();
        all.map(|wall| (wall.id, wall.fate)).collect()
    }

    #[test]
    fn a_wall_has_the_place_and_the_step_of_its_last_message() {
        let mut moved = message(8, &[(1, 50)]);
        moved.block = [0, 1];
        moved.seen[0].ends = [[2, -32_768 + 104], [400, -32_768 + 102]];
        let walls = after(&[message(7, &[(1, 40)]), moved]);
        let [wall] = walls.all()[..] else {
            panic!("{walls:?}");
        };
        assert_eq!((wall.first.index, wall.last.index), (7, 8));
        assert_eq!(wall.last.stamp_us, Some(8000));
        let ends = [Vector::new(0.001, 0.052), Vector::new(0.2, 0.051)];
        for (found, expected) in wall.state.ends.iter().zip(ends) {
            assert!((*found - expected).norm() < 1e-9, "{wall:?}");
        }
        assert_eq!(wall.state.along_m, [Some(0.01), None]);
        assert_eq!(wall.state.evidence.to_bits(), 50_f64.to_bits());
    }

    #[test]
    fn a_wall_that_is_listed_as_left_stands_and_one_that_vanishes_was_given_up() {
        use WallFate::{GivenUp, LeftBehind, OutOfReach, Tracked};
        let mut last = message(1, &[(4, 0)]);
        last.left.extend([1, 2]);
        last.out_of_reach.push(5).unwrap();
        let first = message(0, &[(1, 12), (2, 11), (3, 200), (4, 0), (5, 40)]);
        let walls = after(&[first, last]);
        // Number 2 was left behind before there was enough evidence for it.
        let expected = [LeftBehind, GivenUp, GivenUp, Tracked, OutOfReach];
        assert_eq!(fates(&walls), (1..).zip(expected).collect::<Vec<_>>());
        assert_eq!(walls.standing().count(), 3);
    }

    #[test]
    fn after_a_lost_message_a_wall_with_evidence_stands() {
        use WallFate::{GivenUp, LeftBehind};
        let first = message(0, &[(1, 12), (2, 11)]);
        let walls = after(&[first.clone(), message(2, &[])]);
        assert_eq!(fates(&walls), [(1, LeftBehind), (2, GivenUp)]);
        let walls = after(&[first, message(1, &[])]);
        assert_eq!(fates(&walls), [(1, GivenUp), (2, GivenUp)]);
    }

    #[test]
    fn a_number_that_comes_again_is_another_wall() {
        use WallFate::{LeftBehind, Tracked};
        let mut again = message(1, &[(1, 3)]);
        again.left.push(1).unwrap();
        let walls = after(&[message(0, &[(1, 40)]), again]);
        assert_eq!(fates(&walls), [(1, LeftBehind), (1, Tracked)]);
        // The message of a reset is lost, and numbers begin again.
        let mut far = message(1, &[(1, 3)]);
        far.block = [1, 0];
        let walls = after(&[message(0, &[(1, 40)]), far]);
        assert_eq!(fates(&walls), [(1, LeftBehind), (1, Tracked)]);
    }

    #[test]
    fn a_reset_leaves_the_walls_with_evidence_where_they_are() {
        use WallFate::{GivenUp, LeftBehind, Tracked};
        let mut walls = after(&[message(0, &[(1, 40), (2, 3)])]);
        walls.reset();
        walls.take(&message(1, &[(1, 0)]), None);
        let expected = [(1, LeftBehind), (2, GivenUp), (1, Tracked)];
        assert_eq!(fates(&walls), expected);
    }
}
