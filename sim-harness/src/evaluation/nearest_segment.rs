//! A search tree for the segment of a path that is nearest to a place.

use crate::world::Vector;

/// Most segments of a leaf: fewer make a deeper tree, more make longer leaves.
const LEAF_SEGMENTS: usize = 8;
/// By how much the distance from a box may exceed the distance from a segment in it by
/// rounding, metres: far above an error of f64 within 10 km, far below a cell.
const ROUNDING_M: f64 = 1e-9;

/// The segments of a path in a tree of bounding boxes, split at the median of the longer
/// side. It is built in n log^2 n; a place costs about log n, and a few more segments for
/// each time that the path passes by the same place.
///
/// Two places of the path that are the same have no segment between.
#[derive(Debug)]
pub(super) struct SegmentTree {
    /// By leaf.
    segments: Vec<Segment>,
    /// The root is the first; empty without a segment.
    nodes: Vec<TreeNode>,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    index: usize,
    from: Vector,
    way: Vector,
}

#[derive(Clone, Copy, Debug)]
struct TreeNode {
    low: Vector,
    high: Vector,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    /// A range of [`SegmentTree::segments`].
    Leaf(usize, usize),
    /// Two nodes by index.
    Inner(usize, usize),
}

impl SegmentTree {
    /// Builds the tree of the segments that are wanted, by the index of their first place.
    pub(super) fn new(path: &[Vector], is_wanted: impl Fn(usize) -> bool) -> Self {
        let pairs = path.iter().zip(path.iter().skip(1)).enumerate();
        let segments = pairs
            .filter(|(index, _)| is_wanted(*index))
            .map(|(index, (from, to))| Segment {
                index,
                from: *from,
                way: *to - *from,
            })
            .filter(|segment| segment.way.dot(segment.way) > 0.0);
        let mut tree = Self {
            segments: segments.collect(),
            nodes: Vec::new(),
        };
        if !tree.segments.is_empty() {
            tree.build(0, tree.segments.len());
        }
        tree
    }

    /// Builds the node of a range that is not empty; its index. As deep as the logarithm
    /// of the number of segments.
    fn build(&mut self, start: usize, end: usize) -> usize {
        let segments = self.segments.get_mut(start..end).unwrap_or_default();
        let (low, high) = bounds(segments);
        let node = self.nodes.len();
        self.nodes.push(TreeNode {
            low,
            high,
            content: Content::Leaf(start, end),
        });
        if segments.len() > LEAF_SEGMENTS {
            let is_wide = high.x - low.x >= high.y - low.y;
            let key = |segment: &Segment| {
                let middle = segment.from + segment.way.scaled(0.5);
                if is_wide { middle.x } else { middle.y }
            };
            let half = segments.len() / 2;
            segments.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
            let near = self.build(start, start + half);
            let far = self.build(start + half, end);
            if let Some(node) = self.nodes.get_mut(node) {
                node.content = Content::Inner(near, far);
            }
        }
        node
    }

    /// The segment that is nearest to a place, and whether the place lies left of it; of
    /// equally near ones the first of the path.
    pub(super) fn nearest(&self, place: Vector) -> Option<(usize, bool)> {
        self.nearest_of(place, &mut 0)
    }

    /// The same, and counts the segments that are looked at.
    fn nearest_of(&self, place: Vector, looked_at: &mut usize) -> Option<(usize, bool)> {
        let mut best: Option<(f64, Segment)> = None;
        let mut rest: Vec<(f64, &TreeNode)> = self
            .nodes
            .first()
            .map(|root| (0.0, root))
            .into_iter()
            .collect();
        while let Some((at_least, node)) = rest.pop() {
            if best.is_some_and(|(least, _)| at_least > least + ROUNDING_M) {
                continue;
            }
            match node.content {
                Content::Leaf(start, end) => {
                    for segment in self.segments.get(start..end).unwrap_or_default() {
                        *looked_at += 1;
                        let distance = segment.distance_m(place);
                        let is_nearer = best.is_none_or(|(least, nearest)| {
                            let order = distance.total_cmp(&least);
                            order.then(segment.index.cmp(&nearest.index)).is_lt()
                        });
                        if is_nearer {
                            best = Some((distance, *segment));
                        }
                    }
                }
                Content::Inner(one, other) => {
                    let child = |index: usize| {
                        let node = self.nodes.get(index)?;
                        Some((node.distance_m(place), node))
                    };
                    let mut children = [child(one), child(other)];
                    // The nearer one is looked at first.
                    children.sort_by(|a, b| {
                        let key = |child: &Option<(f64, _)>| child.map_or(0.0, |(far, _)| far);
                        key(b).total_cmp(&key(a))
                    });
                    rest.extend(children.into_iter().flatten());
                }
            }
        }
        best.map(|(_, segment)| {
            let is_left = segment.way.cross(place - segment.from) > 0.0;
            (segment.index, is_left)
        })
    }
}

impl Segment {
    fn distance_m(&self, place: Vector) -> f64 {
        let from_start = place - self.from;
        let share = (from_start.dot(self.way) / self.way.dot(self.way)).clamp(0.0, 1.0);
        (from_start - self.way.scaled(share)).norm()
    }
}

impl TreeNode {
    fn distance_m(&self, place: Vector) -> f64 {
        let beyond = |low: f64, high: f64, at: f64| (low - at).max(at - high).max(0.0);
        let x = beyond(self.low.x, self.high.x, place.x);
        let y = beyond(self.low.y, self.high.y, place.y);
        Vector::new(x, y).norm()
    }
}

