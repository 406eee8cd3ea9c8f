//! The cells that the sensors of the ring look at in one step.

use amiro_ipf::model::{BeamPattern, Photometry, RangeEstimate, Reading, Ring, SensorMask};
use amiro_ipf::node::{Config, StepBegun};

use super::{Cell, Grid};
use crate::world::{Eye, Vector};

/// The sensors of one robot, as a mapper sees them.
#[derive(Clone, Debug)]
pub(super) struct Lobes {
    ring: Ring,
    used: SensorMask,
    photometry: Photometry,
    lobe: BeamPattern,
    /// Cells without content, for their places.
    cells: Grid<()>,
}

/// A cell's centre as one sensor sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellView {
    /// Distance of the centre from the sensor, metres (r).
    pub(super) range_m: f64,
    /// Distance of the reading's arc under the same bearing, metres (x).
    pub(super) arc_m: f64,
    /// Standard deviation of the arc from the sensor's noise, metres (sigma_x).
    pub(super) sigma_m: f64,
    /// C(theta) = cos(xi theta).
    pub(super) directivity: f64,
    /// Whether the arc is only the range limit.
    pub(super) is_limit: bool,
}

impl Lobes {
    /// The sensors of a configuration over cells of the given size, metres.
    pub(super) fn of(config: &Config, cell_m: f64) -> Self {
        Self {
            ring: config.ring,
            used: config.sensors,
            photometry: config.photometry,
            lobe: BeamPattern::of(&config.photometry),
            cells: Grid::new(cell_m, ()),
        }
    }

    /// Shows every cell within theta_max of a sensor's axis and up to its arc or a
    /// cell or standard deviation beyond; sensor by sensor, row by row. Whether every lobe
    /// could be shown: one that lies too far away for any grid has no cells.
    ///
    /// Sensors that say nothing about a range show nothing. The bearing's cosine
    /// comes from the core's table of the lobe, within 4e-4 of cos(xi theta).
    pub(super) fn show(&self, step: &StepBegun, mut visit: impl FnMut(Cell, CellView)) -> bool {
        let mut are_all_shown = true;
        for eye in Eye::of(&self.ring, self.used, &step.pose) {
            let Some(sample) = step.samples.get(eye.sensor) else {
                continue;
            };
            are_all_shown &= match self.photometry.read(*sample) {
                Reading::Range(echo) => self.show_lobe(&eye, echo, false, &mut visit),
                Reading::NothingInRange(echo) => self.show_lobe(&eye, echo, true, &mut visit),
                Reading::TooClose | Reading::Faulty => true,
            }
        }
        are_all_shown
    }

    fn show_lobe(
        &self,
        eye: &Eye,
        echo: RangeEstimate,
        is_limit: bool,
        visit: &mut impl FnMut(Cell, CellView),
    ) -> bool {
        let (axis_m, sigma_m) = (f64::from(echo.range_m), f64::from(echo.sigma_m));
        let reach_m = axis_m + sigma_m.max(self.cells.cell_m());
        let reach = Vector::new(reach_m, reach_m);
        let (low, high) = (eye.position - reach, eye.position + reach);
        let corners = (
            self.cells.cell_at(low.x, low.y),
            self.cells.cell_at(high.x, high.y),
        );
        let (Some(low), Some(high)) = corners else {
            return false;
        };
        for row in low.row..=high.row {
            for column in low.column..=high.column {
                let cell = Cell { row, column };
                let (x, y) = self.cells.centre(cell);
                let way = Vector::new(x, y) - eye.position;
                let Some((range_m, lobe)) = self.in_view(eye, way) else {
                    continue;
                };
                let view = CellView {
                    range_m,
                    arc_m: axis_m * lobe,
                    sigma_m: sigma_m * lobe,
                    directivity: lobe * lobe,
                    is_limit,
                };
                if range_m <= reach_m {
                    visit(cell, view);
                }
            }
        }
        true
    }

    /// Distance and lobe S of a place that a sensor has in view.
    fn in_view(&self, eye: &Eye, way: Vector) -> Option<(f64, f64)> {
        let sensor = way.turned(eye.axis.inverse());
        let side_m = f64::from(self.lobe.tangent_max()) * sensor.x;
        if sensor.x <= 0.0 || sensor.y.abs() > side_m {
            return None;
        }
        let range_m = way.norm();
        let lobe = self.lobe.at((sensor.x / range_m) as f32);
        Some((range_m, f64::from(lobe)))
    }
}
