//! The start of the search for the least squares.

use amiro_ipf::model::Photometry;

use super::{CalibrationPoint, Fixed, Law, LawKind, Parameter};

/// The best of a grid over xi and delta, with the alpha and beta of least squares.
///
/// Without it a search from a poor xi ends in lobes that close before most rows.
pub(super) fn start<'t>(
    kind: LawKind,
    rows: &'t [CalibrationPoint],
    fixed: &Fixed,
    free: &[Parameter],
) -> Law<'t> {
    let known = Parameter::OF_MEAN.map(|parameter| {
        let default = parameter.of(&Photometry::VCNL4020);
        fixed.value(parameter).unwrap_or(default)
    });
    let [alpha, beta, xi, delta] = known;
    let is_free = |parameter| free.contains(&parameter);
    let xis: Vec<f64> = match is_free(Parameter::Xi) {
        true => (0..20).map(|step| 0.5 + 0.05 * f64::from(step)).collect(),
        false => vec![xi],
    };
    let deltas: &[f64] = match is_free(Parameter::Delta) {
        true => &[0.0, -1e-4, 1e-4, -5e-4, 5e-4, -2e-3],
        false => &[delta],
    };
    let mut best = (f64::INFINITY, Law::new(kind, rows, free.to_vec(), known));
    for (xi, delta) in xis
        .iter()
        .flat_map(|xi| deltas.iter().map(|delta| (*xi, *delta)))
    {
        let shaped = Law::new(kind, rows, free.to_vec(), [1.0, 0.0, xi, delta]);
        if shaped.ends_early() {
            continue;
        }
        let free_gain = is_free(Parameter::Alpha).then_some(alpha);
        let free_rest = is_free(Parameter::Beta).then_some(beta);
        let (alpha, beta) = linear(&shaped, rows, (alpha, beta), free_gain, free_rest);
        let law = Law::new(kind, rows, free.to_vec(), [alpha, beta, xi, delta]);
        let squares = law.squares();
        if squares < best.0 {
            best = (squares, law);
        }
    }
    best.1
}

/// Alpha and beta of least squares for a given shape, where they are free.
fn linear(
    shaped: &Law<'_>,
    rows: &[CalibrationPoint],
    (alpha, beta): (f64, f64),
    free_gain: Option<f64>,
    free_rest: Option<f64>,
) -> (f64, f64) {
    let (mut w, mut wg, mut wgg, mut ws, mut wgs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for row in rows {
        let g = shaped.shape(row);
        w += row.weight;
        wg += row.weight * g;
        wgg += row.weight * g * g;
        ws += row.weight * row.counts;
        wgs += row.weight * g * row.counts;
    }
    let determinant = w * wgg - wg * wg;
    let solved = match (free_gain, free_rest) {
        (Some(_), Some(_)) => {
            let gain = (w * wgs - wg * ws) / determinant;
            (gain, (ws - gain * wg) / w)
        }
        (Some(_), None) => ((wgs - beta * wg) / wgg, beta),
        (None, Some(_)) => (alpha, (ws - alpha * wg) / w),
        (None, None) => (alpha, beta),
    };
    if solved.0.is_finite() && solved.1.is_finite() {
        solved
    } else {
        (alpha, beta)
    }
}
