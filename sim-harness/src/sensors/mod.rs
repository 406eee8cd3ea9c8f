//! Where the sensors of a rig look: the cells of a grid that a return speaks of.

mod cone;
mod scanner;

use crate::drive::Return;
use crate::geometry::Pose2;
use crate::mapping::{Cell, Lattice};
use crate::rig::Sensor;

/// A cell that a return speaks of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenCell {
    /// The cell.
    pub cell: Cell,
    /// What the return says about it.
    pub region: Region,
    /// Distance of the cell's centre from the sensor, metres (r).
    pub range_m: f64,
    /// The range that was measured, or the limit without an echo, metres (z).
    pub measured_m: f64,
}

/// Where a cell lies with regard to a return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Before the echo (E).
    Before,
    /// Within the tolerance of the echo (O).
    AtEcho,
    /// Before the limit of a return without an echo.
    BeforeLimit,
}

/// Hands on every cell that a return of a sensor speaks of, each once.
///
/// `tolerance_m` is the half width of the band in which an echo lies (beta). The return
/// is the sensor's `index`th; `world_from_sensor` is the sensor's place. Returns that are
/// too close or invalid speak of no cell, and infrared returns are counts, of which
/// [`InverseSensorMapper`](crate::mapping::InverseSensorMapper) knows the cells.
pub fn footprint(
    sensor: &Sensor,
    index: usize,
    measured: Return,
    tolerance_m: f64,
    lattice: Lattice,
    world_from_sensor: &Pose2,
    visit: &mut dyn FnMut(SeenCell),
) {
    let (measured_m, is_echo) = match measured {
        Return::Echo { range_m, .. } => (range_m, true),
        Return::NoEcho { limit_m } => (limit_m, false),
        Return::TooClose | Return::Invalid => return,
    };
    let echo = Echo {
        measured_m,
        is_echo,
        tolerance_m,
    };
    match sensor {
        Sensor::Infrared(_) => {}
        Sensor::Cone(cone) => cone::footprint(cone, echo, lattice, world_from_sensor, visit),
        Sensor::Scanner(scanner) => {
            scanner::footprint(scanner, index, echo, lattice, world_from_sensor, visit);
        }
    }
}

/// A measured range and how exactly it is taken.
#[derive(Clone, Copy, Debug)]
struct Echo {
    measured_m: f64,
    is_echo: bool,
    tolerance_m: f64,
}

impl Echo {
    /// The farthest range that the return speaks of, metres.
    fn reach_m(&self) -> f64 {
        if self.is_echo {
            self.measured_m + self.tolerance_m
        } else {
            self.measured_m - self.tolerance_m
        }
    }

    /// Where a range lies; `None` beyond all that the return speaks of.
    fn region(&self, range_m: f64) -> Option<Region> {
        if range_m < self.measured_m - self.tolerance_m {
            Some(if self.is_echo {
                Region::Before
            } else {
                Region::BeforeLimit
            })
        } else if self.is_echo && range_m <= self.measured_m + self.tolerance_m {
            Some(Region::AtEcho)
        } else {
            None
        }
    }
}
