//! The scores of a drive's map, at its end and during the drive.

use super::{OpeningScores, Scores, SurfaceOffset, Truth};
use crate::drive::Record;
use crate::geometry::Pose2;
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
    /// Where the final map has the surfaces.
    pub offset: SurfaceOffset,
    /// Mean of the overall error over eight snapshots along the path, at equal shares
    /// of the steps, each at its own best expansion; `None` if none has a classified
    /// cell or there is no map during the drive, else the mean of those that have.
    pub oe_path_mean: Option<f64>,
    /// The scenario's openings, in its order, each when it is due; empty if there is no
    /// map during the drive.
    pub openings: Vec<OpeningScores>,
    /// Distance from the hull to the nearest surface after the first step that showed
    /// two occupied cells within 25 mm of a surface, metres.
    pub detected_at_m: Option<f64>,
}

impl DriveScores {
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

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Scores a map while a drive is mapped; to be shown each record before it is mapped.
///
/// Whole steps: the map after a step holds all records up to the next pose.
pub struct DriveJudge<'s> {
    truth: &'s Truth,
    poses: &'s [Pose2],
    hull_m: f64,
    /// After which step each snapshot is taken, and each opening judged.
    snapshot_steps: Vec<usize>,
    due: Vec<(usize, Opening)>,
    steps: usize,
    snapshots: Vec<f64>,
    openings: Vec<OpeningScores>,
    detected_at_m: Option<f64>,
}

