//! The fit of the photometric law to a table, with the parameters that it leaves open.

use nalgebra::{DMatrix, DVector};

use super::start::start;
use super::{CalibrationPoint, Estimate, Fit, Fixed, Law, LawKind, Origin, Parameter, Table};

/// Least distance of a column of derivatives from the span of those before it, as a share
/// of its length; a nearer one is dependent.
const DEPENDENT: f64 = 1e-6;
/// A standard error above this share of a parameter's range leaves it undetermined.
const MOST_ERROR_SHARE: f64 = 0.25;
/// Why the fit fails.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Fewer rows than a fit with errors takes.
    #[error("{rows} measurements, {needed} are needed to fit {names}")]
    TooFewRows {
        /// Number of rows.
        rows: usize,
        /// Number of rows that are needed.
        needed: usize,
        /// The parameters to fit.
        names: String,
    },
    /// With one range, gain and remainder cannot be distinguished.
    #[error("all ranges are {range_m} m: alpha and beta cannot be told apart; fix one of them")]
    SameRange {
        /// The range.
        range_m: f64,
    },
    /// The rows leave the gain or the remainder open.
    #[error("the measurements do not determine {0}; fix it")]
    Undetermined(Parameter),
    /// The least squares lie where no configuration may.
    #[error(
        "{parameter} comes out as {value:.4} (standard error {standard_error:.4}), outside {low} to {high}: \
             not this law, or not these units"
    )]
    OutOfRange {
        /// Which.
        parameter: Parameter,
        /// The fitted value.
        value: f64,
        /// Its standard error.
        standard_error: f64,
        /// Least legal value.
        low: f64,
        /// Largest legal value.
        high: f64,
    },
    /// The search ended without an answer.
    #[error("no convergence: {0}")]
    NoConvergence(String),
}

/// Fits the photometric law, that of small surfaces, to a table by weighted least squares:
/// [`fit_law`] of [`LawKind::Point`].
///
/// # Errors
/// A table that leaves alpha or beta open, a result that no configuration takes.
pub fn fit(table: &Table, fixed: &Fixed) -> Result<Fit, FitError> {
    fit_law(LawKind::Point, table, fixed)
}

/// Fits a law to a table by weighted least squares.
///
/// The start is found: alpha and beta are linear, and xi and delta are searched over a grid
/// before Levenberg-Marquardt. A parameter that the table does not determine is held at
/// [`Photometry::VCNL4020`](amiro_ipf::model::Photometry::VCNL4020)'s value, with the
/// reason: delta first, then xi. Standard errors are the roots of the diagonal of sigma_s^2
/// (J^T J)^-1 with the residuals' own sigma_s, unless that is fixed.
///
/// # Errors
/// A table that leaves alpha or beta open, a result that no configuration takes.
pub fn fit_law(kind: LawKind, table: &Table, fixed: &Fixed) -> Result<Fit, FitError> {
    let rows = table.rows();
    let mut held: Vec<(Parameter, String)> = Vec::new();
    let is_free = |parameter| fixed.value(parameter).is_none();
    if is_free(Parameter::Alpha) && is_free(Parameter::Beta) {
        must_differ_in_range(rows)?;
    }
    loop {
        let free: Vec<_> = Parameter::OF_MEAN
            .into_iter()
            .filter(|parameter| is_free(*parameter))
            .filter(|parameter| held.iter().all(|(other, _)| other != parameter))
            .collect();
        match attempt(kind, rows, fixed, &free)? {
            Attempt::Found(law, errors) => return Ok(answer(&law, rows, fixed, &errors, &held)),
            Attempt::Open(parameter, why) => held.push((parameter, why)),
        }
    }
}

/// The result of a fit of certain parameters.
enum Attempt<'t> {
    /// The law, and the standard errors for sigma_s = 1 by free parameter.
    Found(Law<'t>, Vec<(Parameter, f64)>),
    /// A parameter that is better held, and why.
    Open(Parameter, String),
}

fn must_differ_in_range(rows: &[CalibrationPoint]) -> Result<(), FitError> {
    let too_few = |rows| FitError::TooFewRows {
        rows,
        needed: 3,
        names: "alpha and beta".to_owned(),
    };
    match rows {
        [first, others @ ..] if others.len() >= 2 => {
            let differs = |row: &CalibrationPoint| (row.range_m - first.range_m).abs() > 1e-9;
            if others.iter().any(differs) {
                return Ok(());
            }
            let range_m = first.range_m;
            Err(FitError::SameRange { range_m })
        }
        _ => Err(too_few(rows.len())),
    }
}

