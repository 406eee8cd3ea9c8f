//! Exact walls of a recording's room: a list of segments.

use crate::geometry::Vector;

/// Distance from one point of a wall to the next, metres.
const POINT_M: f64 = 0.06;

/// How far before its end a line of sight may meet a wall, metres: the wall itself.
const SAME_M: f64 = 1e-6;

/// The walls of a room.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomWalls {
    segments: Vec<[Vector; 2]>,
}

impl RoomWalls {
    /// Walls between these ends.
    #[must_use]
    pub fn new(segments: Vec<[Vector; 2]>) -> Self {
        Self { segments }
    }

    /// The walls' ends.
    #[must_use]
    pub fn segments(&self) -> &[[Vector; 2]] {
        &self.segments
    }

    /// Distance from a place to the nearest wall, metres.
    #[must_use]
    pub fn distance_m(&self, place: Vector) -> f64 {
        let walls = self.segments.iter();
        let distances = walls.map(|[from, to]| place.distance_from_segment(*from, *to));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Points on the walls, 6 cm apart, at most so far from a place, metres.
    #[must_use]
    pub fn points_within(&self, place: Vector, range_m: f64) -> Vec<Vector> {
        let walls = self.segments.iter();
        let points = walls.flat_map(|[from, to]| {
            let way = *to - *from;
            let count = (way.norm() / POINT_M).floor() as u32;
            (0..=count).map(move |index| {
                let share = f64::from(index) * POINT_M / way.norm();
                *from + way.scaled(if count == 0 { 0.5 } else { share })
            })
        });
        points
            .filter(|point| (*point - place).norm() <= range_m)
            .collect()
    }

    /// Whether no wall lies between a place and a point of a wall.
    #[must_use]
    pub fn is_in_sight(&self, place: Vector, point: Vector) -> bool {
        let way = point - place;
        let length_m = way.norm();
        let walls = self.segments.iter();
        let mut crossed = walls.filter_map(|[from, to]| {
            let wall = *to - *from;
            let across = way.cross(wall);
            let along = (*from - place).cross(wall) / across;
            let beside = (*from - place).cross(way) / across;
            // NaN of a wall along the line of sight crosses nothing.
            (0.0..=1.0)
                .contains(&beside)
                .then_some(along * length_m)
                .filter(|crossed_m| *crossed_m > SAME_M)
        });
        !crossed.any(|crossed_m| crossed_m < length_m - SAME_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walls() -> RoomWalls {
        let wall = |x1, y1, x2, y2| [Vector::new(x1, y1), Vector::new(x2, y2)];
        RoomWalls::new(vec![
            wall(0.0, 1.0, 2.0, 1.0),
            wall(1.0, 0.5, 2.0, 0.5),
            wall(0.0, 0.0, 0.01, 0.0),
        ])
    }

    #[test]
    fn a_wall_hides_what_is_behind_it_and_not_itself() {
        let walls = walls();
        let robot = Vector::new(1.5, 0.0);
        assert!(!walls.is_in_sight(robot, Vector::new(1.5, 1.0)));
        assert!(walls.is_in_sight(robot, Vector::new(1.5, 0.5)));
        assert!(walls.is_in_sight(robot, Vector::new(0.0, 1.0)));
        assert!((walls.distance_m(robot) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn points_lie_on_the_walls_6_cm_apart() {
        let points = walls().points_within(Vector::new(0.0, 1.0), 0.2);
        assert_eq!(points.len(), 4);
        assert!((points[3] - Vector::new(0.18, 1.0)).norm() < 1e-12);
        assert_eq!(walls().points_within(Vector::new(0.0, 0.0), 0.1).len(), 1);
    }
}
