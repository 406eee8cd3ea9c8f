//! Distances of a map's occupied cells from the surfaces that were visible.

use super::Truth;
use crate::mapping::{Map, Occupancy};
use crate::world::Vector;

/// Farthest surface place that an occupied cell belongs to, metres; a cell without one is
/// false, and its distance says nothing of where walls are placed.
const NEAR_M: f64 = 0.080;

/// How far occupied cells lie behind the nearest visible surface, over the cells of the
/// judged rectangle within 80 mm of one; below 0 is before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceOffset {
    /// Mean, metres; `None` without such a cell.
    pub bias_m: Option<f64>,
    /// Root mean square, metres.
    pub rms_m: Option<f64>,
}

impl SurfaceOffset {
    /// Measures a map.
    ///
    /// A cell within a shape is behind its surface; another one is if it lies farther away
    /// than the surface place, along the ray on which that was first seen.
    ///
    /// Cost: occupied cells times places of the visible surface.
    #[must_use]
    pub fn of(map: &Map, truth: &Truth) -> Self {
        let centres = map.cells_of(Occupancy::Occupied).map(|cell| {
            let (x, y) = map.centre(cell);
            Vector::new(x, y)
        });
        let judged = centres.filter(|centre| truth.is_judged(*centre));
        let offsets: Vec<f64> = judged
            .filter_map(|centre| offset_m(truth, centre))
            .collect();
        let mean = |sum: f64| (!offsets.is_empty()).then(|| sum / offsets.len() as f64);
        Self {
            bias_m: mean(offsets.iter().sum()),
            rms_m: mean(offsets.iter().map(|offset| offset * offset).sum()).map(f64::sqrt),
        }
    }
}

fn offset_m(truth: &Truth, centre: Vector) -> Option<f64> {
    let places = truth.surface().iter().zip(truth.seen_along());
    let distances = places.map(|(place, along)| ((centre - *place).norm(), place, along));
    let (distance_m, place, along) = distances.min_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
    let is_behind = truth.is_wall(centre, 0.0) || (centre - *place).dot(*along) > 0.0;
    let signed_m = if is_behind { distance_m } else { -distance_m };
    (distance_m <= NEAR_M).then_some(signed_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::mapping::Belief;
    use crate::world::Scenario;

    /// A block of 20 mm depth, 150 mm ahead of the robot, and a map of occupied cells.
    fn offset(places: &[(f64, f64)]) -> SurfaceOffset {
        let scenario = Scenario::parse(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-0.3, -0.3, 0.3, 0.3]\n\
             speed_m_per_s = 0.08\nsensors_deg = [0]\nstart = [0, 0, 0]\n\
             [[box]]\nmin = [0.15, -0.025]\nmax = [0.17, 0.025]\n",
        )
        .unwrap();
        let truth = Truth::of(&scenario, &[Pose2::new(0.0, 0.0, 0.0)]);
        let mut map = Map::unknown(0.01);
        for (x, y) in places {
            let cell = map.cell_at(*x, *y).unwrap();
            *map.reach(cell).unwrap() = Belief::of_probability(1.0);
        }
        SurfaceOffset::of(&map, &truth)
    }

    #[test]
    fn before_the_face_is_negative_and_behind_it_positive_within_the_shape_or_beyond() {
        // Centres are 2.5 mm beside the middle of a piece of surface.
        let close = |value: Option<f64>, metres: f64| (value.unwrap() - metres).abs() < 1e-3;
        let before = offset(&[(0.135, 0.005)]);
        assert!(
            close(before.bias_m, -0.015) && close(before.rms_m, 0.015),
            "{before:?}"
        );
        let within = offset(&[(0.165, 0.005)]);
        assert!(close(within.bias_m, 0.015), "{within:?}");
        let beyond = offset(&[(0.195, 0.005)]);
        assert!(close(beyond.bias_m, 0.045), "{beyond:?}");
        let both = offset(&[(0.135, 0.005), (0.165, 0.005)]);
        assert!(
            close(both.bias_m, 0.0) && close(both.rms_m, 0.015),
            "{both:?}"
        );
    }

    #[test]
    fn far_cells_and_cells_outside_of_the_rectangle_have_no_distance() {
        let far = offset(&[(0.005, 0.005), (0.35, 0.005)]);
        assert_eq!(far, SurfaceOffset::default());
    }
}
