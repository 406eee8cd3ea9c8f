//! Walls beside a drive without a measured world.

use core::fmt;
use core::ops::Range;
use std::collections::BTreeSet;

use serde::Serialize;

use super::Line;
use super::legs::legs;
use super::mapped_sides::is_mapped;
use super::nearest_segment::SegmentTree;
use crate::mapping::{Map, Occupancy};
use crate::world::Vector;

/// A cell belongs to a line if its centre is this near, metres.
const INLIER_M: f64 = 0.020;
/// Two cells nearer than this to each other do not determine a line, metres.
const PAIR_M: f64 = 0.050;
/// Most cells that pairs are made of, and most pairs that are tried.
const MAX_SEEDS: usize = 1_000;
const MAX_PAIRS: usize = 20_000;
/// Most refinements of a line; it settles after two or three.
const MAX_REFINEMENTS: usize = 50;
/// Length of a bin along the line, metres.
const BIN_M: f64 = 0.010;
/// Covered length from which a wall is claimed, metres.
///
/// A choice, not a measurement: one and a half times the robot's diameter. The wide
/// arc of a single reading near the range limit can cover as much, so a claim is read
/// together with the share of cells on the line and their distances from it.
pub const WALL_COVERED_M: f64 = 0.150;

/// The walls of a map left and right of the driven path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallReport {
    /// The left side.
    pub left: WallSide,
    /// The right side.
    pub right: WallSide,
}

/// The occupied cells of one side of the path and the straight line through most of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WallSide {
    /// Occupied cells on this side.
    pub occupied: usize,
    /// The line with the most cells within 20 mm; `None` if no two cells are 50 mm apart.
    pub line: Option<Line>,
    /// Cells within 20 mm of the line.
    pub inliers: usize,
    /// Length of the line that has cells, in bins of 10 mm, metres.
    pub covered_m: f64,
    /// Share of this side's occupied cells that lie within 20 mm of the line.
    pub share: Option<f64>,
    /// Root mean squared distance of these cells from the line, metres.
    pub rms_inliers_m: Option<f64>,
    /// The same over all occupied cells of this side.
    pub rms_all_m: Option<f64>,
    /// Whether a wall is claimed: covered length of at least [`WALL_COVERED_M`].
    pub claimed: bool,
    /// Whether the map has a known cell on this side of the path; otherwise there is no
    /// statement about walls.
    pub mapped: bool,
}

/// A map and the path through it, where the path may jump.
#[derive(Clone, Copy, Debug)]
pub struct MappedPath<'a> {
    /// The map in which walls are looked for.
    pub map: &'a Map,
    /// The map without the robot's footprint, which shows the sensed places.
    pub counted: &'a Map,
    /// The robot's places in order, metres.
    pub path: &'a [(f64, f64)],
    /// The places to which the robot did not drive from the place before, by index, in
    /// order: the path has no segment there.
    pub jumps: &'a [usize],
}

impl<'a> MappedPath<'a> {
    /// A map without a footprint, and a path without jumps.
    #[must_use]
    pub const fn new(map: &'a Map, path: &'a [(f64, f64)]) -> Self {
        Self {
            map,
            counted: map,
            path,
            jumps: &[],
        }
    }

    /// Whether the robot drove along a segment, which ends at the place after it.
    fn is_driven(&self, segment: usize) -> bool {
        self.jumps.binary_search(&(segment + 1)).is_err()
    }

    /// The nearly straight legs of each piece of the path, as ranges of segments, in order.
    fn legs(&self, path: &[Vector]) -> Vec<Range<usize>> {
        let starts = core::iter::once(&0).chain(self.jumps);
        let ends = self.jumps.iter().copied().chain([path.len()]);
        starts
            .zip(ends)
            .flat_map(|(&start, end)| {
                let piece = legs(path.get(start..end).unwrap_or_default());
                let shifted = |leg: Range<usize>| leg.start + start..leg.end + start;
                piece.into_iter().map(shifted).collect::<Vec<_>>()
            })
            .collect()
    }
}

impl WallReport {
    /// Looks for a wall on each side of a path, given by the robot's places in order.
    ///
    /// A cell belongs to the side of its nearest path segment, cells under the robot
    /// and on the path itself included (the latter to the right). Without a segment,
    /// that is before the robot has moved, there are no sides and both are empty.
    /// Exhaustive over pairs of cells within a cap, so the same map gives the same
    /// report.
    #[must_use]
    pub fn of(surroundings: &MappedPath<'_>) -> Self {
        let path = vectors(surroundings.path);
        let whole = 0..path.len().saturating_sub(1);
        let mut sides = Sides::of_legs(surroundings, &path, std::slice::from_ref(&whole));
        let sides = sides.pop().unwrap_or_default();
        sides.report(surroundings, &path, &whole)
    }

