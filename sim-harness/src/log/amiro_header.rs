//! The header of AMiRo's text, and guesses at the meaning of a file without it.

use super::Problem;
use crate::escape::escaped;

/// The columns of a row, as the header names them.
pub(super) const COLUMNS: [&str; 11] = [
    "PRV 0", "PRV 1", "PRV 2", "PRV 3", "PRV 4", "PRV 5", "PRV 6", "PRV 7", "X", "Y", "Theta",
];
/// The pose's columns, as they are written without blanks and with their units.
const POSE: [(&str, &str); 3] = [("x", "[ym]"), ("y", "[ym]"), ("theta", "[yrad]")];

/// Checks that a line is the header: eight PRV columns, then the pose in ym and yrad.
///
/// Case and blanks do not matter. `head` is the beginning of the source, for a guess
/// at what its numbers mean when the header is missing.
///
/// # Errors
/// [`Problem::NoHeader`] for anything else, [`Problem::OtherUnits`] for a header without
/// micrometres and microradians.
pub(super) fn check(line: &str, head: &[u8]) -> Result<(), Problem> {
    let fields: Vec<String> = fields(line).map(squeezed).collect();
    let Some((readings, pose)) = fields.split_first_chunk::<8>() else {
        return Err(missing(line, head));
    };
    let readings_match = readings
        .iter()
        .zip(COLUMNS)
        .all(|(field, column)| *field == squeezed(column));
    let pose_matches = pose.len() == POSE.len()
        && pose
            .iter()
            .zip(POSE)
            .all(|(field, (name, _))| field.split('[').next() == Some(name));
    if !readings_match || !pose_matches {
        return Err(missing(line, head));
    }
    let units_match = pose
        .iter()
        .zip(POSE)
        .all(|(field, (name, unit))| field.strip_prefix(name) == Some(unit));
    if units_match {
        return Ok(());
    }
    let named: Vec<&str> = fields_of_pose(line).collect();
    Err(Problem::OtherUnits {
        found: escaped(&named.join(", ")),
    })
}

/// The fields of a line; a tab or carriage return at its end is no further field.
pub(super) fn fields(line: &str) -> impl Iterator<Item = &str> {
    let line = line.strip_suffix('\r').unwrap_or(line);
    line.strip_suffix('\t').unwrap_or(line).split('\t')
}

fn fields_of_pose(line: &str) -> impl Iterator<Item = &str> {
    fields(line).skip(8).map(str::trim)
}

fn squeezed(text: &str) -> String {
    text.chars()
        .filter(|character| !character.is_whitespace())
        .flat_map(char::to_lowercase)
        .collect()
}

fn missing(line: &str, head: &[u8]) -> Problem {
    let begins = escaped(line);
    if let Some(separator) = other_separator(line) {
        let found = format!("{separator} between the columns of '{begins}', not tabs");
        return Problem::NoHeader { found };
    }
    let found = match guess(head) {
        Some(unit) => format!("no header, but '{begins}', whose values look like {unit}"),
        None => format!("no header, but '{begins}'"),
    };
    Problem::NoHeader { found }
}

/// What separates the columns of a header that lacks nothing but its tabs.
fn other_separator(line: &str) -> Option<&'static str> {
    let header: String = COLUMNS.map(squeezed).concat();
    let squeezed = squeezed(line);
    let is_header = |text: &str| {
        let units = POSE.iter().map(|(_, unit)| *unit);
        let bare = units.fold(text.to_owned(), |text, unit| text.replace(unit, ""));
        bare == header
    };
    if is_header(&squeezed.replace(',', "")) && squeezed.contains(',') {
        Some("commas")
    } else if is_header(&squeezed.replace(';', "")) && squeezed.contains(';') {
        Some("semicolons")
    } else if is_header(&squeezed) && !line.trim().contains('\t') {
        Some("blanks")
    } else {
        None
    }
}

/// What the largest coordinate of the first rows would be in a room of 2 cm to 20 m.
fn guess(head: &[u8]) -> Option<&'static str> {
    let largest = String::from_utf8_lossy(head)
        .lines()
        .filter_map(largest_coordinate)
        .fold(0.0, f64::max);
    if largest >= 20_000.0 {
        Some("micrometres")
    } else if largest >= 20.0 {
        Some("millimetres")
    } else if largest > 0.0 {
        Some("metres")
    } else {
        None
    }
}

/// The larger of |x| and |y| of a line of eleven numbers.
fn largest_coordinate(line: &str) -> Option<f64> {
    let numbers: Option<Vec<f64>> = fields(line)
        .map(|field| field.trim().parse().ok().filter(|n: &f64| n.is_finite()))
        .collect();
    match numbers?.as_slice() {
        [_, _, _, _, _, _, _, _, x, y, _] => Some(x.abs().max(y.abs())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\t\
                          X [ym]\tY [ym]\tTheta [yrad]";

    #[test]
    fn header_may_have_blanks_and_a_last_tab() {
        for header in [
            HEADER.to_owned(),
            format!("{HEADER}\t"),
            HEADER.replace(' ', ""),
            HEADER.replace('\t', " \t  "),
            HEADER.to_lowercase(),
        ] {
            assert!(check(&header, b"").is_ok(), "{header:?}");
        }
    }

    #[test]
    fn missing_extra_and_swapped_columns_are_no_header() {
        for header in [
            HEADER.replace("PRV 3\t", ""),
            HEADER.replace("PRV 3\t", "PRV 3\tPRV 3\t"),
            HEADER.replace("X [ym]\tY [ym]", "Y [ym]\tX [ym]"),
            format!("{HEADER}\tTime [us]"),
            "Xylophone".to_owned(),
            String::new(),
        ] {
            let problem = check(&header, b"").unwrap_err();
            assert!(matches!(problem, Problem::NoHeader { .. }), "{header:?}");
        }
    }

    #[test]
    fn a_header_without_tabs_is_refused_with_what_it_has() {
        for (separator, message) in [
            (",", "commas"),
            (", ", "commas"),
            (";", "semicolons"),
            ("   ", "blanks"),
        ] {
            let header = HEADER.replace('\t', separator);
            let problem = check(&header, b"").unwrap_err().to_string();
            let begin = format!("{message} between the columns of 'PRV 0");
            assert!(problem.starts_with(&begin), "{problem}");
            assert!(
                problem.contains("', not tabs; expected the header"),
                "{problem}"
            );
        }
    }

    #[test]
    fn the_size_of_the_coordinates_gives_their_unit() {
        for (x, unit) in [
            ("3010304", Some("micrometres")),
            ("-3010.3", Some("millimetres")),
            ("3.01", Some("metres")),
            ("0", None),
            ("inf", None),
        ] {
            let row = format!("1\t2\t3\t4\t5\t6\t7\t8\t{x}\t0\t0\n");
            assert_eq!(guess(row.as_bytes()), unit, "{x}");
        }
    }
}
