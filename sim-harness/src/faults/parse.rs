//! A strict parser of faults: a typing error is refused, not guessed at.

use std::str::FromStr;

use super::{Component, Fault, FaultError, Faults, Kind, Window, line_words};

const NO_PART: &str = "names no part that can fail: s0 to s7, ring, bus1, bus2, mux1, mux2, can \
                       or link, as in s3=stuck@5s..8s";
const NO_WINDOW: &str = "has no window that begins before it ends, as in @5s, @5s..8s or @..8s";
const LINK_TWICE: &str = "names the link again: join its words, as in link=ber:1e-3+off@2s..5s";

impl FromStr for Faults {
    type Err = FaultError;

    /// Faults separated by commas, with optional blanks; `ok` for none.
    fn from_str(text: &str) -> Result<Self, FaultError> {
        let mut faults = Self::default();
        if text.trim() == "ok" {
            return Ok(faults);
        }
        let mut names_link = false;
        let mut begins = 0;
        for piece in text.split(',') {
            let entry = piece.trim();
            let blanks = piece.len() - piece.trim_start().len();
            let before = text.get(..begins + blanks).unwrap_or_default();
            let place = 1 + before.chars().count();
            begins += piece.len() + 1;
            let wrong = |problem: &str| FaultError::new(entry, place, problem);
            let (name, words) = entry.split_once('=').ok_or_else(|| wrong(NO_PART))?;
            let component = Component::parse(name).ok_or_else(|| wrong(NO_PART))?;
            if component == Component::Link {
                if std::mem::replace(&mut names_link, true) {
                    return Err(wrong(LINK_TWICE));
                }
                let why = |error| wrong(&format!("is no line: {error}"));
                faults.line = line_words::parse(words).map_err(why)?;
                continue;
            }
            let (word, window) = match words.split_once('@') {
                None => (words, None),
                Some((word, window)) => (word, Some(window)),
            };
            let window = match window {
                None => Window::Always,
                Some(window) => Window::parse(component, window).ok_or_else(|| wrong(NO_WINDOW))?,
            };
            faults.parts.push(Fault {
                component,
                kind: Kind::parse(component, word).map_err(|problem| wrong(&problem))?,
                window,
            });
        }
        Ok(faults)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_printed_as_it_was() {
        for text in [
            "ok",
            "s3=stuck@5s..8s, can=off@10s, link=ber:0.001",
            "ring=off, s3=ok",
            "s0=wrong:+200@..8s, s0=wrong:-1@9s",
            "can=wrong:-300mm@500ms, can=slow:0.5Hz, can=delayed:50ms",
            "bus1=stuck, bus2=garbage, mux1=intermittent:0.3, mux2=off@1.5s",
            "s7=saturated, s6=slow:20Hz, s5=delayed:1s, s4=intermittent:1",
            "link=off@2s..5s+drop:0.1x9",
        ] {
            let faults: Faults = text.parse().unwrap();
            assert_eq!(faults.to_string(), text);
        }
        // Blanks, and other ways to write a number.
        let faults: Faults = " s3=wrong:5@0s ,link=ok ".parse().unwrap();
        assert_eq!(faults.to_string(), "s3=wrong:+5");
        assert_eq!("link=ok".parse(), Ok(Faults::default()));
    }
}
