//! Bytes that are no frames: what a wrong baud rate looks like.

use std::time::{Duration, Instant};

/// How long a line is watched before it is judged.
const WATCHED: Duration = Duration::from_secs(2);

/// Fewer bytes than this say nothing.
const FEWEST: u64 = 64;

/// Watches how much of what comes is no frame.
#[derive(Clone, Debug, Default)]
pub(super) struct JunkWatch {
    since: Option<Instant>,
    good: u64,
    junk: u64,
    is_junk: bool,
}

impl JunkWatch {
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

    /// Whether more than half of the bytes of the last two seconds were no frames; says
    /// so once.
    pub(super) fn take_verdict(&mut self) -> bool {
        std::mem::take(&mut self.is_junk)
    }

    /// Whether that is so of the bytes since then, two seconds or not.
    pub(super) fn is_mostly_junk(&self) -> bool {
        self.junk > self.good && self.junk >= FEWEST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_half_junk_for_two_seconds_is_said_once_and_less_is_not() {
        for (good, junk, is_junk) in [(50, 51, true), (51, 50, false), (0, 1, false)] {
            let start = Instant::now();
            let mut watch = JunkWatch::default();
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
}
