//! Which of the two laws explains a table better.

use std::fmt;

use super::estimate::ROUNDING_COUNTS;
use super::{Estimate, Fit, FitError, Fixed, LawKind, Origin, Parameter, Table, fit_law};

/// Least difference of Akaike's criterion that decides. A model that is worse by 10 has
/// essentially no support (Burnham and Anderson 2002, section 2.6).
const DECISIVE_AIC: f64 = 10.0;

/// Least ratio of the residuals' RMS that decides. The rows of a table share the errors of
/// one set-up, so that a smaller ratio can come from those in a table of any length.
const DECISIVE_RATIO: f64 = 1.05;

/// Both laws fitted to the same table by the same procedure.
#[derive(Clone, Debug, PartialEq)]
pub struct LawComparison {
    /// The law of small surfaces, or the reason for which it does not fit.
    pub point: Result<Fit, FitError>,
    /// The law of extended surfaces, or the reason for which it does not fit.
    pub wall: Result<Fit, FitError>,
    /// sigma_s, if it was known beforehand.
    sigma_counts: Option<f64>,
}

/// Which law explains a table better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawVerdict {
    /// One of the two.
    Better(LawKind),
    /// The table does not decide.
    Undecided,
}

impl LawComparison {
    /// Fits both laws to a table.
    ///
    /// If xi or delta of one law comes out of its range, it is held at the end of that, so
    /// that there is a residual to compare.
    ///
    /// # Errors
    /// The error of the point law, if neither can be fitted with legal values.
    pub fn of(table: &Table, fixed: &Fixed) -> Result<Self, FitError> {
        let fits = LawKind::ALL.map(|kind| fit_law(kind, table, fixed));
        if let [Err(error), Err(_)] = &fits {
            return Err(error.clone());
        }
        let [point, wall] = fits;
        let point = point.or_else(|error| held_at_bound(LawKind::Point, error, table, fixed));
        let wall = wall.or_else(|error| held_at_bound(LawKind::Wall, error, table, fixed));
        Ok(Self {
            point,
            wall,
            sigma_counts: fixed.value(Parameter::Sigma),
        })
    }

    /// Akaike's criterion of the point law less that of the law of extended surfaces:
    /// positive if the latter is better. `None` if one of them does not fit.
    ///
    /// AIC = N ln(RMS^2) + 2 k for N rows and k fitted parameters, with an RMS of at least
    /// that of rounding to whole counts; with a known sigma_s it is the sum of the squared
    /// residuals over sigma_s^2, plus 2 k.
    #[must_use]
    pub fn aic_difference(&self) -> Option<f64> {
        let aic = |fit: &Fit| {
            let rows = fit.rows().len() as f64;
            let misfit = match self.sigma_counts {
                Some(sigma) => {
                    let weights: f64 = fit.rows().iter().map(|(row, _)| row.weight).sum();
                    weights * (fit.rms_counts / sigma).powi(2)
                }
                None => 2.0 * rows * rounded_rms_counts(fit).ln(),
            };
            let of_mean = |estimate: &&Estimate| estimate.parameter != Parameter::Sigma;
            let fitted = fit.estimates().iter().filter(of_mean);
            let fitted = fitted.filter(|estimate| estimate.origin == Origin::Fitted);
            misfit + 2.0 * fitted.count() as f64
        };
        Some(aic(self.point.as_ref().ok()?) - aic(self.wall.as_ref().ok()?))
    }

    /// Which law explains the table better.
    ///
    /// One that can be fitted, if the other cannot. Else the one with the smaller AIC, if
    /// AIC differs by at least 10 and the residuals' RMS by at least 5 %.
    #[must_use]
    pub fn verdict(&self) -> LawVerdict {
        let (point, wall) = match (&self.point, &self.wall) {
            (Ok(point), Ok(wall)) => (point, wall),
            (Ok(_), Err(_)) => return LawVerdict::Better(LawKind::Point),
            (Err(_), _) => return LawVerdict::Better(LawKind::Wall),
        };
        let ratio = rounded_rms_counts(point) / rounded_rms_counts(wall);
        match self.aic_difference() {
            Some(by) if by >= DECISIVE_AIC && ratio >= DECISIVE_RATIO => {
                LawVerdict::Better(LawKind::Wall)
            }
            Some(by) if by <= -DECISIVE_AIC && ratio <= 1.0 / DECISIVE_RATIO => {
                LawVerdict::Better(LawKind::Point)
            }
            _ => LawVerdict::Undecided,
        }
    }

