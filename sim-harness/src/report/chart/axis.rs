//! An axis: its ends, its ticks at round numbers, and the position of a value on it.

/// Greatest number of steps between ticks.
const MOST_STEPS: f64 = 6.0;

/// Rounding that is allowed for at the ends, steps.
const ROUNDING: f64 = 1e-9;

/// Powers of ten that a step may have, with the decimals that show them.
const UNITS: [(f64, usize); 9] = [
    (1e-4, 4),
    (1e-3, 3),
    (1e-2, 2),
    (1e-1, 1),
    (1.0, 0),
    (10.0, 0),
    (100.0, 0),
    (1e3, 0),
    (1e4, 0),
];

/// One axis of a chart.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    label: String,
    low: f64,
    high: f64,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis from one value to a higher one, with ticks at round numbers between.
    ///
    /// The label names the quantity and its unit.
    pub(crate) fn linear(label: &str, low: f64, high: f64) -> Self {
        let (step, decimals) = round_step((high - low) / MOST_STEPS);
        let first = (low / step - ROUNDING).ceil() as i64;
        let last = (high / step + ROUNDING).floor() as i64;
        let tick = |index: i64| {
            let value = index as f64 * step;
            (value, format!("{value:.decimals$}"))
        };
        Self {
            label: label.to_owned(),
            low,
            high,
            ticks: (first..=last).map(tick).collect(),
        }
    }

    /// An axis with names at 0, 1, 2, ..., at equal distances.
    pub(crate) fn named<S: ToString>(label: &str, names: &[S]) -> Self {
        let places = (0_u32..).map(f64::from);
        Self {
            label: label.to_owned(),
            low: -0.5,
            high: names.len() as f64 - 0.5,
            ticks: places.zip(names.iter().map(S::to_string)).collect(),
        }
    }

    /// Quantity and unit.
    pub(crate) fn label(&self) -> &str {
        &self.label
    }

    /// Length of the axis in its own unit.
    pub(crate) fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Values with a tick, and their text.
    pub(crate) fn ticks(&self) -> &[(f64, String)] {
        &self.ticks
    }

    /// Position of a value on an axis of so many pixels: 0 for the low end.
    pub(crate) fn place(&self, value: f64, length_px: usize) -> f64 {
        (value - self.low) / self.span() * length_px as f64
    }

    /// The value in the middle of a pixel: the inverse of [`place`](Self::place).
    pub(crate) fn value(&self, pixel: usize, length_px: usize) -> f64 {
        self.low + (pixel as f64 + 0.5) / length_px as f64 * self.span()
    }
}

/// The first of 1, 2, 5, 10, ... times a power of ten that is not less than the given value.
fn round_step(least: f64) -> (f64, usize) {
    for (unit, decimals) in UNITS {
        for count in [1.0, 2.0, 5.0] {
            if count * unit >= least * (1.0 - ROUNDING) {
                return (count * unit, decimals);
            }
        }
    }
    (least, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(axis: &Axis) -> Vec<&str> {
        axis.ticks().iter().map(|tick| tick.1.as_str()).collect()
    }

    #[test]
    fn ends_lie_at_the_first_and_the_last_pixel() {
        for (low, high) in [(0.0, 25.0), (-120.0, 120.0), (0.25, 4.0)] {
            let axis = Axis::linear("x", low, high);
            assert!(axis.place(low, 400).abs() < 1e-9);
            assert!((axis.place(high, 400) - 400.0).abs() < 1e-9);
            assert!((axis.place(0.5 * (low + high), 400) - 200.0).abs() < 1e-9);
            assert!((axis.place(axis.value(7, 400), 400) - 7.5).abs() < 1e-9);
        }
        let axis = Axis::named("method", &["a", "b"]);
        assert!((axis.place(0.0, 400) - 100.0).abs() < 1e-9);
        assert!((axis.place(1.0, 400) - 300.0).abs() < 1e-9);
    }

    #[test]
    fn ticks_are_round_numbers_within_the_ends() {
        let axis = Axis::linear("x", 0.0, 25.0);
        assert_eq!(written(&axis), ["0", "5", "10", "15", "20", "25"]);
        let axis = Axis::linear("x", -0.3, 0.3);
        assert_eq!(
            written(&axis),
            ["-0.3", "-0.2", "-0.1", "0.0", "0.1", "0.2", "0.3"]
        );
        let axis = Axis::linear("x", 3.0, 97.0);
        assert_eq!(written(&axis), ["20", "40", "60", "80"]);
        assert_eq!(written(&Axis::linear("x", 0.0, 0.02)).len(), 5);
        assert_eq!(written(&Axis::named("x", &[25, 1000])), ["25", "1000"]);
    }
}
