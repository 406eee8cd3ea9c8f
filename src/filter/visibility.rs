//! Visibility: which sensors can possibly have a place in view.
//!
//! Lobes of 60 degrees at a spacing of 45 overlap only in pairs and triples, so most
//! of the ring need not be evaluated for a particle. A coarse table over the local map
//! names those that must be.

use crate::geometry::Point;
use crate::model::{BeamPattern, Mount, SENSORS, SensorMask};

/// Cells along each side of the table.
const SIDE: usize = 32;
/// Cells a metre: the table spans +-512 mm, all that a particle can be at.
const CELLS_PER_METRE: f32 = 31.25;
/// Half a cell's diagonal and a little, metres.
const REACH_M: f32 = 0.0227;

/// For each 32 mm cell of the body frame, the sensors that may see a part of it.
///
/// Conservative: a sensor outside the set sees nothing of the cell, one inside it may
/// still not see a given place. 1 KiB.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Visibility {
    rows: [[SensorMask; SIDE]; SIDE],
}

impl Visibility {
    /// Tabulates the mounts' views; about 200 000 instructions, once a run.
    pub(crate) fn of(mounts: &[Mount; SENSORS], lobe: &BeamPattern) -> Self {
        let mut rows = [[SensorMask::NONE; SIDE]; SIDE];
        for (row, cells) in rows.iter_mut().enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                let centre = Point::new(centre_of(column), centre_of(row));
                for (sensor, mount) in mounts.iter().enumerate() {
                    if may_see(mount, lobe, centre) {
                        *cell = cell.with(sensor);
                    }
                }
            }
        }
        Self { rows }
    }

    /// The sensors that may have a place in view; none beyond +-512 mm.
    #[inline]
    pub(crate) fn at(&self, place: Point) -> SensorMask {
        let (row, column) = (cell_of(place.y), cell_of(place.x));
        match self.rows.get(row).and_then(|cells| cells.get(column)) {
            Some(mask) => *mask,
            None => SensorMask::NONE,
        }
    }
}

fn centre_of(cell: usize) -> f32 {
    (cell as f32 + 0.5 - 0.5 * SIDE as f32) / CELLS_PER_METRE
}

/// The conversion takes what is below the table to its edge, which is conservative
/// enough: nothing lies there.
#[inline]
fn cell_of(metres: f32) -> usize {
    (metres * CELLS_PER_METRE + 0.5 * SIDE as f32) as usize
}

/// Whether a cone reaches within [`REACH_M`] of a point.
///
/// By the distance to the line that bounds the cone on the point's side: never more
/// than that to the cone itself.
fn may_see(mount: &Mount, lobe: &BeamPattern, centre: Point) -> bool {
    let seen = mount.sensor_from_body(centre);
    let tangent = lobe.tangent_max();
    let line = Point::new(1.0, tangent).norm();
    seen.y.abs() - tangent * seen.x <= REACH_M * line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Photometry, Ring};
    use crate::random::{Generator, uniform};

    #[test]
    fn no_sensor_that_sees_a_place_is_missing() {
        let lobe = BeamPattern::of(&Photometry::VCNL4020);
        let mounts = core::array::from_fn(|index| Ring::AMIRO.mount(index));
        let visibility = Visibility::of(&mounts, &lobe);
        let mut rng = Generator::seeded(5);
        let mut asked = 0;
        for _ in 0..200_000 {
            let place = Point::new(
                1.023 * uniform(&mut rng) - 0.5115,
                1.023 * uniform(&mut rng) - 0.5115,
            );
            let candidates = visibility.at(place);
            asked += candidates.len();
            for (index, mount) in mounts.iter().enumerate() {
                let seen = mount.sensor_from_body(place);
                let sees = seen.x > 0.0 && seen.y.abs() <= lobe.tangent_max() * seen.x;
                assert!(
                    !sees || candidates.contains(index),
                    "sensor {index}, {place:?}"
                );
            }
        }
        assert!(
            asked < 4 * 200_000,
            "{asked} candidates: the table saves nothing"
        );
    }

    #[test]
    fn no_sensor_is_checked_for_a_cell_outside_its_lobe() {
        let lobe = BeamPattern::of(&Photometry::VCNL4020);
        let mounts: [Mount; SENSORS] = core::array::from_fn(|index| Ring::AMIRO.mount(index));
        let visibility = Visibility::of(&mounts, &lobe);
        // 32 cells of 32 mm, the middle of the robot between the 16th and the 17th.
        let centre = |cell: i32| (cell as f32 - 15.5) * 0.032;
        for (row, column) in (0..32).flat_map(|row| (0..32).map(move |column| (row, column))) {
            let place = Point::new(centre(column), centre(row));
            for sensor in visibility.at(place).iter() {
                let seen = mounts[sensor].sensor_from_body(place);
                // Beside the line at 60 degrees, to the right of it positive.
                let beside_m = 0.5 * (seen.y.abs() - crate::math::sqrt(3.0) * seen.x);
                // Half a diagonal is 22.63 mm.
                assert!(beside_m <= 0.0228, "{sensor}, {place:?}: {beside_m} m");
            }
        }
    }
}
