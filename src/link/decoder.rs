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
/// zero byte, after any earlier bytes.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    bytes: Vec<u8, MAX_FRAME, u8>,
    expected: Option<(u8, u16)>,
}

impl Decoder {
    /// A decoder at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            expected: None,
        }
    }

    /// Takes one byte; gives a result at every zero byte that ends at least one byte.
    pub fn push(&mut self, byte: u8) -> Option<Received> {
        if byte != 0 {
            // Bytes beyond the full buffer are dropped: the piece is too long for a frame.
            let _ = self.bytes.push(byte);
            return None;
        }
        if self.bytes.is_empty() {
            return None;
        }
        let received = match Frame::decode(&mut self.bytes) {
            Ok(frame) => self.number(frame),
            Err(error) => Received::Broken(error),
        };
        self.bytes.clear();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_unfinished_from_its_first_byte_to_its_zero_byte() {
        let mut decoder = Decoder::new();
        for (byte, is_inside) in [(0, false), (3, true), (7, true), (0, false), (0, false)] {
            decoder.push(byte);
            assert_eq!(decoder.is_inside_frame(), is_inside);
        }
    }

    #[test]
    fn f62_what_is_longer_than_any_frame_is_one_piece() {
        for length in [MAX_FRAME, MAX_FRAME + 1, 10 * MAX_FRAME] {
            let mut decoder = Decoder::new();
            assert!((0..length).all(|_| decoder.push(1).is_none()));
            let too_long = Received::Broken(FrameError::TooLong);
            assert_eq!(decoder.push(0), Some(too_long), "{length} bytes");
            assert!(!decoder.is_inside_frame());
        }
    }
}
