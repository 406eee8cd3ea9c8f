//! Sequence numbers of several senders whose frames lie in one file.

use std::collections::BTreeMap;

/// How a frame's number follows its sender's last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SequenceCheck {
    /// It is the next one, or the first of its sender.
    Next,
    /// The given number of frames is missing before it.
    Lost(u16),
    /// It is the sender's last frame again, byte for byte.
    Again,
    /// It is an earlier number: the sender started over.
    Earlier,
}

impl SequenceCheck {
    /// The same for a frame that is known to be no repetition.
    pub(super) fn not_again(self) -> Self {
        match self {
            Self::Again => Self::Earlier,
            other => other,
        }
    }
}

/// The last frame of each sender, by boot id: at most 256 times 128 bytes.
///
/// The link's own decoder expects one sender; a recording interleaves a host and a
/// board.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequences {
    last: BTreeMap<u8, (u16, Vec<u8>)>,
}

impl Sequences {
    /// Takes the next frame: its boot id, its number, its bytes as they were written.
    pub(super) fn check(&mut self, boot_id: u8, sequence: u16, bytes: &[u8]) -> SequenceCheck {
        let Some((last, last_bytes)) = self.last.get_mut(&boot_id) else {
            self.last.insert(boot_id, (sequence, bytes.to_vec()));
            return SequenceCheck::Next;
        };
        let continuity = match sequence.wrapping_sub(*last) {
            0 if last_bytes == bytes => SequenceCheck::Again,
            1 => SequenceCheck::Next,
            // The upper half of the circle, and the same number on another frame.
            0 | 0x8000.. => SequenceCheck::Earlier,
            ahead => SequenceCheck::Lost(ahead - 1),
        };
        *last = sequence;
        last_bytes.clear();
        last_bytes.extend_from_slice(bytes);
        continuity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn senders_are_numbered_apart() {
        let mut sequences = Sequences::default();
        let mut check = |boot_id, sequence| sequences.check(boot_id, sequence, &[boot_id]);
        assert_eq!(check(1, 65_534), SequenceCheck::Next);
        assert_eq!(check(2, 7), SequenceCheck::Next);
        assert_eq!(check(1, 65_535), SequenceCheck::Next);
        assert_eq!(check(2, 10), SequenceCheck::Lost(2));
        assert_eq!(check(1, 0), SequenceCheck::Next);
        assert_eq!(check(1, 0), SequenceCheck::Again);
        assert_eq!(check(2, 3), SequenceCheck::Earlier);
        assert_eq!(check(2, 4), SequenceCheck::Next);
    }

    #[test]
    fn same_number_on_another_frame_is_a_new_start() {
        let mut sequences = Sequences::default();
        assert_eq!(sequences.check(1, 0, b"a"), SequenceCheck::Next);
        assert_eq!(sequences.check(1, 0, b"b"), SequenceCheck::Earlier);
    }
}
