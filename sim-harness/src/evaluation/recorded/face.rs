//! Faces of walls: where a place lies relative to one.

use crate::geometry::Vector;
use crate::world::SensorPose;

/// Length of the pieces that a face is looked for in, metres: a map cell.
const PIECE_M: f64 = 0.010;
/// How far a wall must reach beyond both of a sensor's edges for its face to be abeam,
/// metres: the widest ray that returns much then ends on it.
const ABEAM_M: f64 = 0.05;
/// Cosine of the angle to a face's normal within which a sensor looks at it: 45 degrees.
const ABEAM_COSINE: f64 = 0.7;

/// The face of a wall that the robot drove past, straight from one end to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    pub(super) from: Vector,
    pub(super) to: Vector,
    /// The unit normal that points away from the first station.
    pub(super) away: Vector,
    /// Distance of the first station from the face's line, metres.
    first_m: f64,
}

impl Face {
    /// The face with the given ends, turned to the first station; `None` without a length,
    /// or if the station is within 1 mm of the face's line, so that there is no side.
    pub(super) fn towards(first: Vector, from: Vector, to: Vector) -> Option<Self> {
        let way = to - from;
        let length_m = way.norm();
        let left = Vector::new(-way.y / length_m, way.x / length_m);
        let first_m = (first - from).dot(left);
        // NaN is no distance: the ends are the same place.
        if first_m.abs() < 1e-3 || first_m.is_nan() {
            return None;
        }
        Some(Self {
            from,
            to,
            away: left.scaled(-1.0_f64.copysign(first_m)),
            first_m: first_m.abs(),
        })
    }

    pub(super) fn length_m(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The unit vector from the first end to the second.
    pub(super) fn direction(&self) -> Vector {
        let way = self.to - self.from;
        way.scaled(1.0 / way.norm())
    }

    /// Distance of a place from the first end, along the face.
    pub(super) fn along_m(&self, place: Vector) -> f64 {
        let way = self.to - self.from;
        (place - self.from).dot(way) / way.norm()
    }

    pub(super) fn distance_m(&self, place: Vector) -> f64 {
        place.distance_from_segment(self.from, self.to)
    }

    /// How far behind the face a place is, below 0 before it; `None` for a place that is
    /// not between the ends, or not on the face's side of the first station.
    pub(super) fn behind_m(&self, place: Vector) -> Option<f64> {
        let is_between = (0.0..=self.length_m()).contains(&self.along_m(place));
        let behind_m = (place - self.from).dot(self.away);
        (is_between && behind_m > -self.first_m).then_some(behind_m)
    }

    /// Middles of the pieces that the face is looked for in.
    pub(super) fn pieces(&self) -> impl Iterator<Item = Vector> {
        let way = self.to - self.from;
        let count = (way.norm() / PIECE_M).round().max(1.0) as u32;
        let from = self.from;
        (0..count).map(move |piece| from + way.scaled((f64::from(piece) + 0.5) / f64::from(count)))
    }

    /// Whether a sensor looks at the face, within 45 degrees of its normal, from between
    /// its ends.
    pub(super) fn is_abeam(&self, sensor_pose: &SensorPose) -> bool {
        let between = ABEAM_M..=self.length_m() - ABEAM_M;
        sensor_pose.axis.direction().dot(self.away) > ABEAM_COSINE
            && between.contains(&self.along_m(sensor_pose.position))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(from: (f64, f64), to: (f64, f64)) -> Option<Face> {
        let vector = |(x, y)| Vector::new(x, y);
        Face::towards(Vector::new(0.1, 0.0), vector(from), vector(to))
    }

    #[test]
    fn a_face_is_turned_to_the_first_station_whatever_the_order_of_its_ends() {
        for (from, to) in [((0.0, 0.2), (0.4, 0.2)), ((0.4, 0.2), (0.0, 0.2))] {
            let face = face(from, to).unwrap();
            let behind = |x, y| face.behind_m(Vector::new(x, y));
            assert!((behind(0.1, 0.25).unwrap() - 0.05).abs() < 1e-12);
            assert!((behind(0.3, 0.15).unwrap() + 0.05).abs() < 1e-12);
            assert_eq!(behind(-0.01, 0.2), None, "before its end");
            assert_eq!(behind(0.41, 0.2), None, "beyond its end");
            assert_eq!(behind(0.2, -0.01), None, "on the robot's other side");
            assert_eq!(face.pieces().count(), 40);
        }
    }

    #[test]
    fn a_slanted_face_measures_along_its_normal() {
        // From (0.3, 0) upwards at 135 degrees; its normal away from the robot is at 45.
        let slanted = face((0.3, 0.0), (0.1, 0.2)).unwrap();
        let half = 0.5_f64.sqrt();
        assert!((slanted.away - Vector::new(half, half)).norm() < 1e-12);
        let behind = slanted.behind_m(Vector::new(0.21, 0.11)).unwrap();
        assert!((behind - 0.02 * half).abs() < 1e-12, "{behind}");
    }

    #[test]
    fn a_wall_in_line_with_the_first_station_has_no_face() {
        assert_eq!(face((0.3, 0.0), (0.5, 0.0)), None);
        assert_eq!(face((0.3, 0.2), (0.3, 0.2)), None);
    }
}
