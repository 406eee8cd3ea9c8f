//! Mean and standard deviation of a metric over seeds.

/// A metric over several drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanStd {
    /// How many drives.
    pub count: usize,
    /// Mean; `None` if the metric is undefined for any of them, or there are none.
    pub mean: Option<f64>,
    /// Standard deviation of a single drive (of n - 1); `None` for fewer than two.
    pub std: Option<f64>,
}

impl MeanStd {
    /// Over the given values.
    #[must_use]
    pub fn of(values: &[Option<f64>]) -> Self {
        let count = values.len();
        let defined: Option<Vec<f64>> = values.iter().copied().collect();
        let defined = defined.filter(|defined| !defined.is_empty());
        let mean = defined
            .as_ref()
            .map(|values| values.iter().sum::<f64>() / count as f64);
        let std = defined.zip(mean).and_then(|(values, mean)| {
            let squares: f64 = values
                .iter()
                .map(|value| (value - mean) * (value - mean))
                .sum();
            (count > 1).then(|| (squares / (count - 1) as f64).sqrt())
        });
        Self { count, mean, std }
    }

    /// Standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> Option<f64> {
        self.std.map(|std| std / (self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_a_sample() {
        let mean_std = MeanStd::of(&[Some(1.0), Some(2.0), Some(6.0)]);
        assert!((mean_std.mean.unwrap() - 3.0).abs() < 1e-12);
        // ((-2)^2 + (-1)^2 + 3^2) / 2 = 7.
        assert!((mean_std.std.unwrap() - 7.0_f64.sqrt()).abs() < 1e-12);
        let error = mean_std.standard_error().unwrap();
        assert!((error - (7.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_undefined_value_makes_the_mean_undefined() {
        assert_eq!(MeanStd::of(&[Some(1.0), None]).mean, None);
        assert_eq!(MeanStd::of(&[]).mean, None);
        let single = MeanStd::of(&[Some(1.0)]);
        assert_eq!((single.mean, single.std), (Some(1.0), None));
    }
}
