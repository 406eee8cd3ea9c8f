//! The laws of a sensor as a least squares problem in some of their parameters.

use amiro_ipf::model::Photometry;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::{CalibrationPoint, Parameter};
use crate::sensors::WallLaw;

/// Least denominator of the law, share of x^2. A trial beyond the law's end then has a
/// large finite residual and is refused.
const LEAST_DENOMINATOR: f64 = 1e-6;

/// Damping of the first step, share of the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping at which a step that does not lead downhill ends the search: such a step is
/// 1e-12 of the undamped one.
const LAST_DAMPING: f64 = 1e12;
/// Greatest number of steps; fits of measured tables take about 40, most of them at the
/// end, where they lead nowhere.
const MOST_STEPS: u32 = 1_000;

/// Step of the difference by which the wall law is differentiated by xi. The error is below
/// 1e-5 of the derivative, near the poles of the closed form at xi = 1 too.
const XI_STEP: f64 = 1e-4;

/// What kind of surface a law is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LawKind {
    /// A surface that is small in the lobe (paper, equation 5): C = cos(xi theta), 0
    /// outside the lobe.
    Point,
    /// An endless wall under the law of [walls](crate::sensors::WallLaw): C = G(theta), the
    /// return of a wall whose normal has the bearing theta, relative to that of a wall
    /// square to the axis. The lobe ends at
    /// [`Photometry::VCNL4020`](amiro_ipf::model::Photometry::VCNL4020)'s largest bearing.
    Wall,
}

impl LawKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Point, Self::Wall];

    /// The name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point law",
            Self::Wall => "law of extended surfaces",
        }
    }

    /// Return at a bearing relative to that on the axis (C).
    fn directivity(self, xi: f64, angle_rad: f64) -> f64 {
        let angle = (xi * angle_rad).abs();
        match self {
            Self::Point if angle < core::f64::consts::FRAC_PI_2 => angle.cos(),
            Self::Point => 0.0,
            Self::Wall => {
                let theta_max_rad = f64::from(Photometry::VCNL4020.theta_max_rad);
                WallLaw::of_lobe(1.0, xi, theta_max_rad).endless_wall_counts(1.0, angle_rad)
            }
        }
    }

    /// Derivative of C by xi.
    fn directivity_by_xi(self, xi: f64, angle_rad: f64) -> f64 {
        match self {
            Self::Point => -angle_rad * (xi * angle_rad).sin(),
            Self::Wall => {
                let moved = |step: f64| self.directivity(xi + step, angle_rad);
                (moved(XI_STEP) - moved(-XI_STEP)) / (2.0 * XI_STEP)
            }
        }
    }
}

/// s = beta + alpha C / (x^2 - delta C) with the C of a [`LawKind`].
///
/// Both kinds have the same parameters. The delta of the wall law is a description of
/// the near field: [`WallLaw`] has none.
///
/// Residuals are weighted by the root of a row's weight. In double precision: the
/// core's single precision is for robots, not for derivatives.
#[derive(Clone, Debug)]
pub struct Law<'t> {
    kind: LawKind,
    rows: &'t [CalibrationPoint],
    free: Vec<Parameter>,
    /// By [`Parameter::OF_MEAN`].
    values: [f64; Parameter::OF_MEAN.len()],
}

impl<'t> Law<'t> {
    /// The law over the given rows with all parameters at given values, some of them free.
    #[must_use]
    pub fn new(
        kind: LawKind,
        rows: &'t [CalibrationPoint],
        free: Vec<Parameter>,
        values: [f64; Parameter::OF_MEAN.len()],
    ) -> Self {
        Self {
            kind,
            rows,
            free,
            values,
        }
    }

    /// What kind of surface it is for.
    #[must_use]
    pub fn kind(&self) -> LawKind {
        self.kind
    }

    /// The values of alpha, beta, xi and delta.
    #[must_use]
    pub fn values(&self) -> [f64; Parameter::OF_MEAN.len()] {
        self.values
    }

    /// Counts that the law expects of a measurement.
    #[must_use]
    pub fn counts(&self, row: &CalibrationPoint) -> f64 {
        let [alpha, beta, ..] = self.values;
        beta + alpha * self.shape(row)
    }

    /// Counts above beta for a gain of 1, 1/m^2.
    pub(super) fn shape(&self, row: &CalibrationPoint) -> f64 {
        let (c, denominator) = self.lobe(row);
        c / denominator
    }

    /// Whether the law has an end before some row: x^2 <= delta C.
    pub(super) fn ends_early(&self) -> bool {
        let [.., delta] = self.values;
        self.rows.iter().any(|row| {
            let c = self.lobe(row).0;
            row.range_m * row.range_m * 0.5 <= delta * c
        })
    }

    fn lobe(&self, row: &CalibrationPoint) -> (f64, f64) {
        let [.., xi, delta] = self.values;
        let c = self.kind.directivity(xi, row.angle_rad);
        let square = row.range_m * row.range_m;
        let denominator = (square - delta * c).max(LEAST_DENOMINATOR * square);
        (c, denominator)
    }

    /// Derivative of a row's expected counts by a parameter.
    fn slope(&self, row: &CalibrationPoint, parameter: Parameter) -> f64 {
        let [alpha, _, xi, _] = self.values;
        let (c, denominator) = self.lobe(row);
        match parameter {
            Parameter::Alpha => c / denominator,
            Parameter::Beta => 1.0,
            Parameter::Xi if c > 0.0 => {
                let by_xi = self.kind.directivity_by_xi(xi, row.angle_rad);
                let square = row.range_m * row.range_m;
                by_xi * alpha * square / (denominator * denominator)
            }
            Parameter::Delta => alpha * c * c / (denominator * denominator),
            Parameter::Xi | Parameter::Sigma => 0.0,
        }
    }

