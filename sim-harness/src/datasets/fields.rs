//! The numbers of a row of text.

use super::RefusedRow;
use super::lines::Lines;
use crate::drive::Return;
use crate::escape::escaped;

/// Exactly so many numbers in the line that was read last.
pub(super) fn numbers<const N: usize>(
    lines: &Lines,
    separator: char,
) -> Result<[f64; N], RefusedRow> {
    numbers_of(lines, lines.text()?, separator)
}

/// Exactly so many numbers in a part of the line that was read last.
pub(super) fn numbers_of<const N: usize>(
    lines: &Lines,
    text: &str,
    separator: char,
) -> Result<[f64; N], RefusedRow> {
    let mut fields = text
        .split(separator)
        .map(str::trim)
        .filter(|field| !field.is_empty());
    let mut row = [0.0; N];
    for value in &mut row {
        *value = number(lines, fields.next().unwrap_or_default())?;
    }
    if fields.next().is_some() {
        return Err(lines.refused(format!("more than {N} values")));
    }
    Ok(row)
}

/// A finite number of the line that was read last.
pub(super) fn number(lines: &Lines, field: &str) -> Result<f64, RefusedRow> {
    let value = field.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| {
        let shown = escaped(field);
        lines.refused(format!("'{shown}' is no number"))
    })
}

/// Refuses a row whose stamp is another than that of the same row in another file.
pub(super) fn same_stamp(
    lines: &Lines,
    found: f64,
    expected: f64,
    within: f64,
) -> Result<(), RefusedRow> {
    if (found - expected).abs() <= within {
        return Ok(());
    }
    Err(lines.refused(format!("stamp {found} ms where {expected} ms is expected")))
}

/// The ranges of a row, `count` of them behind the stamp.
pub(super) fn ranges(
    lines: &Lines,
    stamp_ms: f64,
    count: usize,
    measured: impl Fn(usize, f64) -> Option<Return>,
) -> Result<Vec<Return>, RefusedRow> {
    let text = lines.text()?;
    let mut fields = text.split_ascii_whitespace();
    same_stamp(
        lines,
        number(lines, fields.next().unwrap_or_default())?,
        stamp_ms,
        0.0,
    )?;
    let mut returns = Vec::with_capacity(count);
    for (index, field) in fields.enumerate() {
        let value = number(lines, field)?;
        if index >= count {
            return Err(lines.refused(format!("more than {count} ranges")));
        }
        let refused = || lines.refused(format!("{value} mm is no range"));
        returns.push(measured(index, value).ok_or_else(refused)?);
    }
    if returns.len() == count {
        return Ok(returns);
    }
    Err(lines.refused(format!("{} of {count} ranges", returns.len())))
}

/// What a range, not negative, means to a sensor that measures between two limits.
pub(super) fn measured_m(range_m: f64, limits_m: [f64; 2], sigma_m: f64) -> Return {
    let [nearest_m, farthest_m] = limits_m;
    if range_m > farthest_m {
        Return::NoEcho {
            limit_m: farthest_m,
            sigma_m,
        }
    } else if range_m < nearest_m || range_m <= 0.0 {
        Return::TooClose
    } else {
        Return::Echo { range_m, sigma_m }
    }
}
