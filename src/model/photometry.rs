//! The photometric law of a reflective sensor: counts against range and bearing.
//!
//! Paper equation 5 with C(theta) = cos(xi theta), bearing theta off the sensor's
//! axis and signal d = s - beta:
//!
//! ```text
//! range      x(s, theta)^2 = C alpha / d + C delta
//! forward    s(x, theta)   = beta + alpha C / (x^2 - delta C)
//! error      sigma_x       = C (x^2 / C - delta)^2 / (2 alpha x) sigma_s
//! ```
//!
//! Everything separates, exactly: x = x_0 S and sigma_x = sigma_0 S with the range
//! on the axis x_0 = sqrt(alpha / d + delta), its error
//! sigma_0 = (alpha / d)^2 sigma_s / (2 alpha x_0), and the lobe S = sqrt(C). The
//! filter uses this form: one root and two divisions a sensor and step.
//!
//! **Two misprints are corrected here.** Section 2.2 prints
//! sigma_x = x sigma_s / (2 alpha), which is 1/m instead of m; it is
//! x^3 sigma_s / (2 alpha). Equation 5 prints sqrt(C) where differentiation gives C,
//! 1.9 times too much at 60 degrees. Tests below fail for both printed forms. The
//! delta term is the paper's "alpha extended by a linear function of the sensor
//! value": (alpha + delta d) C / d = alpha C / d + delta C; there is no second one.

use serde::{Deserialize, Serialize};

use super::{Gain, Reading, Sample};
use crate::math;

/// Parameters of the photometric law, for one kind of sensor and surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Photometry {
    /// Gain of sensor and surface, counts m^2 (alpha_i alpha_0). More: surfaces lie
    /// farther for the same counts. 0.94 for a matt white cylinder, 1.4 to 2.0 for a
    /// flat white wall, 0.01 for a black one. Legal from 0.001, where a surface at
    /// 15 mm returns no more than the noise of a sample.
    pub alpha_counts_m2: f32,
    /// Counts that remain when nothing is in range, on the offset-free scale (beta).
    pub beta_counts: f32,
    /// Linear dependence of the gain on the signal, m^2 (delta); negative where a
    /// near surface shows less of itself.
    pub delta_m2: f32,
    /// Shape of the lobe, dimensionless (xi): it closes at 90 degrees / xi.
    pub xi: f32,
    /// Standard deviation of a sample, counts (sigma_s), independent of the signal.
    pub sigma_counts: f32,
    /// Range limit on the axis, metres (x_max): a weaker signal is nothing in range.
    pub x_max_m: f32,
    /// Largest bearing off the axis that is used, radians (theta_max).
    pub theta_max_rad: f32,
}

impl Photometry {
    /// The AMiRo group's fit for the VCNL4020 (their public header, 2015-11-26).
    ///
    /// Fitted on an upright matt white cylinder of 67 mm diameter; the header has
    /// alpha 0.942693757414292, beta -16.252241893638708, delta 0,
    /// xi 1.236518540376969, sigma_s^2 20.886268537074187. x_max and theta_max are
    /// the paper's (section 4.3). sigma_0 at x_max is 19.4 mm, the 10 % of table 1.
    pub const VCNL4020: Self = Self {
        alpha_counts_m2: 0.942_693_76,
        beta_counts: -16.252_242,
        delta_m2: 0.0,
        xi: 1.236_518_5,
        sigma_counts: 4.570_149,
        x_max_m: 0.20,
        theta_max_rad: 60.0 * core::f32::consts::PI / 180.0,
    };

    /// The same law for a sensor of the given gain: alpha times the gain.
    ///
    /// A gain of 1 changes no bit.
    #[must_use]
    pub fn with_gain(&self, gain: Gain) -> Self {
        Self {
            alpha_counts_m2: self.alpha_counts_m2 * gain.ratio(),
            ..*self
        }
    }

    /// C(theta) = cos(xi theta), the relative signal off the axis; `None` where it is
    /// not positive or the bearing is not a number.
    #[must_use]
    pub fn directivity(&self, bearing_rad: f32) -> Option<f32> {
        let angle = self.xi * bearing_rad.abs();
        let cosine = math::sin_cos(angle).1;
        (angle < core::f32::consts::FRAC_PI_2 && cosine > 0.0).then_some(cosine)
    }

    /// Counts that a surface at the given range and bearing returns (forward model).
    ///
    /// `None` outside the lobe, for a range that is not positive, and where delta
    /// leaves no solution (x^2 <= delta C).
    #[must_use]
    pub fn counts(&self, range_m: f32, bearing_rad: f32) -> Option<f32> {
        let c = self.directivity(bearing_rad)?;
        let denominator = range_m * range_m - self.delta_m2 * c;
        (range_m > 0.0 && denominator > 0.0)
            .then(|| self.beta_counts + self.alpha_counts_m2 * c / denominator)
    }

