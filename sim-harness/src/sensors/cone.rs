//! The cells in a cone: sonar, and wide time-of-flight sensors.

use super::{RangeSensor, Region, SeenCell, View};

/// A sensor that returns the nearest surface in a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Half of the opening angle, radians, in (0, pi/2) (H).
    pub half_angle_rad: f64,
    /// Nearest and farthest range that it measures, metres.
    pub range_m: [f64; 2],
    /// Standard deviation of a range, metres.
    pub sigma_m: f64,
    /// How the echo's strength falls off the axis.
    pub directivity: Directivity,
}

/// How the strength of an echo falls off the axis of a cone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Directivity {
    /// As that of a round piston that sends and receives, a sonar's transducer.
    #[default]
    Piston,
    /// Not at all, within the cone: light.
    Flat,
}

/// Every cell whose centre lies in the cone up to the echo's far side, row by row.
///
/// A cone is narrower than a cell below half a cell over the half angle's tangent: there
/// it may hold no centre.
impl RangeSensor for Cone {
    fn returns(&self) -> usize {
        1
    }

    fn footprint(&self, view: &View, visit: &mut dyn FnMut(SeenCell)) -> bool {
        let Some(range) = view.range() else {
            return true;
        };
        let tangent = libm::tan(self.half_angle_rad);
        let Some(cells) = view.wedge(tangent, range.measured_m + range.tolerance_m) else {
            return false;
        };
        for (cell, seen) in cells {
            let range_m = seen.norm();
            let region = range.region(range_m);
            if let Some(region) = region.filter(|region| *region != Region::AtLimit) {
                visit(SeenCell {
                    cell,
                    region,
                    range_m,
                    bearing_rad: libm::atan2(seen.y, seen.x),
                    weight: 1.0,
                    measured_m: range.measured_m,
                });
            }
        }
        true
    }
}
