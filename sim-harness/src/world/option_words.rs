//! Options as words, and as a comment line before the scenario of a recording.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::{Options, OptionsError};

/// Beginning of the line, which is a comment in TOML.
const MARK: &str = "# simulated with:";

impl Display for Options {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let default = Self::default();
        let is = |this: f64, that: f64| this.to_bits() == that.to_bits();
        let words = [
            (self.physics != default.physics).then(|| format!("physics={}", self.physics)),
            (!is(self.noise_factor, default.noise_factor))
                .then(|| format!("noise={}", self.noise_factor)),
            (self.drift != default.drift).then(|| format!("drift={}", self.drift)),
            (!is(self.reflectivity_factor, default.reflectivity_factor))
                .then(|| format!("reflectivity={}", self.reflectivity_factor)),
            (!is(self.gain_spread, default.gain_spread))
                .then(|| format!("gain-spread={}", self.gain_spread)),
            (!is(self.dropout, default.dropout)).then(|| format!("dropout={}", self.dropout)),
            self.xi.map(|xi| format!("xi={xi}")),
            self.delta_m2.map(|delta_m2| format!("delta={delta_m2}")),
            (self.odometry != default.odometry).then(|| format!("odometry={}", self.odometry)),
        ];
        let words: Vec<_> = words.into_iter().flatten().collect();
        f.write_str(&words.join(" "))
    }
}

impl FromStr for Options {
    type Err = OptionsError;

    /// Words separated by spaces; the last value of an option counts.
    fn from_str(text: &str) -> Result<Self, OptionsError> {
        let mut options = Self::default();
        for word in text.split_whitespace() {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            options.set(key, value)?;
        }
        options.validate()?;
        Ok(options)
    }
}

impl Options {
    fn set(&mut self, key: &str, value: &str) -> Result<(), OptionsError> {
        match key {
            "physics" => self.physics = value.parse()?,
            "noise" => self.noise_factor = number("noise", value)?,
            "drift" => self.drift = value.parse()?,
            "reflectivity" => self.reflectivity_factor = number("reflectivity", value)?,
            "gain-spread" => self.gain_spread = number("gain-spread", value)?,
            "dropout" => self.dropout = number("dropout", value)?,
            "xi" => self.xi = Some(number("xi", value)?),
            "delta" => self.delta_m2 = Some(number("delta", value)?),
            "odometry" => self.odometry = value.parse()?,
            _ => return Err(OptionsError::Unknown(key.to_owned())),
        }
        Ok(())
    }

    /// The scenario's text after a line with these options.
    ///
    /// The default options need no line, unless the text begins with such a line itself:
    /// then an empty line of options comes before it, and counts.
    #[must_use]
    pub fn in_front_of(&self, scenario: &str) -> String {
        if *self == Self::default() && !scenario.starts_with(MARK) {
            return scenario.to_owned();
        }
        let line = format!("{MARK} {self}");
        format!("{}\n{scenario}", line.trim_end())
    }

    /// The options in the first line of a scenario's text; the default without such a
    /// line.
    ///
    /// # Errors
    /// An unknown option, or a value outside its range.
    pub fn named_in(scenario: &str) -> Result<Self, OptionsError> {
        let line = scenario.lines().next().unwrap_or_default();
        line.strip_prefix(MARK).unwrap_or_default().parse()
    }
}

fn number(key: &'static str, text: &str) -> Result<f64, OptionsError> {
    text.parse()
        .map_err(|_| OptionsError::value(key, text, "a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Drift, OdometryModel, Physics, WheelErrors};

    fn all() -> Options {
        Options {
            physics: Physics::Patch,
            noise_factor: 0.1 + 0.2,
            drift: "0..-10".parse().unwrap(),
            reflectivity_factor: 0.7,
            gain_spread: 0.12,
            dropout: 1e-3,
            xi: Some(1.0),
            delta_m2: Some(-250e-6),
            odometry: OdometryModel::WheelErrors(WheelErrors::default()),
        }
    }

    #[test]
    fn words_give_the_options_back() {
        let words = "physics=patch noise=0.30000000000000004 drift=0..-10 reflectivity=0.7 \
                     gain-spread=0.12 dropout=0.001 xi=1 delta=-0.00025 odometry=wheel-errors:1:2";
        assert_eq!(all().to_string(), words);
        assert_eq!(words.parse(), Ok(all()));
        assert_eq!(Options::default().to_string(), "");
        assert_eq!("".parse(), Ok(Options::default()));
    }

    #[test]
    fn a_scenario_stays_as_it_is_behind_the_line() {
        let scenario = "name = \"small\"\n";
        assert_eq!(Options::default().in_front_of(scenario), scenario);
        assert_eq!(Options::named_in(scenario), Ok(Options::default()));
        let inscribed = all().in_front_of(scenario);
        assert!(inscribed.starts_with("# simulated with: physics=patch "));
        assert!(inscribed.ends_with(&format!("\n{scenario}")));
        assert_eq!(Options::named_in(&inscribed), Ok(all()));
        // A text out of another recording: the new line counts, an empty one too.
        let again = Options::default().in_front_of(&inscribed);
        assert_eq!(Options::named_in(&again), Ok(Options::default()));
    }

    #[test]
    fn lines_that_name_no_option_are_refused() {
        let cases = [
            ("colour=1", "`colour` is no option"),
            ("physics", "physics: `` is not matched or patch"),
            ("noise=much", "noise: `much` is not a number"),
            ("noise=NaN", "noise: NaN is outside 0 to 100"),
            ("drift=1..", "drift: `1..` is not counts"),
            ("drift=1..inf", "drift: inf is outside"),
            ("gain-spread=1", "gain-spread: 1 is outside 0 to 0.5"),
            ("dropout=2", "dropout: 2 is outside 0 to 1"),
        ];
        for (words, expected) in cases {
            let error = Options::named_in(&format!("{MARK} {words}\nname")).unwrap_err();
            assert!(error.to_string().starts_with(expected), "{error}");
        }
        let drift = Options {
            drift: Drift::constant(3.0),
            ..Options::default()
        };
        assert_eq!("drift=1 drift=3".parse(), Ok(drift), "the last one holds");
    }
}
