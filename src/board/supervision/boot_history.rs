//! How long the last boots ran: detects a loop of resets.

/// Boots that are kept.
pub const KEPT_BOOTS: usize = 3;

/// Three failed boots that together ran shorter than this are a loop, milliseconds.
pub const SHORT_MS: u32 = 10_000;

/// Words that hold a history.
pub const HISTORY_WORDS: usize = KEPT_BOOTS + 3;

/// Marks memory that holds a history: "live" in ASCII.
const MAGIC: u32 = 0x6c69_7665;

/// No such boot, or one that did not fail.
const NONE: u32 = u32::MAX;

/// The uptimes at which the last boots failed, and that of the present one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootHistory {
    failed_ms: [u32; KEPT_BOOTS],
    uptime_ms: u32,
}

impl BootHistory {
    /// No boot before this one.
    pub const FIRST: Self = Self {
        failed_ms: [NONE; KEPT_BOOTS],
        uptime_ms: 0,
    };

    /// The history of a new boot, from the words that the last one left.
    ///
    /// `failed` says that the last boot ended by a panic, a fault or the watchdog. After
    /// power-on, the reset pin, or words that hold no history, the history is empty.
    #[must_use]
    pub fn begin(words: [u32; HISTORY_WORDS], failed: bool) -> Self {
        match Self::from_words(words) {
            Some(before) if failed => {
                let [_, second, third] = before.failed_ms;
                Self {
                    failed_ms: [second, third, before.uptime_ms],
                    uptime_ms: 0,
                }
            }
            _ => Self::FIRST,
        }
    }

    /// Records the present boot's uptime.
    pub fn record_uptime(&mut self, uptime_ms: u32) {
        self.uptime_ms = uptime_ms.min(NONE - 1);
    }

    /// The recorded uptime of the present boot; of words left by the last boot, its own.
    #[must_use]
    pub const fn uptime_ms(&self) -> u32 {
        self.uptime_ms
    }

    /// Whether the last three boots failed within [`SHORT_MS`] in all.
    #[must_use]
    pub fn is_loop(&self) -> bool {
        self.failed_ms
            .iter()
            .try_fold(0_u32, |sum, &uptime_ms| sum.checked_add(uptime_ms))
            .is_some_and(|sum| sum < SHORT_MS)
    }

    /// As words for memory that a reset leaves alone.
    #[must_use]
    pub fn to_words(&self) -> [u32; HISTORY_WORDS] {
        let [first, second, third] = self.failed_ms;
        let uptime = self.uptime_ms;
        let sum = first ^ second ^ third ^ uptime ^ !MAGIC;
        [MAGIC, first, second, third, uptime, sum]
    }

    /// The history in some words; `None` if they hold none.
    #[must_use]
    pub fn from_words(
        [magic, first, second, third, uptime, sum]: [u32; HISTORY_WORDS],
    ) -> Option<Self> {
        let is_whole = magic == MAGIC && sum == first ^ second ^ third ^ uptime ^ !MAGIC;
        is_whole.then_some(Self {
            failed_ms: [first, second, third],
            uptime_ms: uptime,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A boot after boots of these uptimes that all failed.
    fn after(uptimes_ms: &[u32]) -> BootHistory {
        let mut words = [0xa5a5_a5a5; HISTORY_WORDS];
        let mut history = BootHistory::begin(words, true);
        for &uptime_ms in uptimes_ms {
            history.record_uptime(uptime_ms);
            words = history.to_words();
            history = BootHistory::begin(words, true);
        }
        history
    }

    #[test]
    fn f58_the_third_failed_boot_in_ten_seconds_is_a_loop() {
        for (uptimes_ms, is_loop) in [
            (&[][..], false),
            (&[300, 300], false),
            (&[300, 300, 300], true),
            (&[300, 300, 9_400], false),
            (&[60_000, 300, 300, 9_399], true),
            (&[300, 60_000, 300], false),
            (&[u32::MAX, 300, 300], false),
        ] {
            assert_eq!(after(uptimes_ms).is_loop(), is_loop, "{uptimes_ms:?}");
        }
    }

    #[test]
    fn f58_the_uptime_of_a_boot_is_read_from_the_words_it_left() {
        let mut history = after(&[1, 2, 3]);
        assert_eq!(history.uptime_ms(), 0);
        history.record_uptime(4_321);
        let read = BootHistory::from_words(history.to_words());
        assert_eq!(read, Some(history));
        assert_eq!(read.map(|history| history.uptime_ms()), Some(4_321));
        history.record_uptime(u32::MAX);
        assert_ne!(history.uptime_ms(), NONE, "the longest uptime is a boot");
    }

    #[test]
    fn f58_power_and_the_reset_pin_empty_the_history() {
        let history = after(&[300, 300, 300]);
        let begun = BootHistory::begin(history.to_words(), false);
        assert_eq!(begun, BootHistory::FIRST);
        assert!(!BootHistory::FIRST.is_loop());
    }

    #[test]
    fn memory_that_was_never_written_holds_no_history() {
        for word in [0, u32::MAX, 0xa5a5_a5a5] {
            assert_eq!(BootHistory::from_words([word; HISTORY_WORDS]), None);
        }
        let words = after(&[5]).to_words();
        for word in 0..words.len() {
            for bit in 0..32 {
                let mut damaged = words;
                damaged[word] ^= 1 << bit;
                assert_eq!(BootHistory::from_words(damaged), None, "{word}, {bit}");
            }
        }
    }
}
