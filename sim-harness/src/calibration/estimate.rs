//! The result of a fit: estimates, residuals, the law.

use amiro_ipf::model::Photometry;
use serde::Serialize;

use super::{CalibrationPoint, LawKind, Parameter};

/// Standard deviation of rounding to whole counts: 1 / sqrt(12).
pub(super) const ROUNDING_COUNTS: f64 = 0.288_675;

/// The origin of a parameter's value.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// Fitted to the table.
    Fitted,
    /// Given beforehand.
    Fixed,
    /// Kept at its default for a reason: the table does not determine it.
    Held(String),
}

/// A parameter after a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Its value.
    pub value: f64,
    /// Its standard error, if it was fitted.
    pub standard_error: Option<f64>,
    /// Its origin.
    pub origin: Origin,
}

/// A law fitted to a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Which law.
    pub law: LawKind,
    pub(super) estimates: Vec<Estimate>,
    pub(super) rows: Vec<(CalibrationPoint, f64)>,
    /// Root of the weighted mean of squared residuals, counts.
    pub rms_counts: f64,
}

impl Fit {
    /// The parameters: alpha, beta, xi, delta, sigma.
    #[must_use]
    pub fn estimates(&self) -> &[Estimate] {
        &self.estimates
    }

    /// The estimate of one parameter; NaN for none, which cannot be.
    #[must_use]
    pub fn value(&self, parameter: Parameter) -> f64 {
        self.estimate(parameter)
            .map_or(f64::NAN, |estimate| estimate.value)
    }

    /// One parameter.
    #[must_use]
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        self.estimates
            .iter()
            .find(|estimate| estimate.parameter == parameter)
    }

    /// The measurements, each with the counts that the fitted law expects.
    #[must_use]
    pub fn rows(&self) -> &[(CalibrationPoint, f64)] {
        &self.rows
    }

    /// The fitted law; range limit and largest bearing are the default's.
    ///
    /// A sample is whole counts: sigma_s is at least what rounding makes, 0.29.
    #[must_use]
    pub fn photometry(&self) -> Photometry {
        Photometry {
            alpha_counts_m2: self.value(Parameter::Alpha) as f32,
            beta_counts: self.value(Parameter::Beta) as f32,
            delta_m2: self.value(Parameter::Delta) as f32,
            xi: self.value(Parameter::Xi) as f32,
            sigma_counts: self.value(Parameter::Sigma).max(ROUNDING_COUNTS) as f32,
            ..Photometry::VCNL4020
        }
    }
}
