//! A number of a table.

use core::fmt;

/// A number of a table: fixed decimals, `n/a` where undefined, aligned to the right.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// The value.
    pub value: Option<f64>,
    /// Digits behind the decimal point.
    pub decimals: usize,
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = self.decimals;
        let text = match self.value {
            Some(value) => format!("{value:.decimals$}"),
            None => "n/a".to_owned(),
        };
        match f.width() {
            Some(width) => write!(f, "{text:>width$}"),
            None => f.write_str(&text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_undefined_number_is_marked_in_its_column() {
        let number = |value| Number { value, decimals: 1 };
        assert_eq!(format!("{:6}", number(Some(12.345))), "  12.3");
        assert_eq!(format!("{:6}", number(None)), "   n/a");
    }
}
