//! The words of the serial line: `ber:1e-3+off@2s..5s`.

use super::{Component, Fault, Kind, Window};
use crate::quantity::{probability, time, whole};

/// Longest burst of dropped bytes, or of garbage.
const LONGEST_BURST: u32 = 1_000_000;

/// Bytes of a burst of garbage by default.
const GARBAGE_BYTES: u32 = 64;

const UNKNOWN: &str = "is nothing that can be wrong with a line: ok, off, ber:R, drop:R, \
                       garbage:R, lose:R, twice:R, swap:R, cut:R, delay:TIME or slow:N, \
                       each with @FROM or @FROM..TO or without";
const NO_RATE: &str = "needs a probability from 0 to 1, as in ber:1e-3";
const NO_BURST: &str = "needs a probability and up to 1000000 bytes, as in drop:1e-4x300";
const NO_TIME: &str = "needs a time of at most a day, as in 2s or 50ms";
const NO_SPEED: &str = "needs bytes a second, at least 1, as in slow:9600";
const NO_VALUE: &str = "takes no value";
const NO_WINDOW: &str = "has no window that begins before it ends, as in @2s..5s or @100B..200B";

/// Reads words joined by `+`, each with a window or without; `ok` for none.
///
/// # Errors
/// The invalid word, in quotes, and the reason.
pub(super) fn parse(text: &str) -> Result<Vec<Fault>, String> {
    if text == "ok" {
        return Ok(Vec::new());
    }
    let fault = |word| fault(word).map_err(|problem| format!("\"{word}\" {problem}"));
    text.split('+').map(fault).collect()
}

/// A word: kind, value, window.
fn fault(word: &str) -> Result<Fault, &'static str> {
    let (what, window) = match word.split_once('@') {
        None => (word, Window::Always),
        Some((what, window)) => {
            let window = Window::parse(Component::Link, window);
            (what, window.ok_or(NO_WINDOW)?)
        }
    };
    let kind = kind(what)?;
    let component = Component::Link;
    Ok(Fault {
        component,
        kind,
        window,
    })
}

fn kind(what: &str) -> Result<Kind, &'static str> {
    let (name, value) = match what.split_once(':') {
        None => (what, None),
        Some((name, value)) => (name, Some(value)),
    };
    let given = value.unwrap_or_default();
    let rate = || probability(given).ok_or(NO_RATE);
    let burst = |most| burst(given, most).ok_or(NO_BURST);
    Ok(match name {
        "ber" => Kind::BitErrors(rate()?),
        "lose" => Kind::Lost(rate()?),
        "twice" => Kind::Twice(rate()?),
        "swap" => Kind::Swapped(rate()?),
        "cut" => Kind::Cut(rate()?),
        "drop" => {
            let (rate, most) = burst(1)?;
            Kind::Dropped { rate, most }
        }
        "garbage" => {
            let (rate, most) = burst(GARBAGE_BYTES)?;
            Kind::GarbageBytes { rate, most }
        }
        "delay" => Kind::Delayed(time(given).ok_or(NO_TIME)?),
        "slow" => match whole(given) {
            Some(speed @ 1..=0xffff_ffff) => Kind::BytesPerSecond(speed as u32),
            _ => return Err(NO_SPEED),
        },
        "off" if value.is_some() => return Err(NO_VALUE),
        "off" => Kind::Off,
        _ => return Err(UNKNOWN),
    })
}

fn burst(text: &str, most: u32) -> Option<(f64, u32)> {
    let (rate, most) = match text.split_once('x') {
        None => (text, u64::from(most)),
        Some((rate, most)) => (rate, whole(most)?),
    };
    let is_legal = (1..=u64::from(LONGEST_BURST)).contains(&most);
    Some((probability(rate)?, is_legal.then_some(most as u32)?))
}

/// The word of a kind as it is read.
pub(super) fn in_words(kind: Kind) -> String {
    match kind {
        Kind::BitErrors(rate) => format!("ber:{rate}"),
        Kind::Dropped { rate, most: 1 } => format!("drop:{rate}"),
        Kind::Dropped { rate, most } => format!("drop:{rate}x{most}"),
        Kind::GarbageBytes { rate, most } => format!("garbage:{rate}x{most}"),
        Kind::Lost(rate) => format!("lose:{rate}"),
        Kind::Twice(rate) => format!("twice:{rate}"),
        Kind::Swapped(rate) => format!("swap:{rate}"),
        Kind::Cut(rate) => format!("cut:{rate}"),
        Kind::Delayed(time) => format!("delay:{}s", time.as_secs_f64()),
        Kind::BytesPerSecond(speed) => format!("slow:{speed}"),
        Kind::Off => "off".to_owned(),
        _ => "ok".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_printed_and_read_again_as_it_was() {
        for (text, printed) in [
            ("ok", "ok"),
            ("ber:1e-3", "ber:0.001"),
            ("drop:1e-4", "drop:0.0001"),
            ("drop:1e-4x300@2s..5s", "drop:0.0001x300@2s..5s"),
            ("garbage:0.5", "garbage:0.5x64"),
            ("off@2s..5s", "off@2s..5s"),
            ("off@500ms", "off@0.5s"),
            ("off@..8s", "off@0s..8s"),
            ("off@10B..20B+off@90B", "off@10B..20B+off@90B"),
            ("slow:9600+delay:20ms", "slow:9600+delay:0.02s"),
            (
                "lose:0.1+twice:0.2+swap:0.3+cut:0.4",
                "lose:0.1+twice:0.2+swap:0.3+cut:0.4",
            ),
        ] {
            let faults = parse(text).unwrap();
            let words: Vec<String> = faults.iter().map(Fault::to_string).collect();
            let words = if words.is_empty() {
                "ok".to_owned()
            } else {
                words.join("+")
            };
            assert_eq!(words, printed);
            assert_eq!(parse(printed), Ok(faults), "{text}");
        }
    }

    #[test]
    fn a_word_that_is_wrong_is_named() {
        for (text, word) in [
            ("", ""),
            ("bear:1e-3", "bear:1e-3"),
            ("ber", "ber"),
            ("ber:", "ber:"),
            ("ber:1.5", "ber:1.5"),
            ("ber:-0.1", "ber:-0.1"),
            ("ber:NaN", "ber:NaN"),
            ("ber:1e-3 ", "ber:1e-3 "),
            ("ber:1e-3+", ""),
            ("ber:1e-3+drop:0.1x0", "drop:0.1x0"),
            ("drop:0.1x1000001", "drop:0.1x1000001"),
            ("slow:0", "slow:0"),
            ("slow:+5", "slow:"),
            ("off:1", "off:1"),
            ("off@5s..2s", "off@5s..2s"),
            ("off@2s..5", "off@2s..5"),
            ("off@2s..50B", "off@2s..50B"),
            ("off@..", "off@.."),
            ("delay:1h", "delay:1h"),
            ("delay:1e9s", "delay:1e9s"),
            ("ok+off", "ok"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(&format!("\"{word}\" ")), "{error}");
        }
    }
}
