//! Differences between a simulated world and the filter's model.

use amiro_ipf::model::Photometry;

use super::{Drift, OdometryModel, Physics};

/// Differences of a drive from the model; by default none but sensor noise.
///
/// Written as words, such as `physics=patch noise=2 drift=0..10`: only those that differ
/// from the default, in the order of the fields. The words are read back bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The rule that makes a signal of the returns.
    pub physics: Physics,
    /// Sensor noise, times the model's sigma_s. More: less precise readings.
    pub noise_factor: f64,
    /// Drift of the sensors' offsets from the stored ones.
    pub drift: Drift,
    /// Reflectivity of all shapes, times the scenario's. More: shapes appear nearer.
    pub reflectivity_factor: f64,
    /// Probability that a sample is missing, independently for each sample.
    pub dropout: f64,
    /// Shape of the world's lobe (xi); `None` is the model's.
    pub xi: Option<f64>,
    /// The world's dependence of the gain on the signal, m^2 (delta); `None` is the
    /// model's.
    pub delta_m2: Option<f64>,
    /// The odometry that reaches the robot.
    pub odometry: OdometryModel,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            physics: Physics::Matched,
            noise_factor: 1.0,
            drift: Drift::NONE,
            reflectivity_factor: 1.0,
            dropout: 0.0,
            xi: None,
            delta_m2: None,
            odometry: OdometryModel::Truth,
        }
    }
}

/// The reason for which options are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// A number is outside its range.
    #[error("{key}: {value} is outside {low} to {high}")]
    Range {
        /// The option.
        key: &'static str,
        /// What it was set to.
        value: f64,
        /// Smallest value that is allowed.
        low: f64,
        /// Largest value that is allowed.
        high: f64,
    },
    /// A value that the option does not have.
    #[error("{key}: `{text}` is not {what}")]
    Value {
        /// The option.
        key: &'static str,
        /// What it was set to.
        text: String,
        /// What it may be.
        what: &'static str,
    },
    /// There is no such option.
    #[error("`{0}` is no option of a simulation")]
    Unknown(String),
}

impl OptionsError {
    pub(super) fn value(key: &'static str, text: &str, what: &'static str) -> Self {
        Self::Value {
            key,
            text: text.to_owned(),
            what,
        }
    }
}

impl Options {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`OptionsError::Range`] for the first that is outside, NaN included.
    pub fn validate(&self) -> Result<(), OptionsError> {
        within("noise", self.noise_factor, 0.0, 100.0)?;
        within("drift", self.drift.from_counts, -10_000.0, 10_000.0)?;
        within("drift", self.drift.to_counts, -10_000.0, 10_000.0)?;
        within("reflectivity", self.reflectivity_factor, 0.001, 100.0)?;
        within("dropout", self.dropout, 0.0, 1.0)?;
        if let Some(xi) = self.xi {
            within("xi", xi, 0.5, 1.45)?;
        }
        if let Some(delta_m2) = self.delta_m2 {
            // The wall at 100 mm that patches are scaled by needs delta below 0.01.
            within("delta", delta_m2, -0.005, 0.005)?;
        }
        if let OdometryModel::WheelErrors(errors) = self.odometry {
            within("odometry", errors.scale_percent, 0.0, 50.0)?;
            within("odometry", errors.heading_deg_per_sqrt_m, 0.0, 90.0)?;
        }
        Ok(())
    }

    /// The world's law, where the filter's model has the given one.
    #[must_use]
    pub fn photometry(&self, model: &Photometry) -> Photometry {
        Photometry {
            alpha_counts_m2: model.alpha_counts_m2 * self.reflectivity_factor as f32,
            sigma_counts: model.sigma_counts * self.noise_factor as f32,
            xi: self.xi.map_or(model.xi, |xi| xi as f32),
            delta_m2: self.delta_m2.map_or(model.delta_m2, |delta| delta as f32),
            ..*model
        }
    }
}

fn within(key: &'static str, value: f64, low: f64, high: f64) -> Result<(), OptionsError> {
    // NaN lies in no range.
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(OptionsError::Range {
        key,
        value,
        low,
        high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::WheelErrors;

    #[test]
    fn by_default_the_world_follows_the_model() {
        let options = Options::default();
        assert_eq!(options.validate(), Ok(()));
        let world = options.photometry(&Photometry::VCNL4020);
        assert_eq!(world, Photometry::VCNL4020);
    }

    #[test]
    fn numbers_outside_their_range_are_refused_by_name() {
        let legal = Options::default();
        let errors = |scale_percent, heading_deg_per_sqrt_m| {
            OdometryModel::WheelErrors(WheelErrors {
                scale_percent,
                heading_deg_per_sqrt_m,
            })
        };
        let cases = [
            (
                "noise",
                Options {
                    noise_factor: f64::NAN,
                    ..legal
                },
            ),
            (
                "noise",
                Options {
                    noise_factor: -1.0,
                    ..legal
                },
            ),
            (
                "drift",
                Options {
                    drift: Drift::constant(1e5),
                    ..legal
                },
            ),
            (
                "reflectivity",
                Options {
                    reflectivity_factor: 0.0,
                    ..legal
                },
            ),
            (
                "dropout",
                Options {
                    dropout: 1.1,
                    ..legal
                },
            ),
            (
                "xi",
                Options {
                    xi: Some(1.6),
                    ..legal
                },
            ),
            (
                "delta",
                Options {
                    delta_m2: Some(0.01),
                    ..legal
                },
            ),
            (
                "odometry",
                Options {
                    odometry: errors(51.0, 2.0),
                    ..legal
                },
            ),
            (
                "odometry",
                Options {
                    odometry: errors(1.0, f64::INFINITY),
                    ..legal
                },
            ),
        ];
        for (key, options) in cases {
            let error = options.validate().unwrap_err().to_string();
            assert!(error.starts_with(key), "{options:?}: {error}");
        }
    }
}
