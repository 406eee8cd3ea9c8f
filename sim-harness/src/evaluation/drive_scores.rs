//! How good the map of a drive is, at its end and on the way.

use amiro_ipf::geometry::Pose;
use amiro_ipf::node::{Event, StepBegun};

use super::{OpeningScores, Scores, Truth};
use crate::mapping::{Map, Mapper, Occupancy};
use crate::world::{Opening, Scenario, Vector};

/// Snapshots along the path, at equal shares of the steps; the last is the final map.
const SNAPSHOTS: usize = 8;
/// An object is detected by so many occupied cells so near to its surface, metres.
const DETECTED_CELLS: usize = 2;
const DETECTED_WITHIN_M: f64 = 0.025;

/// Scores of a drive's map.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveScores {
    /// The final map's.
    pub last: Scores,
    /// Mean of the overall error over eight snapshots along the path, at equal shares
    /// of the steps, each at its own best expansion; `None` if none has a classified
    /// cell, else the mean of those that have.
    pub oe_path_mean: Option<f64>,
    /// The scenario's openings, in its order, each when it is due.
    pub openings: Vec<OpeningScores>,
    /// Distance from the hull to the nearest surface after the first step that showed
    /// two occupied cells within 25 mm of a surface, metres.
    pub detected_at_m: Option<f64>,
}

impl DriveScores {
    /// Maps the events of a drive with a fresh mapper and judges the map.
    ///
    /// Whole steps: the map after a step holds all that the step said.
    #[must_use]
    pub fn of(
        mapper: &mut dyn Mapper,
        events: &[Event],
        scenario: &Scenario,
        truth: &Truth,
    ) -> Self {
        let poses = step_poses(events);
        let mut course = Course::of(scenario, truth, &poses);
        let mut steps = 0;
        for event in events {
            mapper.take(event);
            if matches!(event, Event::StepDone(_)) {
                steps += 1;
                course.pass(steps, mapper);
            }
        }
        let last = Scores::of(&mapper.map(), truth);
        Self {
            last,
            oe_path_mean: mean(&course.snapshots),
            openings: course.openings,
            detected_at_m: course.detected_at_m,
        }
    }

    /// Falsely occupied cells in all openings together; `None` without openings.
    #[must_use]
    pub fn opening_false_occupied(&self) -> Option<u64> {
        let counts = self.openings.iter().map(|opening| opening.false_occupied);
        counts.reduce(|sum, count| sum + count)
    }

    /// Falsely occupied cells in the opening that has the fewest.
    #[must_use]
    pub fn least_false_occupied(&self) -> Option<u64> {
        let counts = self.openings.iter().map(|opening| opening.false_occupied);
        counts.min()
    }

    /// Frontier cells in the opening that has the fewest; `None` without openings.
    #[must_use]
    pub fn opening_frontier(&self) -> Option<u64> {
        self.openings.iter().map(|opening| opening.frontier).min()
    }

    /// Frontier cells in the opening that has the most.
    #[must_use]
    pub fn most_frontier(&self) -> Option<u64> {
        self.openings.iter().map(|opening| opening.frontier).max()
    }
}

/// The robot's pose at each step.
#[must_use]
pub(super) fn step_poses(events: &[Event]) -> Vec<Pose> {
    let pose = |event: &Event| match event {
        Event::StepBegun(StepBegun { pose, .. }) => Some(*pose),
        _ => None,
    };
    events.iter().filter_map(pose).collect()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// What is judged on the way.
struct Course<'s> {
    truth: &'s Truth,
    poses: &'s [Pose],
    hull_m: f64,
    /// After which step each snapshot is taken, and each opening judged.
    snapshot_steps: Vec<usize>,
    due: Vec<(usize, Opening)>,
    snapshots: Vec<f64>,
    openings: Vec<OpeningScores>,
    detected_at_m: Option<f64>,
}

