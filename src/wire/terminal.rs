//! The board's end of a link: bytes in, a node behind, frames out.
//!
//! Portable like the node: the flash image feeds it from a serial port, a test from
//! memory.

use super::{Decoder, Encoder, Message, Outgoing, Received};
use crate::event::{Boot, Event, Status};
use crate::fault::Fault;
use crate::input::Input;
use crate::node::Node;

/// How a frame is treated when the line cannot keep up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Importance {
    /// Particle events: dropped first, and counted.
    Detail,
    /// Everything else.
    Essential,
}

impl Importance {
    fn of(event: &Event) -> Self {
        match event {
            Event::Particles(_) => Self::Detail,
            _ => Self::Essential,
        }
    }
}

/// A node behind a link.
#[derive(Debug)]
pub struct Terminal<'a, const N: usize> {
    node: Node<'a, N>,
    boot: Boot,
    decoder: Decoder,
    encoder: Encoder,
    broken_frames: u32,
}

impl<'a, const N: usize> Terminal<'a, N> {
    /// A terminal that introduces itself as `boot`.
    pub fn new(node: Node<'a, N>, boot: Boot, boot_id: u8) -> Self {
        Self {
            node,
            boot,
            decoder: Decoder::new(),
            encoder: Encoder::new(boot_id),
            broken_frames: 0,
        }
    }

    /// The node behind the link.
    #[must_use]
    pub fn node(&self) -> &Node<'a, N> {
        &self.node
    }

    /// Input frames that arrived broken or not at all.
    #[must_use]
    pub fn broken_frames(&self) -> u32 {
        self.broken_frames
    }

    /// Says who speaks.
    pub fn introduce(&mut self, send: &mut impl FnMut(&[u8], Importance)) {
        self.say(&Event::Boot(self.boot), send);
    }

    /// Says how things are.
    pub fn report(&mut self, status: Status, send: &mut impl FnMut(&[u8], Importance)) {
        self.say(&Event::Status(status), send);
    }

    /// Takes one received byte; the end of a good frame is handled and answered.
    ///
    /// Whether a frame was handled: the caller may then want to look at the room it
    /// has for the next one's events.
    pub fn receive(&mut self, byte: u8, send: &mut impl FnMut(&[u8], Importance)) -> bool {
        match self.decoder.push(byte) {
            None => false,
            Some(Received::Broken(_)) => {
                self.broken_frames = self.broken_frames.wrapping_add(1);
                false
            }
            Some(Received::Frame { frame, lost }) => {
                self.broken_frames = self.broken_frames.wrapping_add(u32::from(lost));
                let refused = self.take(&frame.message, send).err();
                let answer = Event::Answer {
                    input: frame.sequence,
                    refused,
                };
                self.say(&answer, send);
                true
            }
        }
    }

    /// Hands an input of the board's own to the node: a tick, later a reading.
    pub fn inject(&mut self, input: &Input, send: &mut impl FnMut(&[u8], Importance)) {
        // A refusal is counted in the node's status; a board has nobody else to tell.
        let _ = self.handle(input, send);
    }

    fn take(
        &mut self,
        message: &Message,
        send: &mut impl FnMut(&[u8], Importance),
    ) -> Result<(), Fault> {
        let Message::Input(input) = message else {
            return Err(Fault::NotAnInput);
        };
        if *input == Input::Hello {
            self.introduce(send);
        }
        self.handle(input, send)
    }

    fn handle(
        &mut self,
        input: &Input,
        send: &mut impl FnMut(&[u8], Importance),
    ) -> Result<(), Fault> {
        let Self { node, encoder, .. } = self;
        node.handle(input, &mut |event| transmit(encoder, event, send))
    }

    fn say(&mut self, event: &Event, send: &mut impl FnMut(&[u8], Importance)) {
        transmit(&mut self.encoder, event, send);
    }
}

fn transmit(encoder: &mut Encoder, event: &Event, send: &mut impl FnMut(&[u8], Importance)) {
    send(
        encoder.encode(Outgoing::Event(event)),
        Importance::of(event),
    );
}