    /// The same for each nearly straight leg of the path by itself, in order.
    ///
    /// A straight wall cannot follow a bend: a robot that goes round a box has one of
    /// its faces beside each leg. A cell belongs to the leg of its nearest segment. A
    /// leg ends where the path would stray more than 50 mm from a straight line, and
    /// where it jumps.
    #[must_use]
    pub fn by_leg(surroundings: &MappedPath<'_>) -> Vec<Self> {
        let path = vectors(surroundings.path);
        let legs = surroundings.legs(&path);
        let sides = Sides::of_legs(surroundings, &path, &legs);
        let pairs = sides.iter().zip(&legs);
        pairs
            .map(|(sides, leg)| sides.report(surroundings, &path, leg))
            .collect()
    }
}

/// The occupied cells left and right of a leg of the path.
#[derive(Clone, Debug, Default)]
struct Sides {
    left: Vec<Vector>,
    right: Vec<Vector>,
}

impl Sides {
    /// Gives each occupied cell to the leg of its nearest segment.
    fn of_legs(surroundings: &MappedPath<'_>, path: &[Vector], legs: &[Range<usize>]) -> Vec<Self> {
        let map = surroundings.map;
        let tree = SegmentTree::new(path, |segment| surroundings.is_driven(segment));
        let mut all = vec![Self::default(); legs.len()];
        for cell in map.cells_of(Occupancy::Occupied) {
            let (x, y) = map.centre(cell);
            let centre = Vector::new(x, y);
            let Some((segment, is_left)) = tree.nearest(centre) else {
                continue;
            };
            let number = legs.partition_point(|leg| leg.end <= segment);
            let is_inside = legs.get(number).is_some_and(|leg| leg.contains(&segment));
            if let Some(sides) = all.get_mut(number).filter(|_| is_inside) {
                let side = if is_left {
                    &mut sides.left
                } else {
                    &mut sides.right
                };
                side.push(centre);
            }
        }
        all
    }

    fn report(
        &self,
        surroundings: &MappedPath<'_>,
        path: &[Vector],
        leg: &Range<usize>,
    ) -> WallReport {
        let driven = leg
            .clone()
            .filter(|segment| surroundings.is_driven(*segment));
        let side = |places: &[Vector], is_left| WallSide {
            mapped: !places.is_empty()
                || driven
                    .clone()
                    .any(|segment| is_mapped(surroundings.counted, path, segment, is_left)),
            ..WallSide::of(places)
        };
        WallReport {
            left: side(&self.left, true),
            right: side(&self.right, false),
        }
    }
}

fn vectors(path: &[(f64, f64)]) -> Vec<Vector> {
    path.iter().map(|(x, y)| Vector::new(*x, *y)).collect()
}

impl WallSide {
    fn of(places: &[Vector]) -> Self {
        let share = |part: usize| {
            let defined = !places.is_empty();
            defined.then(|| part as f64 / places.len() as f64)
        };
        let Some(line) = best_pair(places).map(|line| refined(line, places)) else {
            return Self {
                occupied: places.len(),
                share: share(0),
                ..Self::default()
            };
        };
        let inliers = inliers(&line, places);
        let covered_m = covered_m(&line, &inliers);
        Self {
            occupied: places.len(),
            line: Some(line),
            inliers: inliers.len(),
            covered_m,
            share: share(inliers.len()),
            rms_inliers_m: line.rms_m(&inliers),
            rms_all_m: line.rms_m(places),
            // Half a bin of tolerance: 15 bins times 10 mm may round below 150 mm.
            claimed: covered_m > WALL_COVERED_M - 0.5 * BIN_M,
            mapped: true,
        }
    }
}

/// Length of the bins along the line that hold a place.
fn covered_m(line: &Line, inliers: &[Vector]) -> f64 {
    let along = || inliers.iter().map(|place| line.along_m(*place));
    let first_m = along().fold(f64::INFINITY, f64::min);
    // The first place is in the middle of its bin: cells of 10 mm in a row then never
    // lie on the edges between bins, where rounding would decide.
    let bins: BTreeSet<i64> = along()
        .map(|along_m| ((along_m - first_m) / BIN_M).round() as i64)
        .collect();
    bins.len() as f64 * BIN_M
}

fn inliers(line: &Line, places: &[Vector]) -> Vec<Vector> {
    let near = places.iter().copied();
    near.filter(|place| line.distance_m(*place) <= INLIER_M)
        .collect()
}

