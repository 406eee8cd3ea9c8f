//! Mean and spread of a figure over seeds.

/// A figure over several drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// How many drives.
    pub count: usize,
    /// Mean; `None` if the figure is undefined for any of them, or there are none.
    pub mean: Option<f64>,
    /// Standard deviation of a single drive (of n - 1); `None` for fewer than two.
    pub deviation: Option<f64>,
}

impl Spread {
    /// Over the given values.
    #[must_use]
    pub fn of(values: &[Option<f64>]) -> Self {
        let count = values.len();
        let defined: Option<Vec<f64>> = values.iter().copied().collect();
        let defined = defined.filter(|defined| !defined.is_empty());
        let mean = defined
            .as_ref()
            .map(|values| values.iter().sum::<f64>() / count as f64);
        let deviation = defined.zip(mean).and_then(|(values, mean)| {
            let squares: f64 = values
                .iter()
                .map(|value| (value - mean) * (value - mean))
                .sum();
            (count > 1).then(|| (squares / (count - 1) as f64).sqrt())
        });
        Self {
            count,
            mean,
            deviation,
        }
    }

    /// Standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> Option<f64> {
        self.deviation
            .map(|deviation| deviation / (self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_a_sample() {
        let spread = Spread::of(&[Some(1.0), Some(2.0), Some(6.0)]);
        assert!((spread.mean.unwrap() - 3.0).abs() < 1e-12);
        // ((-2)^2 + (-1)^2 + 3^2) / 2 = 7.
        assert!((spread.deviation.unwrap() - 7.0_f64.sqrt()).abs() < 1e-12);
        let error = spread.standard_error().unwrap();
        assert!((error - (7.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_undefined_value_makes_the_mean_undefined() {
        assert_eq!(Spread::of(&[Some(1.0), None]).mean, None);
        assert_eq!(Spread::of(&[]).mean, None);
        let single = Spread::of(&[Some(1.0)]);
        assert_eq!((single.mean, single.deviation), (Some(1.0), None));
    }
}
