//! Shapes walls after a fit: cuts them clear of the robot, drops, joins.

use super::refine::Unknowns;
use super::scene::WallScene;
use crate::geometry::Vector;
use crate::sensors::WallSegment;

/// Most walls that are fitted together.
pub(super) const MOST_TOGETHER: usize = 24;

/// Shortest wall that is left when one is cut, metres.
const SHORTEST_M: f64 = 0.02;

/// Length of the pieces in which a wall is cut, metres.
const CUT_M: f64 = 0.0025;

/// Steps of the fit of two walls that become one.
const MERGE_ITERATIONS: usize = 5;

/// Most rounds of dropping and joining after a fit.
const ROUNDS: usize = 8;

/// Steps of the last fit.
const LAST_ITERATIONS: usize = 20;

impl WallScene<'_> {
    /// A wall and those nearest to it, of those that share readings with it.
    pub(super) fn neighbours(&self, index: usize) -> Vec<usize> {
        let Some(wall) = self.wall(index) else {
            return Vec::new();
        };
        let far_m = 2.0 * self.parameters.reach_m;
        let mut near: Vec<(f64, usize)> = self
            .indices()
            .into_iter()
            .filter_map(|other| Some((distance_m(&wall, &self.wall(other)?), other)))
            .filter(|(distance_m, other)| *other == index || *distance_m <= far_m)
            .collect();
        near.sort_by(|(a, first), (b, second)| {
            (*first != index, *a)
                .partial_cmp(&(*second != index, *b))
                .unwrap_or(core::cmp::Ordering::Equal)
        });
        near.truncate(MOST_TOGETHER);
        near.into_iter().map(|(_, index)| index).collect()
    }

    /// Cuts the walls of a group clear of the robot, then drops walls that the readings do
    /// not need and joins those that are one, until neither changes anything.
    pub(super) fn tidy(&mut self, group: &[usize]) {
        for index in group {
            if let Some(wall) = self.wall(*index) {
                let cut = self.clear(&wall);
                if cut != Some(wall) {
                    self.change(&[(*index, cut)]);
                }
            }
        }
        for _ in 0..ROUNDS {
            let is_dropped = self.drop_least(group);
            let is_joined = !is_dropped && self.join_two(group);
            if !is_dropped && !is_joined {
                return;
            }
        }
    }

    /// Fits all walls for the last time, and tidies them.
    pub(super) fn settle(&mut self, fitted: Unknowns) {
        let mut done: Vec<usize> = Vec::new();
        for index in self.indices() {
            if done.contains(&index) {
                continue;
            }
            let group = self.neighbours(index);
            self.refine(&group, LAST_ITERATIONS, fitted);
            self.tidy(&group);
            done.extend(group);
        }
    }

    /// The longest part of a wall that is clear of every place of the robot, if one is
    /// long enough.
    pub(super) fn clear(&self, wall: &WallSegment) -> Option<WallSegment> {
        let clearance_m = self.parameters.clearance_m;
        let stations = self.readings.near(wall, clearance_m);
        let length_m = wall.length_m();
        if length_m < CUT_M || !length_m.is_finite() {
            return None;
        }
        if stations.is_empty() {
            return Some(*wall);
        }
        let pieces = (length_m / CUT_M).ceil() as u32;
        let share = |piece: u32| f64::from(piece) / f64::from(pieces);
        let is_clear = |piece: u32| {
            let place = wall.at(0.5 * (share(piece) + share(piece + 1)));
            stations.iter().all(|station| {
                let station = self.readings.stations.get(*station);
                station.is_none_or(|station| {
                    (station.world_from_body.position - place).norm() > clearance_m + CUT_M
                })
            })
        };
        let (mut longest, mut begun) = ((0, 0), None);
        for piece in 0..=pieces {
            if piece < pieces && is_clear(piece) {
                begun.get_or_insert(piece);
            } else if let Some(first) = begun.take()
                && piece - first > longest.1 - longest.0
            {
                longest = (first, piece);
            }
        }
        let cut = WallSegment::new(wall.at(share(longest.0)), wall.at(share(longest.1)));
        (cut.length_m() >= SHORTEST_M).then_some(cut)
    }

    /// By how much the cost rises without a wall.
    pub(super) fn gain_of(&mut self, index: usize) -> f64 {
        let wall = self.wall(index);
        let rise = self.change(&[(index, None)]);
        self.change(&[(index, wall)]);
        rise
    }

    /// Drops the wall of a group that the readings need least, if they need it too little.
    fn drop_least(&mut self, group: &[usize]) -> bool {
        let mut least = (self.parameters.least_gain, None);
        for index in group {
            if self.wall(*index).is_some() {
                let gain = self.gain_of(*index);
                if gain < least.0 {
                    least = (gain, Some(*index));
                }
            }
        }
        if let Some(index) = least.1 {
            self.change(&[(index, None)]);
        }
        least.1.is_some()
    }

    /// Joins the first two walls of a group that the readings do not tell from one.
    fn join_two(&mut self, group: &[usize]) -> bool {
        for (place, first) in group.iter().enumerate() {
            for second in group.iter().skip(place + 1) {
                if self.join(*first, *second) {
                    return true;
                }
            }
        }
        false
    }

    fn join(&mut self, first: usize, second: usize) -> bool {
        let (Some(one), Some(other)) = (self.wall(first), self.wall(second)) else {
            return false;
        };
        let parameters = self.parameters;
        let Some(joined) = joined(
            &one,
            &other,
            parameters.merge_gap_m,
            parameters.merge_bend_m,
        ) else {
            return false;
        };
        if joined.length_m() > parameters.longest_m {
            return false;
        }
        let mut rise = self.change(&[(first, Some(joined)), (second, None)]);
        rise += self.refine(&[first], MERGE_ITERATIONS, Unknowns::Ends);
        let cut = self.wall(first).and_then(|wall| self.clear(&wall));
        if cut.is_some() && cut != self.wall(first) {
            rise += self.change(&[(first, cut)]);
        }
        if cut.is_some() && rise < parameters.merge_cost {
            return true;
        }
        self.change(&[(first, Some(one)), (second, Some(other))]);
        false
    }
}

/// Least distance between two walls that do not cross, metres.
fn distance_m(one: &WallSegment, other: &WallSegment) -> f64 {
    let ends = [one.from, one.to].map(|end| end.distance_from_segment(other.from, other.to));
    let others = [other.from, other.to].map(|end| end.distance_from_segment(one.from, one.to));
    ends.into_iter().chain(others).fold(f64::INFINITY, f64::min)
}

/// The wall between the ends of two that lie farthest apart, if the two are near each
/// other and along it.
fn joined(one: &WallSegment, other: &WallSegment, gap_m: f64, bend_m: f64) -> Option<WallSegment> {
    if distance_m(one, other) > gap_m {
        return None;
    }
    let ends = [one.from, one.to, other.from, other.to];
    let mut farthest = (0.0, Vector::default(), Vector::default());
    for (place, from) in ends.iter().enumerate() {
        for to in ends.iter().skip(place + 1) {
            let length_m = (*to - *from).norm();
            if length_m > farthest.0 {
                farthest = (length_m, *from, *to);
            }
        }
    }
    let (_, from, to) = farthest;
    let bend = |end: &Vector| end.distance_from_segment(from, to) <= bend_m;
    ends.iter().all(bend).then_some(WallSegment::new(from, to))
}
