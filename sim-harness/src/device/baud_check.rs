//! Bytes that are no frames: what a wrong baud rate looks like.

use std::time::{Duration, Instant};

/// How long a line is watched before it is judged.
const WATCHED: Duration = Duration::from_secs(2);

/// Fewer bytes than two frames' are no evidence: a frame may be cut or damaged.
const FEWEST: u64 = 256;

/// Watches how much of what comes is no frame.
#[derive(Clone, Debug, Default)]
pub(super) struct BaudCheck {
    since: Option<Instant>,
    good: u64,
    junk: u64,
    is_junk: bool,
    was_reported: bool,
}

impl BaudCheck {
    /// Takes so many bytes of a frame, or of none.
    pub(super) fn take(&mut self, bytes: u64, is_frame: bool, now: Instant) {
        let since = *self.since.get_or_insert(now);
        if is_frame {
            self.good += bytes;
        } else {
            self.junk += bytes;
        }
        if now.saturating_duration_since(since) < WATCHED {
            return;
        }
        self.is_junk = self.junk > self.good && self.junk >= FEWEST;
        (self.since, self.good, self.junk) = (Some(now), 0, 0);
    }

    /// Whether more than half of the bytes of two seconds were no frames; `true` once.
    pub(super) fn take_verdict(&mut self) -> bool {
        let is_news = self.is_junk && !self.was_reported;
        self.was_reported |= is_news;
        is_news
    }

    /// Whether that is so of the last two seconds or of the bytes since then.
    pub(super) fn is_mostly_junk(&self) -> bool {
        self.is_junk || (self.junk > self.good && self.junk >= FEWEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_half_junk_for_two_seconds_is_said_once_and_less_is_not() {
        for (good, junk, is_junk) in [(50, 51, true), (51, 50, false), (0, 12, false)] {
            let start = Instant::now();
            let mut watch = BaudCheck::default();
            for tenth in 0..20 {
                let now = start + Duration::from_millis(100 * tenth);
                watch.take(good, true, now);
                watch.take(junk, false, now);
                assert!(!watch.take_verdict(), "{tenth}");
            }
            watch.take(0, true, start + WATCHED);
            assert_eq!(watch.take_verdict(), is_junk, "{good} good, {junk} junk");
            assert!(!watch.take_verdict());
        }
    }

    #[test]
    fn junk_that_goes_on_is_said_once() {
        let start = Instant::now();
        let mut watch = BaudCheck::default();
        let verdicts = (0..100).filter(|tenth| {
            watch.take(100, false, start + Duration::from_millis(100 * tenth));
            watch.take_verdict()
        });
        assert_eq!(verdicts.count(), 1);
        assert!(watch.is_mostly_junk());
    }
}