    /// The range on the axis that given counts mean, with its error.
    ///
    /// `None` where the law has no solution: counts at or below beta, and with a
    /// negative delta counts beyond those at contact.
    #[must_use]
    pub fn range_estimate(&self, counts: f32) -> Option<RangeEstimate> {
        let signal = counts - self.beta_counts;
        if signal <= 0.0 || signal.is_nan() {
            return None;
        }
        let spread = self.alpha_counts_m2 / signal;
        let squared = spread + self.delta_m2;
        if !(squared > 0.0 && squared.is_finite()) {
            return None;
        }
        let range_m = math::sqrt(squared);
        Some(RangeEstimate {
            range_m,
            sigma_m: spread * spread * self.sigma_counts / (2.0 * self.alpha_counts_m2 * range_m),
        })
    }

    /// Range at which a surface under the given bearing returns the given counts.
    ///
    /// `None` as for [`directivity`](Self::directivity) and [`range_estimate`](Self::range_estimate).
    #[must_use]
    pub fn range_m(&self, counts: f32, bearing_rad: f32) -> Option<f32> {
        let lobe = math::sqrt(self.directivity(bearing_rad)?);
        Some(self.range_estimate(counts)?.range_m * lobe)
    }

    /// Standard deviation of [`range_m`](Self::range_m) for the sensor's own noise.
    #[must_use]
    pub fn range_sigma_m(&self, counts: f32, bearing_rad: f32) -> Option<f32> {
        let lobe = math::sqrt(self.directivity(bearing_rad)?);
        Some(self.range_estimate(counts)?.sigma_m * lobe)
    }

    /// Counts below which nothing is in range: those of a surface at x_max on the axis.
    ///
    /// With a positive delta beyond x_max^2 every range lies inside x_max; the
    /// threshold is then beta.
    #[must_use]
    pub fn threshold_counts(&self) -> f32 {
        self.counts(self.x_max_m, 0.0).unwrap_or(self.beta_counts)
    }

    /// The reading of a sample. "Nothing in range" is decided before any division.
    #[must_use]
    pub fn read(&self, sample: Sample) -> Reading {
        let counts = match sample {
            Sample::Counts(counts) => counts as f32,
            Sample::Saturated => return Reading::TooClose,
            Sample::Missing => return Reading::Faulty,
        };
        let threshold = self.threshold_counts();
        if counts < threshold {
            return self
                .range_estimate(threshold)
                .map_or(Reading::Faulty, Reading::NothingInRange);
        }
        self.range_estimate(counts)
            .map_or(Reading::TooClose, Reading::Range)
    }
}

