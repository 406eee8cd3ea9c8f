//! The smallest cells that a rig's cones can be mapped with.

use sim_harness::mapping::MAX_CELLS;
use sim_harness::rig::Rig;
use sim_harness::sensors::Sensor;

/// Refuses cells so small that the square around a cone has more of them than a map holds:
/// every return costs that square, and most of it would be refused.
pub(super) fn check(rig: &Rig, cell_mm: u16) -> Result<(), String> {
    let side_cells = (MAX_CELLS as f64).sqrt();
    for mount in &rig.mounts {
        let Sensor::Cone(cone) = &mount.sensor else {
            continue;
        };
        let [_, range_m] = cone.range_m;
        let least_mm = (1e3 * 2.0 * range_m / side_cells).ceil();
        if f64::from(cell_mm) < least_mm {
            return Err(format!(
                "rig {}: the range of mount \"{}\" is {range_m} m: cells of {cell_mm} mm would be \
                 more than the {MAX_CELLS} of a map, --cell-mm {least_mm} is enough",
                rig.name, mount.name
            ));
        }
    }
    Ok(())
}
