//! The memory that a part of the program takes at most.

use peak_alloc::PeakAlloc;

/// Counts from its making on, in a program whose global allocator is [`PeakAlloc`]; in any
/// other it counts nothing.
#[derive(Debug)]
pub(super) struct PeakMemory {
    before_bytes: usize,
}

impl PeakMemory {
    /// Forgets the peak so far.
    pub(super) fn start() -> Self {
        PeakAlloc.reset_peak_usage();
        Self {
            before_bytes: PeakAlloc.current_usage(),
        }
    }

    /// Most bytes on the heap since the start, above those that were there then.
    pub(super) fn bytes(&self) -> u64 {
        PeakAlloc.peak_usage().saturating_sub(self.before_bytes) as u64
    }
}
