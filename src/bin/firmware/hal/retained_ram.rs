//! What survives a reset: the record of a death, the lives before, the count of boots.

use core::sync::atomic::{AtomicU32, Ordering};

use amiro_ipf::board::supervision::{Cause, LIVES, Lives, PostMortem, WORDS};

/// Memory that a reset leaves alone; after power-on it holds anything.
struct Kept {
    record: [AtomicU32; WORDS],
    lives: [AtomicU32; LIVES + 3],
    boots: AtomicU32,
    steps: AtomicU32,
}

#[expect(
    unsafe_code,
    reason = "only a section keeps memory from the start code"
)]
// SAFETY: the section exists in cortex-m-rt's linker script, and every bit pattern that
// it may hold after power-on is a valid value; those that were not written are told
// from those that were by their checksums.
#[unsafe(link_section = ".uninit.KEPT")]
static KEPT: Kept = Kept {
    record: [const { AtomicU32::new(0) }; WORDS],
    lives: [const { AtomicU32::new(0) }; LIVES + 3],
    boots: AtomicU32::new(0),
    steps: AtomicU32::new(0),
};

fn write(kept: &[AtomicU32], words: &[u32]) {
    for (place, word) in kept.iter().zip(words) {
        place.store(*word, Ordering::Relaxed);
    }
}

fn read<const N: usize>(kept: &[AtomicU32; N]) -> [u32; N] {
    let mut words = [0; N];
    for (word, place) in words.iter_mut().zip(kept) {
        *word = place.load(Ordering::Relaxed);
    }
    words
}

/// Counts a boot; the number of those before.
pub(super) fn count_boot() -> u32 {
    KEPT.boots.fetch_add(1, Ordering::Relaxed)
}

/// The present life has come so far.
pub(crate) fn live_on(uptime_ms: u64, steps: u32) {
    let Some(mut lives) = Lives::from_words(read(&KEPT.lives)) else {
        return;
    };
    lives.live_on(u32::try_from(uptime_ms).unwrap_or(u32::MAX));
    write(&KEPT.lives, &lives.to_words());
    KEPT.steps.store(steps, Ordering::Relaxed);
}

/// A record of the present life's end, its place and registers still to be filled.
pub(crate) fn record_of(cause: Cause) -> PostMortem {
    let alive_ms = Lives::from_words(read(&KEPT.lives)).map_or(0, |lives| lives.alive_ms());
    PostMortem::new(cause, KEPT.steps.load(Ordering::Relaxed), alive_ms)
}

/// Keeps a record for the next life.
pub(crate) fn keep(record: &PostMortem) {
    write(&KEPT.record, &record.to_words());
}

/// Begins a life: how the last one ended, if it ended by itself, and whether it is one
/// of a loop.
pub(super) fn begin(was_watchdog: bool, may_have_died: bool) -> (Option<PostMortem>, bool) {
    let mut record = PostMortem::from_words(&read(&KEPT.record));
    if record.is_none() && was_watchdog {
        record = Some(record_of(Cause::Watchdog));
    }
    // Said once.
    write(&KEPT.record, &[0; WORDS]);
    let died = may_have_died && record.is_some();
    let lives = Lives::begin(read(&KEPT.lives), died);
    write(&KEPT.lives, &lives.to_words());
    (record.filter(|_| may_have_died), lives.is_loop())
}
