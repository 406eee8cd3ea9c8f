//! What falls on the part, in counts.

use std::collections::VecDeque;

/// What the sensor sees.
#[derive(Clone, Debug, Default)]
pub(super) struct OpticalInput {
    signal: u16,
    coming: VecDeque<u16>,
    pub(super) ambient: u16,
}

impl OpticalInput {
    /// Every proximity measurement gives this from now on; what was queued is forgotten.
    pub(super) fn set_signal(&mut self, raw: u16) {
        self.coming.clear();
        self.signal = raw;
    }

    /// One for each of the next proximity measurements; the last one stays.
    pub(super) fn queue_signals(&mut self, raw: impl IntoIterator<Item = u16>) {
        self.coming.extend(raw);
    }

    /// What the next proximity measurement gives.
    pub(super) fn next_signal(&mut self) -> u16 {
        if let Some(signal) = self.coming.pop_front() {
            self.signal = signal;
        }
        self.signal
    }
}
