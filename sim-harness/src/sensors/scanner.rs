//! The cells on narrow beams: laser scanners, the columns of time-of-flight arrays.

use super::{RangeSensor, Region, SeenCell, View};
use crate::geometry::Turn;

/// Places per cell at which a beam is looked at.
const SAMPLES_PER_CELL: f64 = 4.0;

/// A sensor that returns one range per beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scanner {
    /// Beams of one scan.
    pub beams: u16,
    /// Bearing of the first beam off the axis, radians.
    pub first_rad: f64,
    /// From one beam to the next, radians; negative for a scan from left to right.
    pub step_rad: f64,
    /// Nearest and farthest range that it measures, metres.
    pub range_m: [f64; 2],
    /// Standard deviation of a range, metres.
    pub sigma_m: f64,
}

impl Scanner {
    /// Bearing of a beam off the axis, radians, by its number from 0.
    #[must_use]
    pub fn bearing_rad(&self, beam: usize) -> f64 {
        self.first_rad + beam as f64 * self.step_rad
    }
}

/// Every cell on a beam before the echo, each once from near to far, and the one cell
/// that holds the echo.
///
/// Of cells before the echo those within the tolerance are left out: a surface that is
/// met at a grazing angle touches them. Cost: four places per cell of the beam's length.
impl RangeSensor for Scanner {
    fn returns(&self) -> usize {
        usize::from(self.beams)
    }

    fn footprint(&self, view: &View, visit: &mut dyn FnMut(SeenCell)) -> bool {
        let Some(range) = view.range() else {
            return true;
        };
        let bearing_rad = self.bearing_rad(view.index);
        let direction = Turn::by_radians_f64(bearing_rad)
            .after(view.world_from_sensor.heading)
            .direction();
        let at = |range_m: f64| {
            let place = view.world_from_sensor.position + direction.scaled(range_m);
            view.lattice.cell_at(place.x, place.y)
        };
        let Some(end) = at(range.measured_m) else {
            return false;
        };
        let mut visit = |cell, region, range_m| {
            visit(SeenCell {
                cell,
                region,
                range_m,
                bearing_rad,
                weight: 1.0,
                measured_m: range.measured_m,
            });
        };
        let step_m = view.lattice.cell_m() / SAMPLES_PER_CELL;
        let mut last = None;
        for number in 0_u32.. {
            let range_m = f64::from(number) * step_m;
            let (Some(region), Some(cell)) = (range.region(range_m), at(range_m)) else {
                break;
            };
            if matches!(region, Region::AtEcho | Region::AtLimit) {
                break;
            }
            if last == Some(cell) || range.is_echo && cell == end {
                continue;
            }
            last = Some(cell);
            visit(cell, region, range_m);
        }
        if range.is_echo {
            visit(end, Region::AtEcho, range.measured_m);
        }
        true
    }
}
