//! A straight wall that a method has fitted, with the uncertainty of its ends.

use crate::geometry::Vector;
use crate::sensors::WallSegment;

/// A wall of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedWall {
    /// Where it is, metres in the world.
    pub segment: WallSegment,
    /// Covariance of its ends, m^2, row by row: x and y of `from`, then of `to`. That of
    /// the linearised fit, the walls nearby fitted with it.
    pub covariance_m2: [[f64; 4]; 4],
    /// By how much the cost rises without it.
    pub gain: f64,
}

impl MappedWall {
    /// Standard deviations of `from` and `to` in a direction, given by a unit vector, metres;
    /// infinite for an end that no reading determines.
    #[must_use]
    pub fn end_sigmas_m(&self, direction: Vector) -> [f64; 2] {
        let [[xx, xy, ..], [_, yy, ..], [_, _, to_xx, to_xy], [.., to_yy]] = self.covariance_m2;
        let Vector { x, y } = direction;
        let sigma = |xx: f64, xy: f64, yy: f64| {
            let variance = x * x * xx + 2.0 * x * y * xy + y * y * yy;
            // Of infinite terms the sum may be undefined.
            if variance.is_finite() {
                variance.max(0.0).sqrt()
            } else {
                f64::INFINITY
            }
        };
        [sigma(xx, xy, yy), sigma(to_xx, to_xy, to_yy)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sigma_of_an_end_is_that_in_the_direction_asked_for() {
        let mut covariance_m2 = [[0.0; 4]; 4];
        for (place, variance) in [4.0, 9.0, 16.0, 25.0].into_iter().enumerate() {
            covariance_m2[place][place] = variance;
        }
        // Of x and y of the second end as if both were one unknown.
        (covariance_m2[2][3], covariance_m2[3][2]) = (20.0, 20.0);
        let wall = MappedWall {
            segment: WallSegment::new(Vector::new(0.0, 0.0), Vector::new(1.0, 0.0)),
            covariance_m2,
            gain: 1.0,
        };
        let expect = |wall: &MappedWall, direction: (f64, f64), expected: [f64; 2]| {
            let sigmas = wall.end_sigmas_m(Vector::new(direction.0, direction.1));
            for (sigma, expected) in sigmas.into_iter().zip(expected) {
                assert!(
                    (sigma - expected).abs() < 1e-12,
                    "{direction:?}: {sigmas:?}"
                );
            }
        };
        expect(&wall, (1.0, 0.0), [2.0, 4.0]);
        expect(&wall, (0.0, 1.0), [3.0, 5.0]);
        let apart = (0.36_f64 * 4.0 + 0.64 * 9.0).sqrt();
        expect(&wall, (0.6, 0.8), [apart, 0.6 * 4.0 + 0.8 * 5.0]);
        let unknown = MappedWall {
            covariance_m2: [[f64::INFINITY; 4]; 4],
            ..wall
        };
        let sigmas = unknown.end_sigmas_m(Vector::new(0.6, -0.8));
        assert!(sigmas.iter().all(|sigma| sigma.is_infinite()), "{sigmas:?}");
    }
}
