//! The cells in a cone.

use super::{Echo, SeenCell};
use crate::geometry::{Pose2, Vector};
use crate::mapping::{Cell, Lattice};
use crate::rig::Cone;

/// Every cell whose centre lies in the cone up to the echo's far side, row by row.
///
/// A cone is narrower than a cell below half a cell over the half angle's tangent: there
/// it may hold no centre. Cost: the cells of the square around the sensor.
pub(super) fn footprint(
    cone: &Cone,
    echo: Echo,
    lattice: Lattice,
    world_from_sensor: &Pose2,
    visit: &mut dyn FnMut(SeenCell),
) {
    let tangent = libm::tan(cone.half_angle_rad);
    let reach_m = echo.reach_m();
    let reach = Vector::new(reach_m, reach_m);
    let low = world_from_sensor.position - reach;
    let high = world_from_sensor.position + reach;
    let (Some(low), Some(high)) = (
        lattice.cell_at(low.x, low.y),
        lattice.cell_at(high.x, high.y),
    ) else {
        return;
    };
    for row in low.row..=high.row {
        for column in low.column..=high.column {
            let cell = Cell { row, column };
            let (x, y) = lattice.centre(cell);
            let seen = world_from_sensor.view(Vector::new(x, y));
            if seen.x <= 0.0 || seen.y.abs() > tangent * seen.x {
                continue;
            }
            let range_m = seen.norm();
            if let Some(region) = echo.region(range_m) {
                visit(SeenCell {
                    cell,
                    region,
                    range_m,
                    measured_m: echo.measured_m,
                });
            }
        }
    }
}