/// Every n-th item, with the least n that leaves at most `cap` of them.
fn thinned<T: Copy>(items: &[T], cap: usize) -> Vec<T> {
    let stride = items.len().div_ceil(cap).max(1);
    items.iter().step_by(stride).copied().collect()
}

/// The line through two places that has the most places near it; the first of equals.
fn best_pair(places: &[Vector]) -> Option<Line> {
    let seeds = thinned(places, MAX_SEEDS);
    let pairs: Vec<(Vector, Vector)> = seeds
        .iter()
        .enumerate()
        .flat_map(|(index, from)| seeds.iter().skip(index + 1).map(move |to| (*from, *to)))
        .filter(|(from, to)| (*to - *from).norm() >= PAIR_M)
        .collect();
    let mut best: Option<(usize, Line)> = None;
    for (from, to) in thinned(&pairs, MAX_PAIRS) {
        let Some(line) = Line::through(from, to) else {
            continue;
        };
        let is_near = |place: &&Vector| line.distance_m(**place) <= INLIER_M;
        let count = places.iter().filter(is_near).count();
        if best.is_none_or(|(most, _)| count > most) {
            best = Some((count, line));
        }
    }
    best.map(|(_, line)| line)
}

/// Fits the line to the places near it until these no longer change.
fn refined(mut line: Line, places: &[Vector]) -> Line {
    let mut near = inliers(&line, places);
    for _ in 0..MAX_REFINEMENTS {
        let Some(fitted) = Line::fitted(&near) else {
            break;
        };
        line = fitted;
        let now_near = inliers(&line, places);
        if now_near == near {
            break;
        }
        near = now_near;
    }
    line
}

impl fmt::Display for WallReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "left:  {}", self.left)?;
        write!(f, "right: {}", self.right)
    }
}

