//! Parameters that are known before a fit.

use std::str::FromStr;

use super::Parameter;

/// The parameters of the law that are known and not fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed {
    values: [Option<f64>; Parameter::ALL.len()],
}

/// The reason for which a parameter is not fixed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FixedError {
    /// Not of the form NAME=VALUE.
    #[error("'{0}' is not NAME=VALUE")]
    Form(String),
    /// No such parameter.
    #[error("no parameter is called '{0}': alpha, beta, xi, delta, sigma")]
    Name(String),
    /// The value is no number or outside the parameter's range.
    #[error("{parameter} must be a number from {low} to {high}, not '{value}'")]
    Value {
        /// Which.
        parameter: Parameter,
        /// The given value.
        value: String,
        /// Least legal value.
        low: f64,
        /// Largest legal value.
        high: f64,
    },
}

impl Fixed {
    /// The same with one parameter fixed; a second value replaces the first.
    ///
    /// # Errors
    /// [`FixedError::Value`] outside the parameter's range, NaN included.
    pub fn with(mut self, parameter: Parameter, value: f64) -> Result<Self, FixedError> {
        let (low, high) = parameter.range();
        if !(low..=high).contains(&value) {
            return Err(FixedError::Value {
                parameter,
                value: value.to_string(),
                low,
                high,
            });
        }
        if let Some(slot) = self.values.get_mut(parameter as usize) {
            *slot = Some(value);
        }
        Ok(self)
    }

    /// The value that a parameter is fixed at.
    #[must_use]
    pub fn value(&self, parameter: Parameter) -> Option<f64> {
        self.values.get(parameter as usize).copied().flatten()
    }

    /// The parameters fixed by words of the form NAME=VALUE.
    ///
    /// # Errors
    /// The first word that is not of that form.
    pub fn parse<'w>(words: impl IntoIterator<Item = &'w str>) -> Result<Self, FixedError> {
        words.into_iter().try_fold(Self::default(), |fixed, word| {
            let (parameter, value) = assignment(word)?;
            fixed.with(parameter, value)
        })
    }
}

impl FromStr for Fixed {
    type Err = FixedError;

    fn from_str(word: &str) -> Result<Self, FixedError> {
        Self::parse([word])
    }
}

fn assignment(word: &str) -> Result<(Parameter, f64), FixedError> {
    let (name, value) = word
        .split_once('=')
        .ok_or_else(|| FixedError::Form(word.to_owned()))?;
    let (name, value) = (name.trim(), value.trim());
    let parameter = Parameter::ALL
        .into_iter()
        .find(|parameter| parameter.name() == name)
        .ok_or_else(|| FixedError::Name(name.to_owned()))?;
    let number = value.parse().map_err(|_| {
        let (low, high) = parameter.range();
        FixedError::Value {
            parameter,
            value: value.to_owned(),
            low,
            high,
        }
    })?;
    Ok((parameter, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_fix_parameters_and_bad_words_are_refused_with_a_reason() {
        let fixed = Fixed::parse(["xi=1.2", "beta = -16"]).unwrap();
        assert_eq!(fixed.value(Parameter::Xi), Some(1.2));
        assert_eq!(fixed.value(Parameter::Beta), Some(-16.0));
        assert_eq!(fixed.value(Parameter::Alpha), None);
        for (word, message) in [
            ("xi", "'xi' is not NAME=VALUE"),
            (
                "chi=1",
                "no parameter is called 'chi': alpha, beta, xi, delta, sigma",
            ),
            (
                "xi=many",
                "xi must be a number from 0.5 to 1.45, not 'many'",
            ),
            ("xi=2", "xi must be a number from 0.5 to 1.45, not '2'"),
            ("xi=NaN", "xi must be a number from 0.5 to 1.45, not 'NaN'"),
        ] {
            assert_eq!(Fixed::parse([word]).unwrap_err().to_string(), message);
        }
    }
}