impl<'s> Course<'s> {
    fn of(scenario: &'s Scenario, truth: &'s Truth, poses: &'s [Pose]) -> Self {
        let (ring, _) = scenario.ring();
        let due = |opening: &Opening| (step_nearest(poses, opening.judged_at_m), *opening);
        Self {
            truth,
            poses,
            hull_m: f64::from(ring.radius_m),
            snapshot_steps: (1..=SNAPSHOTS)
                .map(|snapshot| (snapshot * poses.len()).div_ceil(SNAPSHOTS))
                .collect(),
            due: scenario.openings.iter().map(due).collect(),
            snapshots: Vec::new(),
            openings: vec![OpeningScores::default(); scenario.openings.len()],
            detected_at_m: None,
        }
    }

    /// Judges the map after so many steps, as far as something is due.
    fn pass(&mut self, steps: usize, mapper: &dyn Mapper) {
        let Some(pose) = steps.checked_sub(1).and_then(|last| self.poses.get(last)) else {
            return;
        };
        let robot = Vector::from(pose.position);
        let snapshots = self.snapshot_steps.iter().filter(|due| **due == steps);
        let snapshots = snapshots.count();
        let is_due = self.due.iter().any(|(due, _)| *due == steps);
        if snapshots == 0 && !is_due && self.detected_at_m.is_some() {
            return;
        }
        let map = mapper.map();
        if snapshots > 0
            && let Some(oe) = Scores::of(&map, self.truth).oe
        {
            self.snapshots.extend(vec![oe; snapshots]);
        }
        for (scores, (due, opening)) in self.openings.iter_mut().zip(&self.due) {
            if *due == steps {
                *scores = OpeningScores::of(&map, &opening.rectangle, robot);
            }
        }
        if self.detected_at_m.is_none() && shows_an_object(&map, self.truth) {
            self.detected_at_m = Some(self.truth.distance_m(robot) - self.hull_m);
        }
    }
}

/// The count of steps after which the driven way is nearest to a distance.
///
/// Nearest, not first beyond: a step falls on the first sample at or past its
/// distance, and rounding decides whether the last one of a leg is this sample or the
/// next leg's first.
fn step_nearest(poses: &[Pose], distance_m: f64) -> usize {
    let places = poses.iter().map(|pose| Vector::from(pose.position));
    let ways = places.clone().zip(places.skip(1));
    let driven = ways.scan(0.0, |driven_m, (from, to)| {
        *driven_m += (to - from).norm();
        Some(*driven_m)
    });
    let off = core::iter::once(0.0)
        .chain(driven)
        .map(|driven_m| (driven_m - distance_m).abs());
    let nearest = (1..).zip(off).min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map_or(0, |(steps, _)| steps)
}

