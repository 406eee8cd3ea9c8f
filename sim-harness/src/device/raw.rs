//! The bytes that a board has sent, kept for a recording.

use amiro_ipf::link::MAX_FRAME;

/// Bytes without a zero byte that are kept, at most: more are no frame.
pub(super) const LONGEST_PIECE: usize = 4 * MAX_FRAME;

/// Received bytes that were not taken yet.
#[derive(Debug, Default)]
pub(super) struct RawBytes {
    bytes: Vec<u8>,
    /// Bytes since the last zero byte.
    piece: usize,
    is_paused: bool,
}

impl RawBytes {
    /// Drops all bytes and keeps none until [`resume`](Self::resume).
    pub(super) fn pause(&mut self) {
        *self = Self {
            is_paused: true,
            ..Self::default()
        };
    }

    /// Keeps bytes from now on.
    pub(super) fn resume(&mut self) {
        self.is_paused = false;
    }

    /// Keeps a byte, unless its piece is longer than any frame.
    pub(super) fn push(&mut self, byte: u8) {
        if self.is_paused {
            return;
        }
        if byte == 0 {
            self.piece = 0;
        } else if self.piece < LONGEST_PIECE {
            self.piece += 1;
        } else {
            return;
        }
        self.bytes.push(byte);
    }

    /// Takes all bytes.
    pub(super) fn take(&mut self) -> Vec<u8> {
        self.piece = 0;
        std::mem::take(&mut self.bytes)
    }

    /// Takes the bytes up to the last zero byte: no frame is cut.
    pub(super) fn take_whole(&mut self) -> Vec<u8> {
        let end = self.bytes.iter().rposition(|byte| *byte == 0);
        let rest = self.bytes.split_off(end.map_or(0, |zero| zero + 1));
        std::mem::replace(&mut self.bytes, rest)
    }
}
