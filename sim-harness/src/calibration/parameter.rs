//! The parameters of the photometric law that a table can determine.

use amiro_ipf::model::Photometry;
use serde::Serialize;

/// A parameter of the photometric law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Parameter {
    /// Gain of sensor and surface, counts m^2 (alpha).
    Alpha,
    /// Counts that remain with nothing in range (beta).
    Beta,
    /// Shape of the lobe (xi).
    Xi,
    /// Linear dependence of the gain on the signal, m^2 (delta).
    Delta,
    /// Standard deviation of a sample, counts (sigma_s).
    Sigma,
}

impl Parameter {
    /// All, in the order of reports.
    pub const ALL: [Self; 5] = [Self::Alpha, Self::Beta, Self::Xi, Self::Delta, Self::Sigma];

    /// Those of the law's mean, in the order in which data determine them.
    pub const OF_MEAN: [Self; 4] = [Self::Alpha, Self::Beta, Self::Xi, Self::Delta];

    /// The name on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Alpha => "alpha",
            Self::Beta => "beta",
            Self::Xi => "xi",
            Self::Delta => "delta",
            Self::Sigma => "sigma",
        }
    }

    /// The unit; empty for a number.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Alpha => "counts m^2",
            Self::Beta | Self::Sigma => "counts",
            Self::Xi => "",
            Self::Delta => "m^2",
        }
    }

    /// Least and largest value that a configuration takes.
    #[must_use]
    pub const fn range(self) -> (f64, f64) {
        match self {
            Self::Alpha => (0.001, 100.0),
            Self::Beta => (-5000.0, 5000.0),
            Self::Xi => (0.5, 1.45),
            Self::Delta => (-0.01, 0.01),
            Self::Sigma => (1e-6, 1000.0),
        }
    }

    /// The value of this parameter in a law.
    #[must_use]
    pub fn of(self, photometry: &Photometry) -> f64 {
        f64::from(match self {
            Self::Alpha => photometry.alpha_counts_m2,
            Self::Beta => photometry.beta_counts,
            Self::Xi => photometry.xi,
            Self::Delta => photometry.delta_m2,
            Self::Sigma => photometry.sigma_counts,
        })
    }
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::node::Config;

    #[test]
    fn ranges_are_those_of_a_configuration() {
        for parameter in Parameter::ALL {
            let (low, high) = parameter.range();
            for (value, is_legal) in [(low, true), (high, true), (high * 1.01, false)] {
                let mut config = Config::default();
                let photometry = &mut config.photometry;
                // Rounding to single precision must not leave the range.
                let value = value as f32;
                match parameter {
                    Parameter::Alpha => photometry.alpha_counts_m2 = value,
                    Parameter::Beta => photometry.beta_counts = value,
                    Parameter::Xi => photometry.xi = value,
                    Parameter::Delta => photometry.delta_m2 = value,
                    Parameter::Sigma => photometry.sigma_counts = value,
                }
                let is_valid = config.validate().is_ok();
                assert_eq!(is_valid, is_legal, "{parameter} = {value}");
            }
        }
    }
}
