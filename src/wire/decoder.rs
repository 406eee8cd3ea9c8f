//! The resynchronising decoder: bytes in, frames out, losses counted.

use heapless::Vec;

use super::frame::{Frame, FrameError, MAX_FRAME};

/// What the decoder made of the bytes up to a zero byte.
#[derive(Clone, Debug, PartialEq)]
pub enum Received {
    /// A good frame, and how many frames of the same boot are missing before it.
    Frame {
        /// The frame.
        frame: Frame,
        /// Frames that must have been lost since the frame before.
        lost: u16,
    },
    /// Bytes that are no frame.
    Broken(FrameError),
}

/// Cuts a byte stream at its zero bytes and checks what lies between.
///
/// Never panics, never holds more than one frame, and is in step again at the next
/// zero byte whatever came before.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    bytes: Vec<u8, MAX_FRAME, u8>,
    overflowed: bool,
    expected: Option<(u8, u16)>,
}

impl Decoder {
    /// A decoder at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            overflowed: false,
            expected: None,
        }
    }

    /// Takes one byte; says something at every zero byte that ends more than nothing.
    pub fn push(&mut self, byte: u8) -> Option<Received> {
        if byte != 0 {
            self.overflowed |= self.bytes.push(byte).is_err();
            return None;
        }
        if self.bytes.is_empty() {
            return None;
        }
        let received = if self.overflowed {
            Received::Broken(FrameError::TooLong)
        } else {
            match Frame::decode(&mut self.bytes) {
                Ok(frame) => self.number(frame),
                Err(error) => Received::Broken(error),
            }
        };
        self.bytes.clear();
        self.overflowed = false;
        Some(received)
    }

    /// Whether bytes of an unfinished frame are held.
    #[must_use]
    pub fn is_inside_frame(&self) -> bool {
        !self.bytes.is_empty()
    }

    fn number(&mut self, frame: Frame) -> Received {
        let lost = match self.expected {
            Some((boot_id, sequence)) if boot_id == frame.boot_id => {
                frame.sequence.wrapping_sub(sequence)
            }
            _ => 0,
        };
        self.expected = Some((frame.boot_id, frame.sequence.wrapping_add(1)));
        Received::Frame { frame, lost }
    }
}
