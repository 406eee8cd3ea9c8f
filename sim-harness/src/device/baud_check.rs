//! Detects a wrong baud rate: most bytes are no frames.

use std::time::{Duration, Instant};

/// Time after which a line is judged.
const WATCHED: Duration = Duration::from_secs(2);

/// Fewer bytes than two frames' are no evidence: a frame may be cut or damaged.
const FEWEST: u64 = 256;

/// Counts the received bytes that are no frames.
#[derive(Clone, Debug, Default)]
pub(super) struct BaudCheck {
    since: Option<Instant>,
    good: u64,
    noise: u64,
    is_noise: bool,
    was_reported: bool,
}

impl BaudCheck {
    /// Counts bytes of a frame, or of no frame.
    pub(super) fn take(&mut self, bytes: u64, is_frame: bool, now: Instant) {
        let since = *self.since.get_or_insert(now);
        if is_frame {
            self.good += bytes;
        } else {
            self.noise += bytes;
        }
        if now.saturating_duration_since(since) < WATCHED {
            return;
        }
        self.is_noise = self.noise > self.good && self.noise >= FEWEST;
        (self.since, self.good, self.noise) = (Some(now), 0, 0);
    }

    /// Whether more than half of the bytes of two seconds were no frames; `true` once.
    pub(super) fn take_warning(&mut self) -> bool {
        let is_new = self.is_noise && !self.was_reported;
        self.was_reported |= is_new;
        is_new
    }

    /// The same for the last two seconds or the bytes since then.
    pub(super) fn is_mostly_noise(&self) -> bool {
        self.is_noise || (self.noise > self.good && self.noise >= FEWEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_half_noise_for_two_seconds_is_reported_once_and_less_is_not() {
        for (good, noise, is_noise) in [(50, 51, true), (51, 50, false), (0, 12, false)] {
            let start = Instant::now();
            let mut watch = BaudCheck::default();
            for tenth in 0..20 {
                let now = start + Duration::from_millis(100 * tenth);
                watch.take(good, true, now);
                watch.take(noise, false, now);
                assert!(!watch.take_warning(), "{tenth}");
            }
            watch.take(0, true, start + WATCHED);
            assert_eq!(watch.take_warning(), is_noise, "{good} good, {noise} junk");
            assert!(!watch.take_warning());
        }
    }

    #[test]
    fn lasting_noise_is_reported_once() {
        let start = Instant::now();
        let mut watch = BaudCheck::default();
        let verdicts = (0..100).filter(|tenth| {
            watch.take(100, false, start + Duration::from_millis(100 * tenth));
            watch.take_warning()
        });
        assert_eq!(verdicts.count(), 1);
        assert!(watch.is_mostly_noise());
    }
}
