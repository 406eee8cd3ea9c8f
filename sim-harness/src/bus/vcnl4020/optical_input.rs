//! The light on the part, in counts.

use std::collections::VecDeque;

/// The light that the next measurements give.
#[derive(Clone, Debug, Default)]
pub(super) struct OpticalInput {
    signal: u16,
    coming: VecDeque<u16>,
    pub(super) ambient: u16,
}

impl OpticalInput {
    /// Sets the result of every proximity measurement from now on and clears the queue.
    pub(super) fn set_signal(&mut self, raw: u16) {
        self.coming.clear();
        self.signal = raw;
    }

    /// Sets the results of the next proximity measurements; the last one stays.
    pub(super) fn queue_signals(&mut self, raw: impl IntoIterator<Item = u16>) {
        self.coming.extend(raw);
    }

    /// The result of the next proximity measurement.
    pub(super) fn next_signal(&mut self) -> u16 {
        if let Some(signal) = self.coming.pop_front() {
            self.signal = signal;
        }
        self.signal
    }
}