/// The least and the greatest coordinates of segments.
fn bounds(segments: &[Segment]) -> (Vector, Vector) {
    let infinite = f64::INFINITY;
    let nothing = (
        Vector::new(infinite, infinite),
        Vector::new(-infinite, -infinite),
    );
    let ends = segments
        .iter()
        .flat_map(|segment| [segment.from, segment.from + segment.way]);
    ends.fold(nothing, |(low, high), end| {
        (
            Vector::new(low.x.min(end.x), low.y.min(end.y)),
            Vector::new(high.x.max(end.x), high.y.max(end.y)),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Turn;
    use amiro_ipf::random::{Generator, standard_normal_pair};

    /// Every segment in turn: the definition.
    fn by_definition(path: &[Vector], place: Vector) -> Option<(usize, bool)> {
        let segments = path.iter().zip(path.iter().skip(1)).enumerate();
        let nearest = segments
            .filter_map(|(index, (from, to))| {
                let way = *to - *from;
                let squared = way.dot(way);
                if squared <= 0.0 {
                    return None;
                }
                let from_start = place - *from;
                let share = (from_start.dot(way) / squared).clamp(0.0, 1.0);
                let distance = (from_start - way.scaled(share)).norm();
                Some((distance, (index, way.cross(from_start) > 0.0)))
            })
            .min_by(|(a, _), (b, _)| a.total_cmp(b));
        nearest.map(|(_, found)| found)
    }

    /// Steps of 10 mm along lanes of the given length, 100 mm apart.
    fn lanes(steps: usize, per_lane: usize) -> Vec<Vector> {
        let place = |step: usize| {
            let (lane, along) = (step / per_lane, step % per_lane);
            let along = if lane % 2 == 0 {
                along
            } else {
                per_lane - 1 - along
            };
            Vector::new(0.01 * along as f64, 0.1 * lane as f64)
        };
        (0..steps).map(place).collect()
    }

    #[test]
    fn the_tree_finds_what_a_look_at_every_segment_finds() {
        for seed in 1..=5 {
            let mut generator = Generator::seeded(seed);
            let mut place = |scale: f64| {
                let (x, y) = standard_normal_pair(&mut generator);
                Vector::new(scale * f64::from(x), scale * f64::from(y))
            };
            let mut at = Vector::new(0.0, 0.0);
            let mut path = Vec::new();
            for step in 0..300 {
                path.push(at);
                // Standing still now and then, and a jump.
                let scale = if step == 200 { 40.0 } else { 0.01 };
                if step % 7 != 0 {
                    at = at + place(scale);
                }
            }
            let there: Vec<_> = path.clone();
            path.extend(there.iter().rev());
            let tree = SegmentTree::new(&path, |_| true);
            for _ in 0..500 {
                let place = place(0.3);
                let found = tree.nearest(place);
                assert_eq!(found, by_definition(&path, place), "seed {seed}: {place:?}");
            }
        }
    }

    #[test]
    fn of_equally_near_segments_the_first_is_taken() {
        let path = lanes(400, 20);
        let tree = SegmentTree::new(&path, |_| true);
        for column in 0..40 {
            for row in 0..400 {
                let place = Vector::new(0.005 * f64::from(column), 0.005 * f64::from(row));
                assert_eq!(
                    tree.nearest(place),
                    by_definition(&path, place),
                    "{place:?}"
                );
            }
        }
    }

    #[test]
    fn unwanted_segments_and_those_without_length_are_never_nearest() {
        let path = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.0), (0.1, 0.1)].map(|(x, y)| Vector::new(x, y));
        let beside = Vector::new(0.05, 0.01);
        let nearest =
            |is_wanted: fn(usize) -> bool| SegmentTree::new(&path, is_wanted).nearest(beside);
        assert_eq!(nearest(|_| true), Some((0, true)));
        assert_eq!(nearest(|index| index > 0), Some((2, true)));
        assert_eq!(nearest(|index| index == 1), None);
        assert_eq!(SegmentTree::new(&[], |_| true).nearest(beside), None);
    }

    #[test]
    fn a_place_costs_the_logarithm_of_the_segments_and_a_few_for_each_lap() {
        /// Radians per step.
        const TURN: f64 = 0.02;
        let laps = |steps: usize| -> Vec<Vector> {
            let place = |step: usize| {
                let heading = Turn::by_radians((TURN * step as f64) as f32);
                // No lap is exactly the one before.
                heading.direction().scaled(0.5 + 1e-7 * step as f64)
            };
            (0..steps).map(place).collect()
        };
        for steps in [1_000, 32_000] {
            let passes = TURN * steps as f64 / core::f64::consts::TAU;
            let paths = [
                (lanes(steps, 1_000), 1.0),
                (lanes(steps, steps), 1.0),
                (laps(steps), passes),
            ];
            for (path, passes) in paths {
                let tree = SegmentTree::new(&path, |_| true);
                let mut looked_at = 0;
                for place in &path {
                    let beside = *place + Vector::new(0.03, 0.04);
                    tree.nearest_of(beside, &mut looked_at);
                }
                let each = looked_at as f64 / path.len() as f64;
                let at_most = 3.0 * passes + 4.0 * f64::from(steps.ilog2());
                assert!(
                    each < at_most,
                    "{steps} steps, {passes} passes: {each} of {at_most} segments each"
                );
            }
        }
    }
}
