//! Text of unknown origin, made safe to print.

/// Most characters of a text that are shown.
const MOST_CHARACTERS: usize = 48;

/// The text with control characters escaped, cut after 48 characters.
///
/// Quotes stay as they are; a backslash is doubled, so that the result is unambiguous.
pub(crate) fn escaped(text: &str) -> String {
    let mut shown = whole_escaped(text.chars().take(MOST_CHARACTERS));
    if text.chars().nth(MOST_CHARACTERS).is_some() {
        shown.push_str("...");
    }
    shown
}

/// All characters, escaped likewise: for paths.
pub(crate) fn whole_escaped(characters: impl Iterator<Item = char>) -> String {
    let mut shown = String::new();
    for character in characters {
        match character {
            '\'' | '"' => shown.push(character),
            other => shown.extend(other.escape_debug()),
        }
    }
    shown
}

/// Text of several lines; line ends and backslashes stay as they are.
pub(crate) fn lines_escaped(text: &str) -> String {
    let mut shown = String::new();
    for character in text.chars() {
        match character {
            '\n' | '\\' | '\'' | '"' => shown.push(character),
            other => shown.extend(other.escape_debug()),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_escapes_and_text_direction_are_made_visible() {
        assert_eq!(
            escaped("\x1b[2Jit's \u{202e}x\t\\"),
            "\\u{1b}[2Jit's \\u{202e}x\\t\\\\"
        );
    }

    #[test]
    fn lines_stay_lines() {
        assert_eq!(lines_escaped("a\\b\n\x1b'c'"), "a\\b\n\\u{1b}'c'");
    }

    #[test]
    fn long_text_is_cut_and_shows_that_it_is() {
        assert_eq!(escaped(&"a".repeat(48)), "a".repeat(48));
        assert_eq!(escaped(&"a".repeat(1000)), "a".repeat(48) + "...");
    }
}
