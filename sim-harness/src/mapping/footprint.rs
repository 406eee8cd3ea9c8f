//! The robot's footprint: where its hull has been there is no wall.

use std::collections::BTreeSet;

use super::{Belief, FinishProgress, Map, MappedWall, Mapper};
use crate::drive::Record;
use crate::geometry::Vector;
use crate::lattice::{Cell, Lattice};

/// Rounding that is forgiven at the hull's edge, metres: poses are `f32`, so a cell's
/// centre on the edge lies outside.
const ROUNDING_M: f64 = 1e-6;
/// A mapper whose map is free wherever the robot's hull has been.
///
/// Not in the paper. A cell is free if its centre lies strictly inside the hull, a disc
/// about the robot's centre, at some pose of the robot: at each recorded pose, and on the
/// straight line between two poses in a row. A wall that touches the hull keeps its cells.
/// The path is not swept across a reset of the odometry, nor over more than a diameter of
/// the hull: poses are then missing and the path between the two is unknown.
///
/// The footprint replaces the mapper's evidence in the finished map, instead of being
/// counted with it. The mapped world does not move, so that a place where the hull has
/// been is free before and after; evidence against that is wrong, however much of it
/// there is, and a count would need a weight that no measurement gives. Where the
/// odometry drifts, the hull may be reckoned to have been in a wall that was mapped
/// earlier: the map then contradicts itself, and shows the newer of the two.
#[derive(Clone, Debug)]
pub struct FootprintMapper<M> {
    mapper: M,
    footprint: Option<Footprint>,
}

/// The cells that have been under the hull.
#[derive(Clone, Debug)]
struct Footprint {
    radius_m: f64,
    lattice: Lattice,
    cells: BTreeSet<Cell>,
    /// Poses so far away that no grid has cells there.
    refused: u64,
    /// The robot's centre at the pose before, unless the odometry was reset since.
    last: Option<Vector>,
}

impl<M> FootprintMapper<M> {
    /// A mapper with square cells of the given size, metres, for a hull of the given
    /// radius, metres; without a radius the map is the given mapper's.
    #[must_use]
    pub fn new(mapper: M, lattice: impl Into<Lattice>, hull_radius_m: Option<f64>) -> Self {
        let footprint = hull_radius_m.map(|radius_m| Footprint {
            radius_m,
            lattice: lattice.into(),
            cells: BTreeSet::new(),
            refused: 0,
            last: None,
        });
        Self { mapper, footprint }
    }

    /// Radius of the hull whose footprint is free, metres; `None` without a footprint.
    #[must_use]
    pub fn hull_radius_m(&self) -> Option<f64> {
        self.footprint.as_ref().map(|footprint| footprint.radius_m)
    }

    /// The mapper without the footprint.
    #[must_use]
    pub fn counted(&self) -> &M {
        &self.mapper
    }
}

impl<M: Mapper> Mapper for FootprintMapper<M> {
    fn take(&mut self, record: &Record) {
        self.mapper.take(record);
        if let Some(footprint) = &mut self.footprint {
            footprint.take(record);
        }
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        self.mapper.finish(progress);
    }

    fn map(&self) -> Map {
        let mut map = self.mapper.map();
        let Some(footprint) = &self.footprint else {
            return map;
        };
        for cell in &footprint.cells {
            if let Some(belief) = map.reach(*cell) {
                *belief = Belief::of_probability(0.0);
            }
        }
        (0..footprint.refused).for_each(|_| map.refuse());
        map
    }

    fn is_online(&self) -> bool {
        self.mapper.is_online()
    }

    fn walls(&self) -> &[MappedWall] {
        self.mapper.walls()
    }
}

impl Footprint {
    fn take(&mut self, record: &Record) {
        match record {
            Record::Pose {
                world_from_body, ..
            } => {
                let to = world_from_body.position;
                let is_known = |from: &Vector| (to - *from).norm() <= 2.0 * self.radius_m;
                let from = self.last.filter(is_known).unwrap_or(to);
                self.sweep(from, to);
                self.last = Some(to);
            }
            Record::OdometryReset { .. } => self.last = None,
            Record::Scan(_) | Record::Outcomes(_) => {}
        }
    }

