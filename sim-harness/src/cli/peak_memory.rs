//! The memory that a part of the program takes at most.

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Counts from here on.
#[derive(Debug)]
pub(super) struct PeakMemory {
    before_bytes: usize,
}

impl PeakMemory {
    /// Forgets the peak so far.
    pub(super) fn start() -> Self {
        ALLOCATOR.reset_peak_usage();
        Self {
            before_bytes: ALLOCATOR.current_usage(),
        }
    }

    /// Most bytes on the heap since the start, above those that were there then.
    pub(super) fn bytes(&self) -> u64 {
        ALLOCATOR.peak_usage().saturating_sub(self.before_bytes) as u64
    }
}
