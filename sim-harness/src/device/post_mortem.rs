//! The text about the end of a board's last boot.

use amiro_ipf::board::supervision::PostMortem;

use crate::escape::whole_escaped;

/// How a boot ended, in one line; text from the board is escaped.
#[must_use]
pub fn post_mortem_in_words(record: &PostMortem) -> String {
    let age_s = f64::from(record.uptime_ms) * 1e-3;
    let place = if record.place.is_empty() {
        format!("{:#010x}", record.registers.pc)
    } else {
        let file = whole_escaped(record.place.chars());
        format!("{file}:{}", record.line)
    };
    format!(
        "the board had ended by itself after {age_s:.1} s: {:?} at {place}, step {}",
        record.cause, record.step
    )
}

#[cfg(test)]
mod tests {
    use amiro_ipf::board::supervision::FailureCause;

    use super::*;

    #[test]
    fn a_place_that_is_none_does_nothing_to_the_terminal() {
        let record = PostMortem::new(FailureCause::Panic, 3, 1_500);
        let hostile = record.clone().at("\x1b[2J\r\nall is well", 77);
        let words = post_mortem_in_words(&hostile);
        assert!(!words.chars().any(char::is_control), "{words:?}");
        assert!(words.ends_with("all is well:77, step 3"), "{words}");
        let words = post_mortem_in_words(&record);
        assert!(
            words.ends_with("1.5 s: Panic at 0x00000000, step 3"),
            "{words}"
        );
    }
}
