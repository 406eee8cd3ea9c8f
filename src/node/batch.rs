//! Batches of particle events.

use super::{Event, ParticleEvent, Particles};
use crate::filter::Outcome;

/// Collects particle events and emits them in batches of one frame.
pub(super) struct Batch<'e, E: FnMut(&Event)> {
    event: Event,
    emit: &'e mut E,
}

impl<'e, E: FnMut(&Event)> Batch<'e, E> {
    pub(super) fn new(index: u32, emit: &'e mut E) -> Self {
        let [step, ..] = index.to_le_bytes();
        let particles = Particles {
            step,
            outcomes: heapless::Vec::new(),
        };
        Self {
            event: Event::Particles(particles),
            emit,
        }
    }

    #[inline]
    pub(super) fn push(&mut self, position: (i16, i16), outcome: Outcome) {
        let Event::Particles(particles) = &mut self.event else {
            return;
        };
        // A full batch is flushed at once, so the push cannot be refused.
        let _ = particles
            .outcomes
            .push(ParticleEvent::new(position, outcome));
        if particles.outcomes.is_full() {
            self.flush();
        }
    }

    pub(super) fn flush(&mut self) {
        let Event::Particles(particles) = &self.event else {
            return;
        };
        if particles.outcomes.is_empty() {
            return;
        }
        (self.emit)(&self.event);
        if let Event::Particles(particles) = &mut self.event {
            particles.outcomes.clear();
        }
    }
}