    /// Adds the cells under a hull that goes straight from one place to another.
    fn sweep(&mut self, from: Vector, to: Vector) {
        let radius_m = self.radius_m - ROUNDING_M;
        let low = self
            .lattice
            .cell_at(from.x.min(to.x) - radius_m, from.y.min(to.y) - radius_m);
        let high = self
            .lattice
            .cell_at(from.x.max(to.x) + radius_m, from.y.max(to.y) + radius_m);
        let (Some(low), Some(high)) = (low, high) else {
            self.refused += 1;
            return;
        };
        for row in low.row..=high.row {
            for column in low.column..=high.column {
                let cell = Cell { row, column };
                let (x, y) = self.lattice.centre(cell);
                if Vector::new(x, y).distance_from_segment(from, to) < radius_m {
                    self.cells.insert(cell);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::mapping::Occupancy;

    const RADIUS_M: f64 = 0.05;

    /// A mapper that finds every cell within 200 mm of the origin occupied.
    struct Walls;

    impl Mapper for Walls {
        fn take(&mut self, _: &Record) {}

        fn map(&self) -> Map {
            let mut map = Map::unknown(0.01);
            for row in -20..20 {
                for column in -20..20 {
                    *map.reach(Cell { row, column }).unwrap() = Belief::of_probability(1.0);
                }
            }
            map
        }
    }

    fn pose(x: f64, y: f64) -> Record {
        Record::Pose {
            stamp_us: 0,
            world_from_body: Pose2::new(x, y, 0.0),
        }
    }

    fn map(records: &[Record], hull_radius_m: Option<f64>) -> Map {
        let mut mapper = FootprintMapper::new(Walls, 0.01, hull_radius_m);
        records.iter().for_each(|record| mapper.take(record));
        mapper.map()
    }

    fn free(map: &Map) -> Vec<(f64, f64)> {
        let free = map.cells_of(Occupancy::Free);
        free.map(|cell| map.centre(cell)).collect()
    }

    #[test]
    fn no_cell_under_the_hull_is_occupied_and_none_beside_it_is_cleared() {
        let map = map(&[pose(0.005, 0.005)], Some(RADIUS_M));
        for (cell, belief) in map.iter() {
            let (x, y) = map.centre(cell);
            let from_robot_m = ((x - 0.005).powi(2) + (y - 0.005).powi(2)).sqrt();
            if from_robot_m > 0.19 {
                continue;
            }
            let is_under = from_robot_m < RADIUS_M - 1e-6;
            assert_eq!(belief.p_occ() < 0.5, is_under, "({x}, {y})");
        }
        // Points of a square lattice within 4.99 of the origin; twelve more lie on 5.
        assert_eq!(free(&map).len(), 69);
    }

    #[test]
    fn a_wall_that_touches_the_hull_keeps_its_cells() {
        // The robot's left edge is at y = 0.05, and a wall begins there.
        let map = map(
            &[pose(-0.1, 0.0), pose(0.0, 0.0), pose(0.1, 0.0)],
            Some(RADIUS_M),
        );
        let free = free(&map);
        assert!(free.iter().any(|(_, y)| *y > 0.044), "{free:?}");
        assert!(free.iter().all(|(_, y)| *y < 0.05), "{free:?}");
    }

    #[test]
    fn the_way_between_two_poses_is_free() {
        // Two discs 95 mm apart leave corners between them.
        let records = [pose(-0.0475, 0.0), pose(0.0475, 0.0)];
        let swept = map(&records, Some(RADIUS_M));
        let between = swept.cell_at(0.005, 0.045).unwrap();
        assert_eq!(swept.occupancy(between), Occupancy::Free);
        // The order does not matter.
        let [first, last] = records;
        assert_eq!(map(&[last, first], Some(RADIUS_M)), swept);
    }

    #[test]
    fn nothing_is_swept_across_odometry_that_was_reset_or_jumped() {
        let between = |records: &[Record]| {
            let map = map(records, Some(RADIUS_M));
            map.occupancy(map.cell_at(0.005, 0.045).unwrap())
        };
        let reset = Record::OdometryReset { stamp_us: 0 };
        let broken = [pose(-0.0475, 0.0), reset, pose(0.0475, 0.0)];
        assert_eq!(between(&broken), Occupancy::Occupied);
        assert_eq!(
            between(&[pose(-0.15, 0.0), pose(0.15, 0.0)]),
            Occupancy::Occupied
        );
    }

    #[test]
    fn without_a_radius_the_map_is_the_mappers() {
        assert_eq!(map(&[pose(0.0, 0.0)], None), Walls.map());
    }

    #[test]
    fn a_pose_that_is_no_place_clears_nothing() {
        let records = [
            pose(f64::NAN, 0.0),
            pose(3e38, 0.0),
            pose(f64::INFINITY, 0.0),
        ];
        assert_eq!(free(&map(&records, Some(RADIUS_M))), []);
    }
}
