//! Gains of the sensors of a ring as a TOML file.

use std::fmt::Write;
use std::io;
use std::path::Path;

use amiro_ipf::model::{Gain, SENSORS};
use serde::Deserialize;

use crate::bounded::read_at_most;
use crate::drive::RingCalibration;
use crate::escape::{lines_escaped, whole_escaped};

use super::Parameter;

/// Longest file, bytes.
const MAX_BYTES: u64 = 64 << 10;

/// Gain and relative gains of the sensors of a ring.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainFile {
    /// Gain of the sensors together, counts m^2 (alpha).
    pub alpha_counts_m2: f64,
    /// Standard deviation of alpha, counts m^2.
    pub alpha_sigma_counts_m2: f64,
    /// Gain of each sensor relative to alpha; 1 for one that is not known.
    pub gains: [f64; SENSORS],
    /// Standard deviation of the logarithm of each.
    pub gain_sigmas: [f64; SENSORS],
    /// The recordings that they come from.
    pub sources: Vec<String>,
}

/// Why a file of gains was refused.
#[derive(Debug, thiserror::Error)]
pub enum GainFileError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file's name, escaped.
        file: String,
        /// The system's error.
        source: io::Error,
    },
    /// The text has other keys, a missing one, or a value of another type.
    #[error("{file}: {}", lines_escaped(&.source.to_string()))]
    Format {
        /// The file's name, escaped.
        file: String,
        /// The error with its line.
        source: Box<toml::de::Error>,
    },
    /// A value is outside its range.
    #[error("{file}: {key} is {value}; legal is {low} to {high}")]
    Value {
        /// The file's name, escaped.
        file: String,
        /// The key, with the sensor where it is one of several.
        key: String,
        /// The value.
        value: f64,
        /// Least legal value.
        low: f64,
        /// Largest legal value.
        high: f64,
    },
}

impl GainFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`GainFileError`], with the file, the key and the reason.
    pub fn load(path: &Path) -> Result<Self, GainFileError> {
        let file = whole_escaped(path.to_string_lossy().chars());
        let text = read_at_most(path, MAX_BYTES).and_then(|bytes| {
            String::from_utf8(bytes).map_err(|_| io::Error::other("is not text in UTF-8"))
        });
        match text {
            Ok(text) => Self::parse(&text, &file),
            Err(source) => Err(GainFileError::Read { file, source }),
        }
    }

    /// Reads a text; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(text: &str, file: &str) -> Result<Self, GainFileError> {
        let gains: Self = toml::from_str(text).map_err(|source| GainFileError::Format {
            file: file.to_owned(),
            source: Box::new(source),
        })?;
        let within = |key: String, value: f64, (low, high): (f64, f64)| {
            // NaN is in no range.
            if (low..=high).contains(&value) {
                return Ok(());
            }
            let file = file.to_owned();
            Err(GainFileError::Value {
                file,
                key,
                value,
                low,
                high,
            })
        };
        let of_gain = (f64::from(Gain::LEAST), f64::from(Gain::LARGEST));
        let sigma = (0.0, f64::INFINITY);
        let alpha = Parameter::Alpha.range();
        within("alpha_counts_m2".to_owned(), gains.alpha_counts_m2, alpha)?;
        let key = "alpha_sigma_counts_m2".to_owned();
        within(key, gains.alpha_sigma_counts_m2, sigma)?;
        for (sensor, gain) in gains.gains.iter().enumerate() {
            within(format!("gains[{sensor}]"), *gain, of_gain)?;
        }
        for (sensor, deviation) in gains.gain_sigmas.iter().enumerate() {
            within(format!("gain_sigmas[{sensor}]"), *deviation, sigma)?;
        }
        Ok(gains)
    }

    /// Alpha and gains for a configuration.
    #[must_use]
    pub fn calibration(&self) -> RingCalibration {
        RingCalibration {
            alpha_counts_m2: self.alpha_counts_m2 as f32,
            // A gain that was read is in its range.
            gains: self
                .gains
                .map(|gain| Gain::of(gain as f32).unwrap_or(Gain::ONE)),
        }
    }

    /// The text of a file.
    #[must_use]
    pub fn text(&self) -> String {
        let list = |values: &[f64; SENSORS]| {
            let values = values.map(|value| format!("{value:.4}"));
            format!("[{}]", values.join(", "))
        };
        let mut text = "# Gains of the sensors, by cargo ipf calibrate --from-drive.\n".to_owned();
        // Writing to a string does not fail.
        let _ = writeln!(text, "alpha_counts_m2 = {:.4}", self.alpha_counts_m2);
        let sigma = self.alpha_sigma_counts_m2;
        let _ = writeln!(text, "alpha_sigma_counts_m2 = {sigma:.4}");
        text += "# Relative to alpha, sensors 0 to 7; 1 where the drives do not determine it.\n";
        let _ = writeln!(text, "gains = {}", list(&self.gains));
        text += "# Standard deviations of their logarithms.\n";
        let _ = writeln!(text, "gain_sigmas = {}", list(&self.gain_sigmas));
        let sources: Vec<String> = self.sources.iter().map(|it| quoted(it)).collect();
        let _ = writeln!(text, "sources = [{}]", sources.join(", "));
        text
    }
}

/// A string of TOML: that of JSON, which leaves one character as it is that TOML does not.
fn quoted(text: &str) -> String {
    let json = serde_json::Value::from(text).to_string();
    json.replace('\u{7f}', "\\u007f")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> GainFile {
        GainFile {
            alpha_counts_m2: 1.85,
            alpha_sigma_counts_m2: 0.06,
            gains: [1.1, 0.9, 1.0, 1.05, 0.95, 0.88, 1.0, 1.12],
            gain_sigmas: [0.02; SENSORS],
            sources: vec!["a \"b\"\n\u{1b}\u{7f}.txt".to_owned()],
        }
    }

    #[test]
    fn a_written_file_is_read_back_equal() {
        assert_eq!(GainFile::parse(&file().text(), "f").unwrap(), file());
    }

    #[test]
    fn a_malformed_file_is_refused_with_file_key_and_reason() {
        let text = file().text();
        for (from, to, said) in [
            (
                "alpha_counts_m2 = 1.85",
                "alpha_counts_m2 = -1.85",
                "f: alpha_counts_m2 is -1.85; legal is 0.001 to 100",
            ),
            ("[1.1000", "[5.0000", "f: gains[0] is 5; legal is 0.25 to 4"),
            ("[1.1000", "[nan", "f: gains[0] is NaN"),
            ("[0.0200", "[-1.0", "f: gain_sigmas[0] is -1"),
            ("[1.1000, ", "[", "gains"),
            ("gains =", "gain =", "unknown field"),
            (
                "alpha_sigma_counts_m2",
                "# ",
                "missing field `alpha_sigma_counts_m2`",
            ),
        ] {
            let error = GainFile::parse(&text.replacen(from, to, 1), "f")
                .unwrap_err()
                .to_string();
            assert!(error.contains(said), "{to}: {error}");
            assert!(error.starts_with("f: "), "{error}");
        }
        let missing = GainFile::load(Path::new("/nowhere/gains.toml")).unwrap_err();
        assert!(
            missing.to_string().starts_with("/nowhere/gains.toml: "),
            "{missing}"
        );
    }
}