fn shows_an_object(map: &Map, truth: &Truth) -> bool {
    let occupied = map
        .iter()
        .filter(|(_, p_occ)| Occupancy::of(**p_occ) == Occupancy::Occupied);
    let correct = occupied.filter(|(cell, _)| {
        let (x, y) = map.centre(*cell);
        truth.is_wall(Vector::new(x, y), DETECTED_WITHIN_M)
    });
    correct.take(DETECTED_CELLS).count() == DETECTED_CELLS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Grid;
    use amiro_ipf::model::{SENSORS, Sample};
    use amiro_ipf::node::StepDone;

    /// Marks one more cell a step, from x = 0 on: the first free, the next occupied.
    struct Growing {
        steps: i32,
    }

    impl Mapper for Growing {
        fn take(&mut self, event: &Event) {
            self.steps += i32::from(matches!(event, Event::StepBegun(_)));
        }

        fn map(&self) -> Map {
            let mut map = Grid::new(0.01, 0.5);
            for column in 0..self.steps {
                let cell = crate::mapping::Cell { row: 0, column };
                *map.reach(cell).unwrap() = if column < 4 { 0.0 } else { 1.0 };
            }
            map
        }
    }

    fn events(poses: &[(f32, f32)]) -> Vec<Event> {
        let done = StepDone {
            index: 0,
            digest: 0,
            past_gate: 0,
            below_gate: 0,
            free: 0,
            unobserved: 0,
            departed: 0,
            degenerate: false,
        };
        let step = |&(x, y)| {
            let begun = StepBegun {
                index: 0,
                stamp_us: 0,
                pose: Pose::new(x, y, 0.0),
                samples: [Sample::Missing; SENSORS],
            };
            [Event::StepBegun(begun), Event::StepDone(done)]
        };
        poses.iter().flat_map(step).collect()
    }

    fn scenario(tables: &str) -> Scenario {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [0, 0, 0.3, 0.01]\n\
             speed_m_per_s = 0.08\nstart = [0, 0, 0]\n{tables}"
        );
        Scenario::parse(&text).unwrap()
    }

    #[test]
    fn the_path_mean_is_over_eight_snapshots_at_equal_shares() {
        let scenario = scenario("");
        let truth = Truth::of(&scenario, &[]);
        let poses: Vec<_> = (0..16_u8)
            .map(|step| (0.01 * f32::from(step), 0.0))
            .collect();
        let scores = DriveScores::of(
            &mut Growing { steps: 0 },
            &events(&poses),
            &scenario,
            &truth,
        );
        // After 2, 4, ... 16 steps; of n cells n - 4 are falsely occupied.
        let expected: f64 = (1..=8)
            .map(|snapshot| f64::from(2 * snapshot))
            .map(|cells| (cells - 4.0).max(0.0) / cells)
            .sum();
        assert!((scores.oe_path_mean.unwrap() - expected / 8.0).abs() < 1e-12);
        assert_eq!(scores.last.oe, Some(0.75));
        assert_eq!(scores.detected_at_m, None);
        assert_eq!(scores.opening_false_occupied(), None);
    }

    #[test]
    fn an_opening_is_judged_at_its_distance_not_at_the_end() {
        let scenario = scenario(
            "[[opening]]\nmin = [0, 0]\nmax = [0.3, 0.01]\njudged_at_m = 0.06\n\
             [[opening]]\nmin = [0, 0]\nmax = [0.3, 0.01]\njudged_at_m = 5\n",
        );
        let truth = Truth::of(&scenario, &[]);
        // Steps fall a little behind their distances.
        let poses: Vec<_> = (0..16_u8)
            .map(|step| (0.0101 * f32::from(step), 0.0))
            .collect();
        let scores = DriveScores::of(
            &mut Growing { steps: 0 },
            &events(&poses),
            &scenario,
            &truth,
        );
        // 60 mm are reached after seven steps: seven cells, three of them occupied.
        let counts: Vec<_> = scores.openings.iter().map(|o| o.false_occupied).collect();
        assert_eq!(counts, [3, 12]);
        assert_eq!(scores.opening_false_occupied(), Some(15));
    }

    #[test]
    fn an_object_is_detected_at_the_distance_of_its_second_cell() {
        let scenario = scenario("[[box]]\nmin = [0.09, 0]\nmax = [0.2, 0.01]\n");
        let truth = Truth::of(&scenario, &[]);
        let poses: Vec<_> = (0..16_u8)
            .map(|step| (-0.01 * f32::from(step), 0.0))
            .collect();
        let scores = DriveScores::of(
            &mut Growing { steps: 0 },
            &events(&poses),
            &scenario,
            &truth,
        );
        // Centres at 65 and 75 mm are within 25 mm; the second is there after eight
        // steps, at x = -0.07: 160 mm from the block, 110 mm from the hull.
        assert!(
            (scores.detected_at_m.unwrap() - 0.110).abs() < 1e-6,
            "{scores:?}"
        );
    }

    #[test]
    fn a_drive_without_steps_has_no_path_mean() {
        let scenario = scenario("[[opening]]\nmin = [0, 0]\nmax = [0.3, 0.01]\njudged_at_m = 0\n");
        let truth = Truth::of(&scenario, &[]);
        let scores = DriveScores::of(&mut Growing { steps: 0 }, &[], &scenario, &truth);
        assert_eq!(scores.oe_path_mean, None);
        assert_eq!(scores.opening_frontier(), Some(0));
    }
}
