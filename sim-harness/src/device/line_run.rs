//! A host's own run, sent over a simulated line to a mapper.

use std::time::Duration;

use crate::spool::Spool;

use amiro_ipf::link::{Decoder, Encoder, Message, MessageRef, Received};
use amiro_ipf::node::Event;

use super::{FaultInjector, FrameTally, InOrder, LineTally, LossStats};

/// Boot id of the frames that stand for a host's own node.
pub const HOST_NODE_BOOT_ID: u8 = 0;

/// Sends events over a line as a board would, and receives them as a host would.
///
/// Time on the line is the time of the steps' stamps, from the first one on.
#[derive(Clone, Debug)]
pub struct LineRun {
    encoder: Encoder,
    line: FaultInjector,
    receiver: Receiver,
    first_us: Option<u64>,
    now: Duration,
}

/// The other end of the line.
#[derive(Clone, Debug)]
struct Receiver {
    decoder: Decoder,
    loss_stats: LossStats,
    order: InOrder,
    bytes: Vec<u8>,
}

/// The result of a run on a line.
#[derive(Clone, Debug)]
pub struct LineOutcome {
    /// As counted by the host.
    pub frames: FrameTally,
    /// As counted by the line.
    pub line: LineTally,
    /// The bytes that arrived and were not [moved](LineRun::move_bytes).
    pub bytes: Vec<u8>,
}

impl LineRun {
    /// A run that begins on a line of its own.
    #[must_use]
    pub fn new(line: FaultInjector) -> Self {
        Self {
            encoder: Encoder::new(HOST_NODE_BOOT_ID),
            line,
            receiver: Receiver {
                decoder: Decoder::new(),
                loss_stats: LossStats::since_boot(HOST_NODE_BOOT_ID),
                order: InOrder::since_boot(HOST_NODE_BOOT_ID),
                bytes: Vec::new(),
            },
            first_us: None,
            now: Duration::ZERO,
        }
    }

    /// Sends an event; passes on those that have arrived by now.
    pub fn send(&mut self, event: &Event, on_event: &mut impl FnMut(&Event)) {
        if let Event::StepBegun(step) = event {
            let first_us = *self.first_us.get_or_insert(step.stamp_us);
            self.now = Duration::from_micros(step.stamp_us.saturating_sub(first_us));
        }
        let frame = self.encoder.encode(MessageRef::Event(event));
        self.line.send(frame, self.now);
        self.receiver.take(&self.line.receive(self.now), on_event);
    }

    /// Moves the bytes that have arrived so far to the end of a spool, so that memory is
    /// bounded for a run of any length.
    pub fn move_bytes(&mut self, spool: &mut Spool) {
        spool.write(&self.receiver.bytes);
        self.receiver.bytes.clear();
    }

    /// Waits for the bytes on the way and closes the loss statistics with the number of
    /// frames sent.
    pub fn finish(mut self, on_event: &mut impl FnMut(&Event)) -> LineOutcome {
        self.line.flush(self.now);
        self.receiver
            .take(&self.line.receive(Duration::MAX), on_event);
        self.receiver
            .order
            .finish(|frame| hand_on(&frame.message, on_event));
        let line = self.line.tally();
        self.receiver.loss_stats.close(line.sent);
        LineOutcome {
            frames: self.receiver.loss_stats.tally(),
            line,
            bytes: self.receiver.bytes,
        }
    }
}

impl Receiver {
    fn take(&mut self, bytes: &[u8], on_event: &mut impl FnMut(&Event)) {
        self.bytes.extend_from_slice(bytes);
        for received in bytes.iter().filter_map(|byte| self.decoder.push(*byte)) {
            self.loss_stats.take(&received);
            if let Received::Frame { frame, .. } = received {
                self.order
                    .take(frame, |frame| hand_on(&frame.message, on_event));
            }
        }
    }
}

fn hand_on(message: &Message, on_event: &mut impl FnMut(&Event)) {
    if let Message::Event(event) = message {
        on_event(event);
    }
}