fn attempt<'t>(
    kind: LawKind,
    rows: &'t [CalibrationPoint],
    fixed: &Fixed,
    free: &[Parameter],
) -> Result<Attempt<'t>, FitError> {
    let last = free.last().copied();
    let can_be_held = |parameter| matches!(parameter, Parameter::Xi | Parameter::Delta);
    if rows.len() <= free.len() {
        let names: Vec<_> = free.iter().map(|parameter| parameter.name()).collect();
        return match last.filter(|last| can_be_held(*last)) {
            Some(last) => Ok(Attempt::Open(last, "too few measurements".to_owned())),
            None => Err(FitError::TooFewRows {
                rows: rows.len(),
                needed: free.len() + 1,
                names: names.join(" and "),
            }),
        };
    }
    let start = start(kind, rows, fixed, free);
    if let Some(parameter) = first_dependent(free, &start.weighted_slopes()) {
        if can_be_held(parameter) {
            let why = match parameter {
                Parameter::Xi => "the angles do not tell it",
                _ => "the ranges do not tell it",
            };
            return Ok(Attempt::Open(parameter, why.to_owned()));
        }
        return Err(FitError::Undetermined(parameter));
    }
    if free.is_empty() {
        return Ok(Attempt::Found(start, Vec::new()));
    }
    let Some(law) = start.minimised() else {
        return Err(FitError::NoConvergence(
            "the search does not end".to_owned(),
        ));
    };
    let Some(errors) = unit_errors(free, &law.weighted_slopes()) else {
        return Err(FitError::NoConvergence("singular at the end".to_owned()));
    };
    let sigma = sigma_counts(&law, rows.len(), free.len(), fixed);
    // The last first: once it is held, the others may be determined.
    for &(parameter, error) in errors.iter().rev() {
        let (low, high) = parameter.range();
        let (value, standard_error) = (value(&law, parameter), sigma * error);
        let is_open = standard_error > MOST_ERROR_SHARE * (high - low);
        if can_be_held(parameter) && is_open {
            let why = format!("its standard error would be {standard_error:.2}");
            return Ok(Attempt::Open(parameter, why));
        }
        if !(low..=high).contains(&value) {
            return Err(FitError::OutOfRange {
                parameter,
                value,
                standard_error,
                low,
                high,
            });
        }
    }
    Ok(Attempt::Found(law, errors))
}

/// The first parameter whose derivatives are a combination of those before it.
fn first_dependent(free: &[Parameter], slopes: &DMatrix<f64>) -> Option<Parameter> {
    let mut span: Vec<DVector<f64>> = Vec::new();
    for (parameter, column) in free.iter().zip(slopes.column_iter()) {
        let mut rest = column.clone_owned();
        let length = rest.norm();
        // Twice, to remove the rounding errors of the first pass.
        for base in span.iter().chain(span.iter()) {
            let share = base.dot(&rest);
            rest.axpy(-share, base, 1.0);
        }
        let left = rest.norm();
        if !(length > 0.0 && left > DEPENDENT * length) {
            return Some(*parameter);
        }
        span.push(rest / left);
    }
    None
}

/// Standard errors for sigma_s = 1: roots of the diagonal of (J^T J)^-1.
fn unit_errors(free: &[Parameter], slopes: &DMatrix<f64>) -> Option<Vec<(Parameter, f64)>> {
    // Columns of length 1: the parameters differ by six orders of magnitude.
    let lengths: Vec<f64> = slopes.column_iter().map(|column| column.norm()).collect();
    let mut scaled = slopes.clone();
    for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let inverse = (scaled.transpose() * &scaled).cholesky()?.inverse();
    let errors = inverse
        .diagonal()
        .iter()
        .zip(&lengths)
        .map(|(variance, length)| variance.sqrt() / length)
        .collect::<Vec<_>>();
    let all_finite = errors.iter().all(|error| error.is_finite());
    all_finite.then(|| free.iter().copied().zip(errors).collect())
}

fn sigma_counts(law: &Law<'_>, rows: usize, free: usize, fixed: &Fixed) -> f64 {
    fixed
        .value(Parameter::Sigma)
        .unwrap_or_else(|| (law.squares() / rows.saturating_sub(free).max(1) as f64).sqrt())
}

fn value(law: &Law<'_>, parameter: Parameter) -> f64 {
    let values = law.values();
    values.get(parameter as usize).copied().unwrap_or(f64::NAN)
}

fn answer(
    law: &Law<'_>,
    rows: &[CalibrationPoint],
    fixed: &Fixed,
    errors: &[(Parameter, f64)],
    held: &[(Parameter, String)],
) -> Fit {
    let sigma = sigma_counts(law, rows.len(), errors.len(), fixed);
    let of_mean = Parameter::OF_MEAN.into_iter().map(|parameter| {
        let error = errors.iter().find(|(other, _)| *other == parameter);
        let reason = held.iter().find(|(other, _)| *other == parameter);
        Estimate {
            parameter,
            value: value(law, parameter),
            standard_error: error.map(|(_, error)| sigma * error),
            origin: match reason {
                Some((_, why)) => Origin::Held(why.clone()),
                None if error.is_some() => Origin::Fitted,
                None => Origin::Fixed,
            },
        }
    });
    let is_fixed = fixed.value(Parameter::Sigma).is_some();
    let freedom = rows.len().saturating_sub(errors.len()).max(1) as f64;
    let noise = Estimate {
        parameter: Parameter::Sigma,
        value: sigma,
        standard_error: (!is_fixed).then(|| sigma / (2.0 * freedom).sqrt()),
        origin: if is_fixed {
            Origin::Fixed
        } else {
            Origin::Fitted
        },
    };
    let weights: f64 = rows.iter().map(|row| row.weight).sum();
    Fit {
        law: law.kind(),
        estimates: of_mean.chain([noise]).collect(),
        rows: rows.iter().map(|row| (*row, law.counts(row))).collect(),
        rms_counts: (law.squares() / weights).sqrt(),
    }
}
