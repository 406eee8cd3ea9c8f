//! A fit as text, as a Rust value, as JSON and as a table.

use std::fmt::{self, Write};

use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use super::{Estimate, Fit, Origin, Parameter};

/// Half the width of the residuals' plot, characters.
const HALF_PLOT: i32 = 20;

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, unit) = (self.value, self.parameter.unit());
        let error = self.standard_error.unwrap_or(0.0);
        let number = |value: f64| match self.parameter {
            Parameter::Delta => format!("{value:.3e}"),
            _ => format!("{value:.4}"),
        };
        write!(f, "{:<6}{:>12}", self.parameter, number(value))?;
        match &self.origin {
            Origin::Fitted => write!(f, " +- {:<10} {unit}", number(error))?,
            Origin::Fixed => write!(f, "    {:<10} {unit}", "fixed")?,
            Origin::Held(why) => write!(f, "    {:<10} {unit} ({why})", "held")?,
        }
        Ok(())
    }
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {} measurements, residual RMS {:.2} counts",
            self.law.name(),
            self.rows.len(),
            self.rms_counts
        )?;
        for estimate in self.estimates() {
            writeln!(f, "{}", estimate.to_string().trim_end())?;
        }
        Ok(())
    }
}

impl Serialize for Fit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Fit", 5)?;
        fields.serialize_field("law", &self.law)?;
        fields.serialize_field("measurements", &self.rows.len())?;
        fields.serialize_field("rms_counts", &self.rms_counts)?;
        fields.serialize_field("estimates", self.estimates())?;
        fields.serialize_field("photometry", &self.photometry())?;
        fields.end()
    }
}

impl Fit {
    /// The law as a Rust value, ready to paste.
    #[must_use]
    pub fn rust(&self) -> String {
        let law = self.photometry();
        format!(
            "Photometry {{\n    alpha_counts_m2: {:?},\n    beta_counts: {:?},\n    \
             delta_m2: {:?},\n    xi: {:?},\n    sigma_counts: {:?},\n    \
             ..Photometry::VCNL4020\n}}",
            law.alpha_counts_m2, law.beta_counts, law.delta_m2, law.xi, law.sigma_counts
        )
    }

    /// The table with the fitted counts and the residuals, values between commas.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = "range_m,angle_deg,counts,weight,fit_counts,residual_counts\n".to_owned();
        for (row, fitted) in self.rows() {
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{:.6},{:.4},{},{},{fitted:.3},{:.3}",
                row.range_m,
                row.angle_rad.to_degrees(),
                row.counts,
                row.weight,
                row.counts - fitted,
            );
        }
        text
    }

    /// The table of fit and residuals, with a plot: a star right of the bar is more
    /// than the law expects.
    #[must_use]
    pub fn residuals(&self) -> String {
        let largest = self
            .rows()
            .iter()
            .map(|(row, fitted)| (row.counts - fitted).abs())
            .fold(0.0, f64::max);
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let mut text = format!(
            "range mm  angle deg    counts       fit  residual  (plot: +-{largest:.1} counts)\n"
        );
        for (row, fitted) in self.rows() {
            let residual = row.counts - fitted;
            let place = (residual / scale * f64::from(HALF_PLOT)).round() as i32;
            let plot: String = (-HALF_PLOT..=HALF_PLOT)
                .map(|column| match column {
                    _ if column == place => '*',
                    0 => '|',
                    _ => ' ',
                })
                .collect();
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{:8.1}  {:9.1}  {:8.1}  {fitted:8.1}  {residual:8.1}  {}",
                1000.0 * row.range_m,
                row.angle_rad.to_degrees(),
                row.counts,
                plot.trim_end(),
            );
        }
        text
    }
}