    /// The fit of the better law, that of the point law if the table does not decide.
    ///
    /// # Errors
    /// The error of that law, which [`LawComparison::of`] excludes.
    pub fn better(&self) -> Result<&Fit, &FitError> {
        match self.verdict() {
            LawVerdict::Better(LawKind::Wall) => self.wall.as_ref(),
            LawVerdict::Better(LawKind::Point) | LawVerdict::Undecided => self.point.as_ref(),
        }
    }

    /// The verdict as one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let (point, wall) = match (&self.point, &self.wall) {
            (Ok(point), Ok(wall)) => (point, wall),
            (Err(error), _) => {
                return format!("only the law of extended surfaces can be fitted: {error}");
            }
            (_, Err(error)) => return format!("only the point law can be fitted: {error}"),
        };
        let (better, worse) = match self.verdict() {
            LawVerdict::Better(LawKind::Point) => (point, wall),
            LawVerdict::Better(LawKind::Wall) => (wall, point),
            LawVerdict::Undecided => {
                return format!(
                    "the table does not decide between the laws: residual {:.2} counts under \
                     the point law, {:.2} under that of extended surfaces",
                    point.rms_counts, wall.rms_counts
                );
            }
        };
        format!(
            "the {} explains the table better: residual {:.2} counts against {:.2}",
            better.law.name(),
            better.rms_counts,
            worse.rms_counts
        )
    }
}

/// The fit with xi or delta held at the end of its range that it leaves; with xi held at the
/// better end, if the search for the fit runs away.
fn held_at_bound(
    kind: LawKind,
    error: FitError,
    table: &Table,
    fixed: &Fixed,
) -> Result<Fit, FitError> {
    let (parameter, bounds, why) = match &error {
        FitError::OutOfRange {
            parameter: parameter @ (Parameter::Xi | Parameter::Delta),
            value,
            low,
            high,
            ..
        } => {
            let why = format!("it comes out as {value:.4}, out of range");
            (*parameter, vec![value.clamp(*low, *high)], why)
        }
        FitError::NoConvergence(_) if fixed.value(Parameter::Xi).is_none() => {
            let (low, high) = Parameter::Xi.range();
            let why = "the search leaves its range".to_owned();
            (Parameter::Xi, vec![low, high], why)
        }
        _ => return Err(error),
    };
    let fits = bounds.into_iter().filter_map(|bound| {
        let fixed = fixed.with(parameter, bound).ok()?;
        fit_law(kind, table, &fixed).ok()
    });
    let least = fits.min_by(|one, other| one.rms_counts.total_cmp(&other.rms_counts));
    let mut fit = least.ok_or(error)?;
    for estimate in &mut fit.estimates {
        if estimate.parameter == parameter {
            estimate.origin = Origin::Held(why.clone());
        }
    }
    Ok(fit)
}

/// RMS of the residuals, at least what rounding to whole counts makes.
fn rounded_rms_counts(fit: &Fit) -> f64 {
    fit.rms_counts.max(ROUNDING_COUNTS)
}

/// Both fits side by side, and the verdict.
impl fmt::Display for LawComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Ok(point), Ok(wall)) = (&self.point, &self.wall) else {
            if let Ok(fit) = self.better() {
                writeln!(f, "{fit}")?;
            }
            return writeln!(f, "{}", self.sentence());
        };
        let names = [point, wall].map(|fit| fit.law.name());
        writeln!(f, "{:<12}{:<38}{}", "", names[0], names[1])?;
        let rms = [point, wall].map(|fit| format!("{:.2} counts", fit.rms_counts));
        writeln!(f, "{:<12}{:<38}{}", "RMS", rms[0], rms[1])?;
        for (one, other) in point.estimates().iter().zip(wall.estimates()) {
            let unit = one.parameter.unit();
            let [one_text, other_text] = [one, other].map(|estimate| {
                let error = estimate.standard_error.unwrap_or(0.0);
                let (value, error) = match estimate.parameter {
                    Parameter::Delta => (format!("{:.3e}", estimate.value), format!("{error:.1e}")),
                    _ => (format!("{:.4}", estimate.value), format!("{error:.4}")),
                };
                match estimate.origin {
                    Origin::Fitted => format!("{value} +- {error} {unit}"),
                    Origin::Fixed => format!("{value} {unit} fixed"),
                    Origin::Held(_) => format!("{value} {unit} held"),
                }
            });
            let line = format!("{:<12}{one_text:<38}{other_text}", one.parameter.name());
            writeln!(f, "{}", line.trim_end())?;
        }
        for fit in [point, wall] {
            for estimate in fit.estimates() {
                if let Origin::Held(why) = &estimate.origin {
                    let (law, name) = (fit.law.name(), estimate.parameter);
                    writeln!(f, "{name} of the {law} is held: {why}")?;
                }
            }
        }
        writeln!(f, "\n{}", self.sentence())
    }
}
