//! Memory that a reset retains: the post-mortem record, the boot history, the boot count.

use core::sync::atomic::{AtomicU32, Ordering};

use amiro_ipf::board::supervision::{
    BootHistory, FailureCause, HISTORY_WORDS, PostMortem, RECORD_WORDS,
};

/// Memory that a reset does not change; its contents are random after power-on.
struct Retained {
    record: [AtomicU32; RECORD_WORDS],
    history: [AtomicU32; HISTORY_WORDS],
    boots: AtomicU32,
    steps: AtomicU32,
}

#[expect(
    unsafe_code,
    reason = "only a section keeps memory from the start code"
)]
// SAFETY: the section exists in cortex-m-rt's linker script, and every bit pattern that
// it may hold after power-on is a valid value; checksums distinguish what was written.
#[unsafe(link_section = ".uninit.RETAINED")]
static RETAINED: Retained = Retained {
    record: [const { AtomicU32::new(0) }; RECORD_WORDS],
    history: [const { AtomicU32::new(0) }; HISTORY_WORDS],
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
    RETAINED.boots.fetch_add(1, Ordering::Relaxed)
}

/// Records how far the present boot has come.
pub(crate) fn record_uptime(uptime_ms: u64, steps: u32) {
    let Some(mut history) = BootHistory::from_words(read(&RETAINED.history)) else {
        return;
    };
    history.record_uptime(u32::try_from(uptime_ms).unwrap_or(u32::MAX));
    write(&RETAINED.history, &history.to_words());
    RETAINED.steps.store(steps, Ordering::Relaxed);
}

/// A record of the present boot's failure, without place and registers.
pub(crate) fn record_of(cause: FailureCause) -> PostMortem {
    let uptime_ms =
        BootHistory::from_words(read(&RETAINED.history)).map_or(0, |history| history.uptime_ms());
    PostMortem::new(cause, RETAINED.steps.load(Ordering::Relaxed), uptime_ms)
}

/// Keeps a record for the next boot.
pub(crate) fn keep(record: &PostMortem) {
    write(&RETAINED.record, &record.to_words());
}

/// Begins a boot: how the last one failed, if it did, and whether boots fail in a loop.
pub(super) fn begin(was_watchdog: bool, may_have_failed: bool) -> (Option<PostMortem>, bool) {
    let mut record = PostMortem::from_words(&read(&RETAINED.record));
    if record.is_none() && was_watchdog {
        record = Some(record_of(FailureCause::Watchdog));
    }
    // Reported once.
    write(&RETAINED.record, &[0; RECORD_WORDS]);
    let failed = may_have_failed && record.is_some();
    let history = BootHistory::begin(read(&RETAINED.history), failed);
    write(&RETAINED.history, &history.to_words());
    (record.filter(|_| may_have_failed), history.is_loop())
}
