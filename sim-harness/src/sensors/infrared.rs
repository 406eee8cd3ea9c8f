//! The cells in the lobe of a reflective infrared sensor.

use std::sync::Arc;

use amiro_ipf::model::{BeamPattern, Photometry};

use super::{MeasuredRange, RangeSensor, SeenCell, View};

/// Least cos(xi theta) at which a return is evidence about a cell.
const LEAST_DIRECTIVITY: f64 = 0.05;

/// A reflective infrared sensor by its photometric law (Korthals et al. 2016, equation 5).
///
/// A reading is ambiguous over the lobe: under the bearing theta it stands for the range
/// x(theta) = x(0) S(theta), S = sqrt(cos(xi theta)), and its error shrinks by the same
/// factor. The evidence weighs cos(xi theta). The bearing's cosine comes from the core's
/// table of the lobe, within 4e-4 of cos(xi theta).
#[derive(Clone, Debug, PartialEq)]
pub struct Infrared {
    photometry: Photometry,
    /// Shared by the sensors of a ring.
    lobe: Arc<BeamPattern>,
}

impl Infrared {
    /// A sensor of the given law.
    #[must_use]
    pub fn new(photometry: Photometry) -> Self {
        Self {
            lobe: Arc::new(BeamPattern::of(&photometry)),
            photometry,
        }
    }

    /// The law's parameters.
    #[must_use]
    pub fn photometry(&self) -> &Photometry {
        &self.photometry
    }
}

/// Every cell within theta_max of the axis up to the arc or a cell or standard deviation
/// beyond it, row by row.
impl RangeSensor for Infrared {
    fn returns(&self) -> usize {
        1
    }

    fn footprint(&self, view: &View, visit: &mut dyn FnMut(SeenCell)) -> bool {
        let Some(on_axis) = view.range() else {
            return true;
        };
        let reach_m = on_axis.measured_m + on_axis.sigma_m.max(view.lattice.cell_m());
        let tangent = f64::from(self.lobe.tangent_max());
        let Some(cells) = view.wedge(tangent, reach_m) else {
            return false;
        };
        for (cell, seen) in cells {
            let range_m = seen.norm();
            let lobe = f64::from(self.lobe.at((seen.x / range_m) as f32));
            let directivity = lobe * lobe;
            if range_m > reach_m || directivity < LEAST_DIRECTIVITY {
                continue;
            }
            let arc = MeasuredRange {
                measured_m: on_axis.measured_m * lobe,
                tolerance_m: view.tolerance_m.max(on_axis.sigma_m * lobe),
                ..on_axis
            };
            if let Some(region) = arc.region(range_m) {
                visit(SeenCell {
                    cell,
                    region,
                    range_m,
                    bearing_rad: libm::atan2(seen.y, seen.x),
                    weight: directivity,
                    measured_m: arc.measured_m,
                });
            }
        }
        true
    }
}
