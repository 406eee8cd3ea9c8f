//! The cells in a cone: sonar, and wide time-of-flight sensors.

use super::{RangeSensor, Region, SeenCell, View};
use crate::geometry::Vector;

/// A sensor that returns the nearest surface in a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Half of the opening angle, radians, in (0, pi/2) (H).
    pub half_angle_rad: f64,
    /// Nearest and farthest range that it measures, metres.
    pub range_m: [f64; 2],
    /// Standard deviation of a range, metres.
    pub sigma_m: f64,
}

/// Every cell whose centre lies in the cone up to the echo's far side, row by row.
///
/// A cone is narrower than a cell below half a cell over the half angle's tangent: there
/// it may hold no centre. Cost: the cells of the square around the sensor.
impl RangeSensor for Cone {
    fn returns(&self) -> usize {
        1
    }

    fn footprint(&self, view: &View, visit: &mut dyn FnMut(SeenCell)) -> bool {
        let Some(range) = view.range() else {
            return true;
        };
        let Some(cells) = view.square(range.measured_m + range.tolerance_m) else {
            return false;
        };
        let tangent = libm::tan(self.half_angle_rad);
        for cell in cells {
            let (x, y) = view.lattice.centre(cell);
            let seen = view.world_from_sensor.view(Vector::new(x, y));
            if seen.x <= 0.0 || seen.y.abs() > tangent * seen.x {
                continue;
            }
            let region = range.region(seen.norm());
            if let Some(region) = region.filter(|region| *region != Region::AtLimit) {
                visit(SeenCell {
                    cell,
                    region,
                    weight: 1.0,
                    measured_m: range.measured_m,
                });
            }
        }
        true
    }
}
