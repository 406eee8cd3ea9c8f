//! How long the last lives were: whether the image dies again and again.

/// Lives that are looked back on.
pub const LIVES: usize = 3;

/// Three lives that together are shorter than this are a loop of resets, milliseconds.
pub const SHORT_MS: u32 = 10_000;

/// Marks memory that holds lives: "live" in ASCII.
const MAGIC: u32 = 0x6c69_7665;

/// No such life, or one that ended as it should.
const NONE: u32 = u32::MAX;

/// The ages at which the last lives ended by themselves, and that of the present one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lives {
    ended_ms: [u32; LIVES],
    alive_ms: u32,
}

impl Lives {
    /// No life before this one.
    pub const FIRST: Self = Self {
        ended_ms: [NONE; LIVES],
        alive_ms: 0,
    };

    /// The lives of a new start, from the words that the last one left behind.
    ///
    /// `died` says that it ended by itself: by a panic, a fault or the watchdog. After
    /// power or the reset pin, and after memory that nobody wrote, nothing is held
    /// against the image.
    #[must_use]
    pub fn begin(words: [u32; LIVES + 3], died: bool) -> Self {
        match Self::from_words(words) {
            Some(before) if died => {
                let [_, second, third] = before.ended_ms;
                Self {
                    ended_ms: [second, third, before.alive_ms],
                    alive_ms: 0,
                }
            }
            _ => Self::FIRST,
        }
    }

    /// The present life is so old now.
    pub fn live_on(&mut self, alive_ms: u32) {
        self.alive_ms = alive_ms.min(NONE - 1);
    }

    /// How old the present life is, or, read from the last one's words, became.
    #[must_use]
    pub const fn alive_ms(&self) -> u32 {
        self.alive_ms
    }

    /// Whether the last three lives ended by themselves within [`SHORT_MS`].
    #[must_use]
    pub fn is_loop(&self) -> bool {
        self.ended_ms
            .iter()
            .try_fold(0_u32, |sum, &age_ms| sum.checked_add(age_ms))
            .is_some_and(|sum| sum < SHORT_MS)
    }

    /// As words for memory that a reset leaves alone.
    #[must_use]
    pub fn to_words(&self) -> [u32; LIVES + 3] {
        let [first, second, third] = self.ended_ms;
        let alive = self.alive_ms;
        let sum = first ^ second ^ third ^ alive ^ !MAGIC;
        [MAGIC, first, second, third, alive, sum]
    }

    /// The lives in some words, if they hold any.
    #[must_use]
    pub fn from_words([magic, first, second, third, alive, sum]: [u32; LIVES + 3]) -> Option<Self> {
        let is_whole = magic == MAGIC && sum == first ^ second ^ third ^ alive ^ !MAGIC;
        is_whole.then_some(Self {
            ended_ms: [first, second, third],
            alive_ms: alive,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A start after lives of these ages that all ended by themselves.
    fn after(ages_ms: &[u32]) -> Lives {
        let mut words = [0xa5a5_a5a5; LIVES + 3];
        let mut lives = Lives::begin(words, true);
        for &age_ms in ages_ms {
            lives.live_on(age_ms);
            words = lives.to_words();
            lives = Lives::begin(words, true);
        }
        lives
    }

    #[test]
    fn f58_the_third_death_in_ten_seconds_is_a_loop() {
        assert!(!after(&[]).is_loop());
        assert!(!after(&[300, 300]).is_loop());
        assert!(after(&[300, 300, 300]).is_loop());
        assert!(!after(&[300, 300, 9_400]).is_loop());
        assert!(after(&[60_000, 300, 300, 9_399]).is_loop());
        assert!(!after(&[300, 60_000, 300]).is_loop());
        assert!(!after(&[u32::MAX, 300, 300]).is_loop());
    }

    #[test]
    fn f58_what_a_life_became_is_read_from_the_words_it_left() {
        let mut lives = after(&[1, 2, 3]);
        assert_eq!(lives.alive_ms(), 0, "a life begins");
        lives.live_on(4_321);
        let read = Lives::from_words(lives.to_words());
        assert_eq!(read, Some(lives));
        assert_eq!(read.map(|lives| lives.alive_ms()), Some(4_321));
        lives.live_on(u32::MAX);
        assert_ne!(lives.alive_ms(), NONE, "however old, it was a life");
    }

    #[test]
    fn f58_power_and_the_reset_pin_begin_anew() {
        let lives = after(&[300, 300, 300]);
        assert_eq!(Lives::begin(lives.to_words(), false), Lives::FIRST);
        assert!(!Lives::FIRST.is_loop());
    }

    #[test]
    fn memory_that_nobody_wrote_holds_no_lives() {
        for word in [0, u32::MAX, 0xa5a5_a5a5] {
            assert_eq!(Lives::from_words([word; LIVES + 3]), None);
        }
        let words = after(&[5]).to_words();
        for word in 0..words.len() {
            for bit in 0..32 {
                let mut damaged = words;
                damaged[word] ^= 1 << bit;
                assert_eq!(Lives::from_words(damaged), None, "{word}, {bit}");
            }
        }
    }
}