impl fmt::Display for WallSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match (self.mapped, self.claimed) {
            (_, true) => "wall",
            (true, false) => "no wall",
            (false, false) => return f.write_str("not mapped: no cell beside the path is known"),
        };
        let millimetres = |metres: Option<f64>| match metres {
            Some(metres) => format!("{:.1} mm", 1000.0 * metres),
            None => "n/a".to_owned(),
        };
        let share = match self.share {
            Some(share) => format!("{:.0} %", 100.0 * share),
            None => "n/a".to_owned(),
        };
        write!(
            f,
            "{verdict:7}  covered {:4.0} mm  on the line {} of {} cells ({share})  \
             RMS {} there, {} over all",
            1000.0 * self.covered_m,
            self.inliers,
            self.occupied,
            millimetres(self.rms_inliers_m),
            millimetres(self.rms_all_m),
        )?;
        match &self.line {
            Some(line) => write!(f, "\n       line {line}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Belief;
    use amiro_ipf::random::{Generator, standard_normal_pair};

    const PATH: [(f64, f64); 3] = [(0.0, 0.0), (0.0, 0.0), (0.6, 0.0)];

    fn map(places: impl IntoIterator<Item = (f64, f64)>) -> Map {
        let mut map = Map::unknown(0.01);
        for (x, y) in places {
            let cell = map.cell_at(x, y).unwrap();
            *map.reach(cell).unwrap() = Belief::of_probability(1.0);
        }
        map
    }

    fn of(map: &Map, path: &[(f64, f64)]) -> WallReport {
        WallReport::of(&MappedPath::new(map, path))
    }

    #[test]
    fn a_noisy_wall_with_outliers_is_found_on_its_side() {
        for seed in 1..=3 {
            let mut generator = Generator::seeded(seed);
            let mut places = Vec::new();
            for index in 0..200 {
                let x = 0.05 + 0.002 * f64::from(index);
                let noise = f64::from(standard_normal_pair(&mut generator).0);
                places.push((x, 0.150 + 0.1 * x + 0.004 * noise));
            }
            places.extend([(0.1, 0.02), (0.3, 0.3), (0.5, 0.04), (0.2, -0.1)]);
            let report = of(&map(places), &PATH);
            let wall = report.left;
            assert!(
                wall.claimed && !report.right.claimed,
                "seed {seed}: {report}"
            );
            // 400 mm of wall touch 40 or 41 bins.
            assert!(
                (0.39..0.43).contains(&wall.covered_m),
                "seed {seed}: {report}"
            );
            assert_eq!(wall.occupied - wall.inliers, 3, "seed {seed}: {report}");
            // 4 mm of noise and 2.9 mm of a cell's own width.
            let rms = wall.rms_inliers_m.unwrap();
            assert!((0.003..0.008).contains(&rms), "seed {seed}: {report}");
            assert!(wall.rms_all_m.unwrap() > rms, "seed {seed}: {report}");
            let [x, y] = wall.line.unwrap().direction;
            assert!((y / x - 0.1).abs() < 0.02, "seed {seed}: {report}");
            assert_eq!(report.right.occupied, 1, "seed {seed}");
        }
    }

    #[test]
    fn short_walls_are_not_claimed() {
        let cells = |count: u8| (0..count).map(|index| (0.005 + 0.01 * f64::from(index), -0.1));
        let side = |count| of(&map(cells(count)), &PATH).right;
        assert!(side(15).claimed, "{}", side(15));
        assert!(!side(14).claimed, "{}", side(14));
        assert_eq!(side(3).line, None, "no pair is 50 mm apart");
    }

    #[test]
    fn sides_follow_the_path_round_a_corner() {
        let path = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5)];
        let map = map([(0.2, 0.105), (0.395, 0.3), (0.605, 0.3), (0.605, -0.1)]);
        let report = of(&map, &path);
        assert_eq!((report.left.occupied, report.right.occupied), (2, 2));
    }

    #[test]
    fn a_box_that_is_driven_round_has_a_wall_for_each_leg() {
        let path = [(0.0, 0.0), (0.5, 0.0), (0.5, -0.5)];
        let along_x = (0..35).map(|index| (0.005 + 0.01 * f64::from(index), -0.105));
        let along_y = (0..20).map(|index| (0.395, -0.155 - 0.01 * f64::from(index)));
        let map = map(along_x.chain(along_y));
        let whole = of(&map, &path).right;
        assert!(whole.share.unwrap() < 0.7, "{whole}");
        let legs = WallReport::by_leg(&MappedPath::new(&map, &path));
        assert_eq!(legs.len(), 2);
        for leg in legs {
            assert!(
                leg.right.claimed && leg.right.share.unwrap() > 0.99,
                "{leg}"
            );
            assert_eq!(leg.left.occupied, 0, "{leg}");
        }
    }

    #[test]
    fn an_empty_map_and_an_empty_path_make_an_empty_report() {
        let empty = of(&map([]), &PATH);
        assert_eq!(empty.left, WallSide::default());
        assert!(!empty.to_string().contains("NaN"), "{empty}");
        let still = of(&map([(0.1, 0.1)]), &PATH[..2]);
        assert_eq!(still.left.occupied + still.right.occupied, 0);
    }

    #[test]
    fn many_cells_are_thinned_to_the_cap() {
        let items: Vec<u32> = (0..1001).collect();
        assert_eq!(thinned(&items, 1000).len(), 501);
        assert_eq!(thinned(&items, 2000).len(), 1001);
        assert!(thinned::<u32>(&[], 10).is_empty());
    }

    #[test]
    fn no_leg_leads_along_a_jump_and_none_that_was_never_mapped_is_called_no_wall() {
        let path = [(0.0, 0.0), (0.3, 0.0), (85.0, 85.0), (85.3, 85.0)];
        let mut map = map((0..30).map(|index| (0.005 + 0.01 * f64::from(index), 0.105)));
        // The other side of the first piece was sensed and is free.
        let free = map.cell_at(0.1, -0.1).unwrap();
        *map.reach(free).unwrap() = Belief::of_probability(0.0);
        let surroundings = MappedPath {
            jumps: &[2],
            ..MappedPath::new(&map, &path)
        };
        let legs = WallReport::by_leg(&surroundings);
        assert_eq!(legs.len(), 2, "{legs:?}");
        let sides = legs.iter().flat_map(|leg| [leg.left, leg.right]);
        let verdicts = ["wall", "no wall", "not mapped", "not mapped"];
        for (side, verdict) in sides.zip(verdicts) {
            assert!(side.to_string().starts_with(verdict), "{verdict}: {side}");
        }
        // The cells of the wall are beside the way, not beside the jump.
        assert_eq!(WallReport::of(&surroundings).left.occupied, 30);
    }

    #[test]
    fn a_footprint_alone_maps_no_side() {
        let path = [(0.0, 0.0), (0.3, 0.0)];
        let nothing = map([]);
        let mut footprint = map([]);
        for column in 0..30 {
            for row in -5..5 {
                *footprint
                    .reach(crate::lattice::Cell { row, column })
                    .unwrap() = Belief::of_probability(0.0);
            }
        }
        let report = WallReport::of(&MappedPath {
            counted: &nothing,
            ..MappedPath::new(&footprint, &path)
        });
        assert!(!report.left.mapped && !report.right.mapped, "{report}");
    }
}
