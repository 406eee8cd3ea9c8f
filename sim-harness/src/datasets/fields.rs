//! The numbers of a row of text.

use super::RefusedRow;
use super::lines::Lines;
use crate::drive::Return;
use crate::escape::escaped;

/// Exactly four numbers.
pub(super) fn numbers(lines: &Lines, separator: char) -> Result<[f64; 4], RefusedRow> {
    let text = lines.text()?;
    let mut fields = text
        .split(separator)
        .map(str::trim)
        .filter(|field| !field.is_empty());
    let mut row = [0.0; 4];
    for value in &mut row {
        *value = number(lines, fields.next().unwrap_or_default())?;
    }
    if fields.next().is_some() {
        return Err(lines.refused("more than 4 values".to_owned()));
    }
    Ok(row)
}

fn number(lines: &Lines, field: &str) -> Result<f64, RefusedRow> {
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
