//! A figure of a table.

use core::fmt;

/// A figure of a table: fixed decimals, `n/a` where undefined, right of its column.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// The value.
    pub value: Option<f64>,
    /// Digits behind the point.
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
    fn undefined_figures_say_so_in_their_column() {
        let figure = |value| Number { value, decimals: 1 };
        assert_eq!(format!("{:6}", figure(Some(12.345))), "  12.3");
        assert_eq!(format!("{:6}", figure(None)), "   n/a");
    }
}