    /// Weighted residuals: expected less measured, times the root of the weight.
    #[must_use]
    pub fn weighted_residuals(&self) -> Vec<f64> {
        self.rows
            .iter()
            .map(|row| row.weight.sqrt() * (self.counts(row) - row.counts))
            .collect()
    }

    /// Weighted derivatives, a column a free parameter.
    pub(super) fn weighted_slopes(&self) -> DMatrix<f64> {
        let columns = self.free.iter().flat_map(|parameter| {
            self.rows
                .iter()
                .map(|row| row.weight.sqrt() * self.slope(row, *parameter))
        });
        DMatrix::from_iterator(self.rows.len(), self.free.len(), columns)
    }

    /// Sum of the squared weighted residuals.
    pub(super) fn squares(&self) -> f64 {
        self.weighted_residuals().iter().map(|r| r * r).sum()
    }

    /// The law at the least sum of squares that is downhill from here, by
    /// Levenberg-Marquardt: normal equations with a damped diagonal.
    ///
    /// It ends where not even the shortest step leads downhill, at the rounding of the
    /// sum of squares. `None` if the search takes too many steps or the equations have no
    /// solution.
    pub(super) fn minimised(mut self) -> Option<Self> {
        let (mut damping, mut squares) = (FIRST_DAMPING, self.squares());
        for _ in 0..MOST_STEPS {
            let slopes = self.weighted_slopes();
            let mut normal = slopes.tr_mul(&slopes);
            normal.set_diagonal(&(normal.diagonal() * (1.0 + damping)));
            let gradient = slopes.tr_mul(&DVector::from_vec(self.weighted_residuals()));
            let step = normal.cholesky()?.solve(&gradient);
            let mut trial = self.clone();
            for (parameter, step) in self.free.iter().zip(step.iter()) {
                if let Some(value) = trial.values.get_mut(*parameter as usize) {
                    *value -= step;
                }
            }
            let trial_squares = trial.squares();
            if trial_squares < squares {
                (self, squares) = (trial, trial_squares);
                damping *= 0.1;
            } else if damping > LAST_DAMPING {
                return Some(self);
            } else {
                damping *= 10.0;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<CalibrationPoint> {
        let ranges = [0.05, 0.08, 0.12, 0.2];
        let angles = [-0.9, 0.0, 0.5_f64];
        ranges
            .into_iter()
            .flat_map(|range_m| {
                angles.map(|angle_rad| CalibrationPoint {
                    range_m,
                    angle_rad,
                    counts: 0.0,
                    weight: 2.0,
                })
            })
            .collect()
    }

    #[test]
    fn counts_are_those_of_the_core() {
        let core = Photometry {
            delta_m2: -2e-4,
            ..Photometry::VCNL4020
        };
        let rows = rows();
        let values = Parameter::OF_MEAN.map(|parameter| parameter.of(&core));
        let law = Law::new(LawKind::Point, &rows, Vec::new(), values);
        for row in &rows {
            let expected = core.counts(row.range_m as f32, row.angle_rad as f32);
            let error = law.counts(row) - f64::from(expected.unwrap());
            // Single precision of some 400 counts, and of the core's cosine.
            assert!(error.abs() < 2e-3, "{row:?}: {error}");
        }
    }

    #[test]
    fn slopes_are_the_finite_differences_of_the_residuals() {
        let rows = rows();
        for (kind, xi) in [
            (LawKind::Point, 1.2),
            (LawKind::Wall, 1.2),
            (LawKind::Wall, 1.0),
        ] {
            let values = [1.4, -16.0, xi, -3e-4];
            let law = Law::new(kind, &rows, Parameter::OF_MEAN.to_vec(), values);
            let slopes = law.weighted_slopes();
            for (column, step) in [1e-5, 1e-3, 1e-5, 1e-9].into_iter().enumerate() {
                let moved = |by: f64| {
                    let mut moved = law.clone();
                    moved.values[column] += by;
                    moved.weighted_residuals()
                };
                for (row, (up, down)) in moved(step).into_iter().zip(moved(-step)).enumerate() {
                    let expected = (up - down) / (2.0 * step);
                    let error = (slopes[(row, column)] - expected).abs();
                    let bound = 1e-5 * expected.abs() + 1e-5;
                    assert!(error < bound, "{kind:?} {xi}: {row}, {column}: {error}");
                }
            }
        }
    }

    /// From a poor xi the search may end in a lobe that excludes all rows off the axis;
    /// therefore a grid comes before the search.
    #[test]
    fn a_start_with_the_wrong_gain_and_offset_converges() {
        let mut rows = rows();
        let truth = [1.4, -16.0, 1.2, -3e-4];
        let law = Law::new(LawKind::Point, &rows, Vec::new(), truth);
        let counts: Vec<_> = rows.iter().map(|row| law.counts(row)).collect();
        for (row, counts) in rows.iter_mut().zip(counts) {
            row.counts = counts;
        }
        for start in [[0.5, 100.0, 1.1, 0.0], [20.0, -900.0, 1.3, -1e-4]] {
            let law = Law::new(LawKind::Point, &rows, Parameter::OF_MEAN.to_vec(), start);
            let found = law.minimised().unwrap();
            for (value, truth) in found.values.into_iter().zip(truth) {
                let error = (value - truth).abs();
                assert!(error < 1e-5 * truth.abs(), "{start:?}: {found:?}");
            }
        }
    }
}
