//! A straight line through points, and the points that lie on it.

use serde::Serialize;

use crate::world::Vector;

/// A straight line of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// A place on the line: x and y, metres.
    pub point_m: [f64; 2],
    /// The unit vector along it.
    pub direction: [f64; 2],
}

impl core::fmt::Display for Line {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let ([x, y], [along_x, along_y]) = (self.point_m, self.direction);
        write!(
            f,
            "through ({x:.3}, {y:.3}) m along ({along_x:.3}, {along_y:.3})"
        )
    }
}

impl Line {
    /// The line through two places; `None` if they are the same.
    #[must_use]
    pub fn through(from: Vector, to: Vector) -> Option<Self> {
        let way = to - from;
        let length = way.norm();
        (length > 0.0).then(|| Self::along(from, way.scaled(1.0 / length)))
    }

    fn along(point: Vector, direction: Vector) -> Self {
        Self {
            point_m: [point.x, point.y],
            direction: [direction.x, direction.y],
        }
    }

    /// The line of least squared distances (total least squares); `None` for fewer
    /// than two places and for places that prefer no direction.
    ///
    /// The eigenvector of the larger eigenvalue of the covariance, by square root only.
    #[must_use]
    pub fn fitted(places: &[Vector]) -> Option<Self> {
        let count = places.len() as f64;
        let sum = places
            .iter()
            .fold(Vector::default(), |sum, place| sum + *place);
        let mean = sum.scaled(1.0 / count);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for place in places {
            let from_mean = *place - mean;
            xx += from_mean.x * from_mean.x;
            xy += from_mean.x * from_mean.y;
            yy += from_mean.y * from_mean.y;
        }
        let half_difference = 0.5 * (xx - yy);
        let spread = (half_difference * half_difference + xy * xy).sqrt();
        // Of the two forms of the eigenvector the one without cancellation.
        let along = if half_difference >= 0.0 {
            Vector::new(half_difference + spread, xy)
        } else {
            Vector::new(xy, spread - half_difference)
        };
        let length = along.norm();
        (length > 0.0).then(|| Self::along(mean, along.scaled(1.0 / length)))
    }

    fn offset(&self, place: Vector) -> Vector {
        let [x, y] = self.point_m;
        place - Vector::new(x, y)
    }

    fn direction(&self) -> Vector {
        let [x, y] = self.direction;
        Vector::new(x, y)
    }

    /// Distance of a place from the line, metres.
    #[must_use]
    pub fn distance_m(&self, place: Vector) -> f64 {
        self.direction().cross(self.offset(place)).abs()
    }

    /// Where along the line a place is, metres from [`point_m`](Self::point_m).
    #[must_use]
    pub fn along_m(&self, place: Vector) -> f64 {
        self.direction().dot(self.offset(place))
    }

    /// Root of the mean squared distance; `None` without places.
    #[must_use]
    pub fn rms_m(&self, places: &[Vector]) -> Option<f64> {
        if places.is_empty() {
            return None;
        }
        let squares = places.iter().map(|place| self.distance_m(*place));
        let sum: f64 = squares.map(|distance| distance * distance).sum();
        Some((sum / places.len() as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Turn;

    #[test]
    fn a_line_at_any_angle_is_found_again() {
        for degrees in [0.0, 10.0, 45.0, 80.0, 90.0, 135.0, 179.0] {
            let turn = Turn::by_degrees(degrees);
            let places: Vec<_> = (0..50)
                .map(|index| Vector::new(0.01 * f64::from(index), 0.002 * f64::from(index % 2)))
                .map(|place| Vector::new(0.3, -0.2) + place.turned(turn))
                .collect();
            let line = Line::fitted(&places).unwrap();
            // 1 mm to each side; the slope of the alternation is below 1e-3.
            let rms = line.rms_m(&places).unwrap();
            assert!((rms - 0.001).abs() < 1e-6, "{degrees} degrees: {rms}");
            let [x, y] = line.direction;
            let off = turn.direction().cross(Vector::new(x, y)).abs();
            assert!(off < 1e-3, "{degrees} degrees: {off}");
        }
    }

    #[test]
    fn too_few_places_make_no_line() {
        assert_eq!(Line::fitted(&[]), None);
        assert_eq!(Line::fitted(&[Vector::new(1.0, 1.0)]), None);
        let place = Vector::new(1.0, 1.0);
        assert_eq!(Line::through(place, place), None);
        let line = Line::through(Vector::default(), Vector::new(0.0, 2.0)).unwrap();
        assert!((line.distance_m(place) - 1.0).abs() < 1e-12);
        assert!((line.along_m(place) - 1.0).abs() < 1e-12);
        assert_eq!(line.rms_m(&[]), None);
    }
}
