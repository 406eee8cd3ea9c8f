//! Frames around any bytes, and bytes that choose what happens next.

use amiro_ipf::checksum::CRC;
use amiro_ipf::link::MAX_FRAME;

/// Longest payload that a frame carries.
const LONGEST_PAYLOAD: usize = MAX_FRAME - 9;

/// A whole frame, its zero byte included, around a payload that need not be a message.
///
/// A fuzzer that had to find checksums would see nothing behind them.
pub fn frame_around(boot_id: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let payload = &payload[..payload.len().min(LONGEST_PAYLOAD)];
    let [low, high] = sequence.to_le_bytes();
    let mut body = vec![boot_id, low, high];
    body.extend_from_slice(payload);
    body.extend_from_slice(&CRC.checksum(&body).to_le_bytes());
    let mut frame = vec![0; cobs::max_encoding_length(body.len())];
    let length = cobs::encode(&body, &mut frame);
    frame.truncate(length);
    frame.push(0);
    frame
}

/// Bytes, taken from the front; zeros when they are used up.
pub struct Script<'b>(pub &'b [u8]);

impl<'b> Script<'b> {
    /// Whether all bytes are used up.
    pub fn is_over(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    /// The next two bytes as a number.
    pub fn word(&mut self) -> u16 {
        u16::from_le_bytes([self.byte(), self.byte()])
    }

    /// The next bytes, as many as there are.
    pub fn bytes(&mut self, most: usize) -> &'b [u8] {
        let (bytes, rest) = self.0.split_at(most.min(self.0.len()));
        self.0 = rest;
        bytes
    }

    /// A length in one byte, then so many bytes.
    pub fn piece(&mut self) -> &'b [u8] {
        let most = usize::from(self.byte());
        self.bytes(most)
    }
}

/// As [`Script::piece`] reads it; what is beyond 255 bytes is cut off.
pub fn piece_of(bytes: &[u8]) -> Vec<u8> {
    let bytes = &bytes[..bytes.len().min(255)];
    let mut piece = vec![bytes.len() as u8];
    piece.extend_from_slice(bytes);
    piece
}
