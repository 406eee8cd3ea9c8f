//! Numbers of command-line words: strict, and printed as they were read.

use std::time::Duration;

/// A probability from 0 to 1; neither NaN nor a sign.
pub(crate) fn probability(text: &str) -> Option<f64> {
    positive(text).filter(|rate| *rate <= 1.0)
}

/// A number that begins with a digit, finite.
pub(crate) fn positive(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    (text.starts_with(|first: char| first.is_ascii_digit()) && number.is_finite()).then_some(number)
}

/// Digits only.
pub(crate) fn whole(text: &str) -> Option<u64> {
    text.bytes()
        .all(|byte| byte.is_ascii_digit())
        .then(|| text.parse().ok())?
}

/// Digits after at most one sign.
pub(crate) fn signed(text: &str) -> Option<i32> {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    whole(digits)?;
    text.parse().ok()
}

/// A time of at most a day, as in `2s` or `50ms`.
pub(crate) fn time(text: &str) -> Option<Duration> {
    let (number, unit_s) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s')?, 1.0),
    };
    let seconds = positive(number)? * unit_s;
    // To the microsecond, so that a printed time is read back unchanged.
    (seconds <= 86_400.0).then(|| Duration::from_micros((seconds * 1e6).round() as u64))
}

/// A time as [`time`] reads it: milliseconds where they are whole and less than a second.
pub(crate) fn in_words(time: Duration) -> String {
    let micros = time.as_micros();
    if micros > 0 && micros < 1_000_000 && micros.is_multiple_of(1_000) {
        format!("{}ms", micros / 1_000)
    } else {
        format!("{}s", time.as_secs_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_printed_as_it_is_read() {
        for text in ["0s", "50ms", "1s", "1.5s", "86400s", "0.000001s", "999ms"] {
            assert_eq!(in_words(time(text).unwrap()), text);
        }
        for text in ["", "5", "s", "-1s", "+1s", "1e9s", "NaNs", "infs", " 1s"] {
            assert_eq!(time(text), None, "{text}");
        }
    }

    #[test]
    fn a_number_has_one_sign_at_most() {
        assert_eq!(signed("+200"), Some(200));
        assert_eq!(signed("-7"), Some(-7));
        for text in ["", "+", "+-3", "2.5", "1e3", "99999999999"] {
            assert_eq!(signed(text), None, "{text}");
        }
    }
}
