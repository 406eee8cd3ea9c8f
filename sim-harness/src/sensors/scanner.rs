//! The cells on a beam.

use super::{Echo, Region, SeenCell};
use crate::geometry::{Pose2, Turn};
use crate::mapping::Lattice;
use crate::rig::Scanner;

/// Places per cell at which a beam is looked at.
const SAMPLES_PER_CELL: f64 = 4.0;

/// Every cell on a beam before the echo, each once from near to far, and the one cell
/// that holds the echo.
///
/// Of cells before the echo those within the tolerance are left out: a surface that is
/// met at a grazing angle touches them. Cost: four places per cell of the beam's length.
pub(super) fn footprint(
    scanner: &Scanner,
    index: usize,
    echo: Echo,
    lattice: Lattice,
    world_from_sensor: &Pose2,
    visit: &mut dyn FnMut(SeenCell),
) {
    let bearing_rad = scanner.first_rad + index as f64 * scanner.step_rad;
    let direction = Turn::by_radians_f64(bearing_rad)
        .after(world_from_sensor.heading)
        .direction();
    let at = |range_m: f64| {
        let place = world_from_sensor.position + direction.scaled(range_m);
        lattice.cell_at(place.x, place.y)
    };
    let Some(end) = at(echo.measured_m) else {
        return;
    };
    let step_m = lattice.cell_m() / SAMPLES_PER_CELL;
    let mut last = None;
    let mut number = 0_u32;
    loop {
        let range_m = f64::from(number) * step_m;
        number += 1;
        let Some(region) = echo
            .region(range_m)
            .filter(|region| *region != Region::AtEcho)
        else {
            break;
        };
        let Some(cell) = at(range_m) else { break };
        if last == Some(cell) || echo.is_echo && cell == end {
            continue;
        }
        last = Some(cell);
        visit(SeenCell {
            cell,
            region,
            range_m,
            measured_m: echo.measured_m,
        });
    }
    if echo.is_echo {
        visit(SeenCell {
            cell: end,
            region: Region::AtEcho,
            range_m: echo.measured_m,
            measured_m: echo.measured_m,
        });
    }
}