/// A range on the sensor's axis; off the axis both values shrink with the lobe S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeEstimate {
    /// Range on the axis, metres (x_0).
    pub range_m: f32,
    /// Its standard deviation from the sensor's noise, metres (sigma_0).
    pub sigma_m: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: Photometry = Photometry::VCNL4020;

    fn finite_difference(sensor: &Photometry, range: f64, bearing: f64) -> f64 {
        // |dx/ds| in double precision from the law itself.
        let c = (f64::from(sensor.xi) * bearing).cos();
        let (alpha, delta) = (
            f64::from(sensor.alpha_counts_m2),
            f64::from(sensor.delta_m2),
        );
        let x = |signal: f64| (c * alpha / signal + c * delta).sqrt();
        let signal = alpha * c / (range * range - delta * c);
        let h = 1e-4 * signal;
        ((x(signal + h) - x(signal - h)) / (2.0 * h)).abs()
    }

    #[test]
    fn published_table_is_met_row_by_row() {
        // Counts and sigma on the axis, from the group's constants.
        let rows = [
            (0.02, 2340.0, 0.02e-3),
            (0.05, 361.0, 0.30e-3),
            (0.08, 131.0, 1.2e-3),
            (0.10, 78.0, 2.4e-3),
            (0.12, 49.0, 4.2e-3),
            (0.15, 25.6, 8.2e-3),
            (0.20, 7.3, 19.4e-3),
        ];
        for (range, counts, sigma) in rows {
            let s = SENSOR.counts(range, 0.0).unwrap();
            assert!((s - counts).abs() < 0.6, "{range} m: {s} counts");
            let error = SENSOR.range_sigma_m(s, 0.0).unwrap();
            assert!((error - sigma).abs() < 0.06e-3, "{range} m: {error} m");
        }
        let nothing = SENSOR.range_m(0.0, 0.0).unwrap();
        assert!(
            (nothing - 0.241).abs() < 5e-4,
            "zero counts mean {nothing} m"
        );
    }

    #[test]
    fn precision_at_the_range_limit_is_ten_percent() {
        let share = SENSOR
            .range_sigma_m(SENSOR.threshold_counts(), 0.0)
            .unwrap()
            / SENSOR.x_max_m;
        assert!((0.09..=0.11).contains(&share), "{share}");
    }

    #[test]
    fn forward_and_inverse_return() {
        for delta in [-5e-4, 0.0, 5e-4] {
            let sensor = Photometry {
                delta_m2: delta,
                ..SENSOR
            };
            for range in [0.05_f32, 0.1, 0.15, 0.2] {
                for degrees in [0.0_f32, 20.0, 40.0, 60.0] {
                    let bearing = degrees.to_radians();
                    let s = sensor.counts(range, bearing).unwrap();
                    let back = sensor.range_m(s, bearing).unwrap();
                    assert!(
                        (back - range).abs() < 1e-5,
                        "{range} m, {degrees} deg, {delta}"
                    );
                }
            }
        }
    }

    #[test]
    fn error_is_the_derivative_and_the_printed_forms_are_not() {
        for delta in [-5e-4_f32, 0.0, 5e-4] {
            let sensor = Photometry {
                delta_m2: delta,
                ..SENSOR
            };
            for range in [0.05_f32, 0.1] {
                for degrees in [0.0_f32, 20.0, 40.0, 60.0] {
                    let bearing = degrees.to_radians();
                    let case = format!("{range} m, {degrees} deg, delta {delta}");
                    let exact = finite_difference(&sensor, f64::from(range), f64::from(bearing))
                        * f64::from(sensor.sigma_counts);
                    let s = sensor.counts(range, bearing).unwrap();
                    let sigma = f64::from(sensor.range_sigma_m(s, bearing).unwrap());
                    assert!(
                        (sigma / exact - 1.0).abs() < 2e-4,
                        "{case}: {sigma} / {exact}"
                    );

                    // Equation 5 as printed: a root where the cosine belongs.
                    let c = f64::from(sensor.directivity(bearing).unwrap());
                    let printed = sigma / c.sqrt();
                    if degrees > 0.0 {
                        assert!((printed / exact - 1.0).abs() > 0.04, "{case}");
                    }
                    // Section 2.2 as printed: x instead of x^3.
                    let printed = f64::from(range * sensor.sigma_counts)
                        / f64::from(2.0 * sensor.alpha_counts_m2);
                    assert!((printed / exact - 1.0).abs() > 0.5, "{case}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_divided_by_nothing() {
        assert_eq!(SENSOR.range_estimate(SENSOR.beta_counts), None);
        assert_eq!(SENSOR.range_estimate(-1e9), None);
        assert_eq!(SENSOR.range_estimate(f32::NAN), None);
        assert_eq!(SENSOR.counts(0.0, 0.0), None);
        assert_eq!(SENSOR.counts(-0.1, 0.0), None);
        assert_eq!(SENSOR.directivity(1.28), None);
        assert_eq!(SENSOR.directivity(f32::NAN), None);
        // At contact a negative delta ends the law: alpha / 5e-4 counts.
        let sensor = Photometry {
            delta_m2: -5e-4,
            ..SENSOR
        };
        assert_eq!(sensor.range_estimate(sensor.beta_counts + 1886.0), None);
        assert_eq!(sensor.read(Sample::Counts(60_000)), Reading::TooClose);
    }

    #[test]
    fn the_darkest_and_the_brightest_legal_surface_have_finite_ranges() {
        for alpha_counts_m2 in [0.001, 0.0099, 100.0] {
            let sensor = Photometry {
                alpha_counts_m2,
                ..SENSOR
            };
            for range in [0.01_f32, 0.05, 0.1, 0.19] {
                let counts = sensor.counts(range, 0.0).unwrap();
                let echo = sensor.range_estimate(counts).unwrap();
                // The darkest wall at 0.19 m is 0.03 counts above beta, which is -16.25:
                // a bit of single precision is 2 in 10^6 there, 6 in 10^5 of the signal.
                let error = (echo.range_m / range - 1.0).abs();
                assert!(error < 1e-4, "{alpha_counts_m2}, {range} m: {echo:?}");
            }
            for counts in -70_000..=70_000 {
                if let Reading::Range(echo) = sensor.read(Sample::Counts(counts)) {
                    assert!(echo.range_m.is_finite() && echo.range_m > 0.0, "{counts}");
                    assert!(echo.sigma_m.is_finite() && echo.sigma_m > 0.0, "{counts}");
                }
            }
        }
    }

    #[test]
    fn every_code_has_a_finite_meaning_and_ranges_fall_with_counts() {
        let mut last = f32::INFINITY;
        for counts in -70_000..=70_000 {
            match SENSOR.read(Sample::Counts(counts)) {
                Reading::NothingInRange(limit) => {
                    assert!((limit.range_m - 0.2).abs() < 1e-6, "{counts}");
                    assert!((counts as f32) < SENSOR.threshold_counts(), "{counts}");
                }
                Reading::Range(echo) => {
                    assert!(echo.range_m.is_finite() && echo.range_m > 0.0, "{counts}");
                    assert!(echo.sigma_m.is_finite() && echo.sigma_m > 0.0, "{counts}");
                    assert!(echo.range_m < last, "{counts}");
                    last = echo.range_m;
                }
                other => panic!("{counts} counts read as {other:?}"),
            }
        }
        assert_eq!(SENSOR.read(Sample::Saturated), Reading::TooClose);
        assert_eq!(SENSOR.read(Sample::Missing), Reading::Faulty);
    }
}