impl<'s> DriveJudge<'s> {
    /// A judge of a drive through a scenario with a step at each of the given poses.
    #[must_use]
    pub fn new(scenario: &'s Scenario, truth: &'s Truth, poses: &'s [Pose2]) -> Self {
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
            steps: 0,
            snapshots: Vec::new(),
            openings: vec![OpeningScores::default(); scenario.openings.len()],
            detected_at_m: None,
        }
    }

    /// Takes the next record, and the map of the records before it.
    pub fn take(&mut self, record: &Record, mapper: &dyn Mapper) {
        if record.pose().is_some() {
            self.end_step(mapper);
            self.steps += 1;
        }
    }

    /// The scores of the drive and of its final map.
    #[must_use]
    pub fn finish(mut self, mapper: &dyn Mapper) -> DriveScores {
        self.end_step(mapper);
        let map = mapper.map();
        let drive = DriveScores {
            last: Scores::of(&map, self.truth),
            offset: SurfaceOffset::of(&map, self.truth),
            oe_path_mean: mean(&self.snapshots),
            openings: self.openings,
            detected_at_m: self.detected_at_m,
        };
        if mapper.is_online() {
            return drive;
        }
        DriveScores {
            oe_path_mean: None,
            openings: Vec::new(),
            detected_at_m: None,
            ..drive
        }
    }

    /// Judges the map after a step, where a judgement is due.
    fn end_step(&mut self, mapper: &dyn Mapper) {
        let steps = self.steps;
        let Some(pose) = steps.checked_sub(1).and_then(|last| self.poses.get(last)) else {
            return;
        };
        let robot = pose.position;
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

/// Number of steps after which the driven path length is nearest to a distance.
///
/// Nearest, not first beyond: a step falls on the first sample at or past its
/// distance, and rounding decides whether the last one of a leg is this sample or the
/// next leg's first.
fn step_nearest(poses: &[Pose2], distance_m: f64) -> usize {
    let places = poses.iter().map(|pose| pose.position);
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
    let correct = map.cells_of(Occupancy::Occupied).filter(|cell| {
        let (x, y) = map.centre(*cell);
        truth.is_wall(Vector::new(x, y), DETECTED_WITHIN_M)
    });
    correct.take(DETECTED_CELLS).count() == DETECTED_CELLS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Cell;
    use crate::mapping::Belief;

    /// Marks one more cell per step, from x = 0 on: the first free, the next occupied.
    struct Growing {
        steps: i32,
    }

    impl Mapper for Growing {
        fn take(&mut self, record: &Record) {
            self.steps += i32::from(record.pose().is_some());
        }

        fn map(&self) -> Map {
            let mut map = Map::unknown(0.01);
            for column in 0..self.steps {
                let p_occ = if column < 4 { 0.0 } else { 1.0 };
                *map.reach(Cell { row: 0, column }).unwrap() = Belief::of_probability(p_occ);
            }
            map
        }
    }

    /// Scores of a drive with a step at each of the poses.
    fn scores(scenario: &Scenario, poses: &[Pose2]) -> DriveScores {
        let truth = Truth::of(scenario, &[]);
        let mut mapper = Growing { steps: 0 };
        let mut judge = DriveJudge::new(scenario, &truth, poses);
        for pose in poses {
            let record = Record::Pose {
                stamp_us: 0,
                world_from_body: *pose,
            };
            judge.take(&record, &mapper);
            mapper.take(&record);
        }
        judge.finish(&mapper)
    }

    /// Sixteen poses along x, so many metres apart.
    fn poses(apart_m: f64) -> Vec<Pose2> {
        (0..16_u8)
            .map(|step| Pose2::new(apart_m * f64::from(step), 0.0, 0.0))
            .collect()
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
        let scores = scores(&scenario, &poses(0.01));
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
        // Steps fall a little behind their distances.
        let scores = scores(&scenario, &poses(0.0101));
        // 60 mm are reached after seven steps: seven cells, three of them occupied.
        let counts: Vec<_> = scores.openings.iter().map(|o| o.false_occupied).collect();
        assert_eq!(counts, [3, 12]);
        assert_eq!(scores.opening_false_occupied(), Some(15));
    }

    #[test]
    fn an_object_is_detected_at_the_distance_of_its_second_cell() {
        let scenario = scenario("[[box]]\nmin = [0.09, 0]\nmax = [0.2, 0.01]\n");
        let scores = scores(&scenario, &poses(-0.01));
        // Centres at 65 and 75 mm are within 25 mm; the second is there after eight
        // steps, at x = -0.07: 160 mm from the block, 110 mm from the hull.
        assert!(
            (scores.detected_at_m.unwrap() - 0.110).abs() < 1e-6,
            "{scores:?}"
        );
    }

    /// A map that is made at the end.
    struct Batch(Growing);

    impl Mapper for Batch {
        fn take(&mut self, record: &Record) {
            self.0.take(record);
        }

        fn map(&self) -> Map {
            self.0.map()
        }

        fn is_online(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_method_without_a_map_during_the_drive_has_no_scores_of_it() {
        let scenario =
            scenario("[[opening]]\nmin = [0, 0]\nmax = [0.3, 0.01]\njudged_at_m = 0.06\n");
        let poses = poses(0.0101);
        let truth = Truth::of(&scenario, &poses);
        let mut mapper = Batch(Growing { steps: 0 });
        let mut judge = DriveJudge::new(&scenario, &truth, &poses);
        for pose in &poses {
            let record = Record::Pose {
                stamp_us: 0,
                world_from_body: *pose,
            };
            judge.take(&record, &mapper);
            mapper.take(&record);
        }
        let scores = judge.finish(&mapper);
        assert_eq!(scores.last.oe, Some(0.75));
        assert_eq!(scores.oe_path_mean, None);
        assert_eq!(scores.opening_false_occupied(), None);
        assert_eq!(scores.detected_at_m, None);
    }

    #[test]
    fn a_drive_without_steps_has_no_path_mean() {
        let scenario = scenario("[[opening]]\nmin = [0, 0]\nmax = [0.3, 0.01]\njudged_at_m = 0\n");
        let scores = scores(&scenario, &[]);
        assert_eq!(scores.oe_path_mean, None);
        assert_eq!(scores.opening_frontier(), Some(0));
    }
}
