//! Differences between a simulated world and the filter's model.

use amiro_ipf::model::{Photometry, SENSORS};
use amiro_ipf::random::{Generator, standard_normal_pair};

use super::{Drift, OdometryModel, Physics};

/// Separates the sensors' gains from all noise: "gains".
const GAIN_STREAM: u64 = 0x67_6169_6e73;
/// Least gain of a sensor, so that a wide spread leaves every sensor some signal.
const LEAST_GAIN: f64 = 0.1;

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
    /// Relative standard deviation of the sensors' gains: one draw per sensor and seed,
    /// constant over a drive. More: sensors that disagree about the same wall.
    pub gain_spread: f64,
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
            gain_spread: 0.0,
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
        within("gain-spread", self.gain_spread, 0.0, 0.5)?;
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
            within("odometry", errors.drift_deg_per_m, -45.0, 45.0)?;
            within("odometry", errors.slip_percent, 0.0, 50.0)?;
        }
        Ok(())
    }

    /// Gains of the sensors relative to the law's, for a seed: a normal distribution about
    /// 1, with nothing below 0.1.
    #[must_use]
    pub fn gains(&self, seed: u64) -> [f64; SENSORS] {
        let mut draws = Generator::seeded(seed ^ GAIN_STREAM);
        let mut gains = [1.0; SENSORS];
        for pair in gains.chunks_exact_mut(2) {
            let (first, second) = standard_normal_pair(&mut draws);
            for (gain, normal) in pair.iter_mut().zip([first, second]) {
                *gain = (1.0 + self.gain_spread * f64::from(normal)).max(LEAST_GAIN);
            }
        }
        gains
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
    fn gains_have_the_stated_spread_and_are_drawn_by_seed() {
        let options = Options {
            gain_spread: 0.12,
            ..Options::default()
        };
        let equal = Options::default().gains(7).map(f64::to_bits);
        assert_eq!(equal, [1.0_f64.to_bits(); SENSORS]);
        // 8000 gains of each range of seeds: 4 sigma / sqrt(n) of the mean are 0.0054,
        // 4 sqrt(2 / n) of the variance 6.3 %.
        for begin in [0, 1_000, 2_000] {
            let all = (begin..begin + 1_000).flat_map(|seed| options.gains(seed));
            let (sum, squares) = all.fold((0.0, 0.0), |(sum, squares), gain| {
                (sum + gain, squares + gain * gain)
            });
            let mean = sum / 8_000.0;
            let variance = squares / 8_000.0 - mean * mean;
            assert!((mean - 1.0).abs() < 0.0054, "from {begin}: {mean}");
            let ratio: f64 = variance / (0.12 * 0.12);
            assert!((ratio - 1.0).abs() < 0.063, "from {begin}: {variance}");
        }
        let wide = Options {
            gain_spread: 0.5,
            ..Options::default()
        };
        let least = (0..1_000).flat_map(|seed| wide.gains(seed));
        assert!(least.fold(f64::MAX, f64::min) >= LEAST_GAIN);
    }

    #[test]
    fn numbers_outside_their_range_are_refused_by_name() {
        let legal = Options::default();
        let errors = |scale_percent, heading_deg_per_sqrt_m| {
            OdometryModel::WheelErrors(WheelErrors {
                scale_percent,
                heading_deg_per_sqrt_m,
                ..WheelErrors::NONE
            })
        };
        let systematic = |drift_deg_per_m, slip_percent| {
            OdometryModel::WheelErrors(WheelErrors {
                drift_deg_per_m,
                slip_percent,
                ..WheelErrors::NONE
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
                "gain-spread",
                Options {
                    gain_spread: 0.6,
                    ..legal
                },
            ),
            (
                "odometry",
                Options {
                    odometry: systematic(-46.0, 0.0),
                    ..legal
                },
            ),
            (
                "odometry",
                Options {
                    odometry: systematic(0.0, f64::NAN),
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
