//! Mean and spread of what several seeds gave.

/// Mean and standard deviation of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    /// The mean; 0 of nothing.
    pub(super) mean: f64,
    /// The sample's standard deviation; 0 of fewer than two values.
    pub(super) deviation: f64,
}

impl Moments {
    /// Of the values that there are.
    pub(super) fn of(values: impl Iterator<Item = Option<f64>>) -> Self {
        let values: Vec<f64> = values.flatten().collect();
        let count = values.len() as f64;
        if values.is_empty() {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|value| (value - mean) * (value - mean));
        let freedom = (count - 1.0).max(1.0);
        Self {
            mean,
            deviation: (squares.sum::<f64>() / freedom).sqrt(),
        }
    }

    /// Both times a factor.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            mean: factor * self.mean,
            deviation: factor * self.deviation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_does_not_count() {
        let moments = Moments::of([Some(1.0), None, Some(3.0)].into_iter());
        assert!((moments.mean - 2.0).abs() < 1e-12);
        assert!((moments.deviation - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(Moments::of([None].into_iter()), Moments::default());
        assert!(Moments::of([Some(5.0)].into_iter()).deviation.abs() < 1e-12);
    }
}
