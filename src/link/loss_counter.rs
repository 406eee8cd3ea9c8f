//! The number of frames that a link lost, each counted once.

use super::Received;

/// Counts the frames of a stream that arrived broken, out of order or not at all.
///
/// A damaged frame shows twice, as a piece that is no frame and as a gap before the
/// next good one; a damaged zero byte makes one piece of two frames. Between two good
/// frames the larger of both numbers counts.
#[derive(Clone, Debug, Default)]
pub struct LossCounter {
    broken: u16,
}

impl LossCounter {
    /// Nothing lost yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { broken: 0 }
    }

    /// Takes the decoder's next result and returns the number of new losses.
    pub fn take(&mut self, received: &Received) -> u16 {
        match *received {
            Received::Broken(_) => {
                self.broken = self.broken.saturating_add(1);
                1
            }
            Received::Frame { lost, .. } => {
                // The upper half of the circle is a step backward.
                let gap = if lost < 0x8000 { lost } else { 1 };
                gap.saturating_sub(core::mem::take(&mut self.broken))
            }
        }
    }

    /// Restarts the count at a frame that begins another session, whose gap is no loss.
    pub fn restart(&mut self) {
        self.broken = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Frame, FrameError, Message};
    use super::*;

    fn good(lost: u16) -> Received {
        let message = Message::Hello;
        let frame = Frame {
            boot_id: 0,
            sequence: 0,
            message,
        };
        Received::Frame { frame, lost }
    }

    const BROKEN: Received = Received::Broken(FrameError::BadChecksum);

    fn total(stream: &[Received]) -> u16 {
        let mut losses = LossCounter::new();
        stream.iter().map(|received| losses.take(received)).sum()
    }

    #[test]
    fn a_damaged_frame_is_one_loss_not_two() {
        assert_eq!(total(&[good(0), BROKEN, good(1)]), 1);
    }

    #[test]
    fn gaps_and_pieces_each_show_where_they_are_more() {
        assert_eq!(total(&[good(0), good(3)]), 3);
        assert_eq!(total(&[good(0), BROKEN, good(2)]), 2, "merged frames");
        assert_eq!(total(&[good(0), BROKEN, BROKEN, good(0)]), 2, "garbage");
        assert_eq!(total(&[BROKEN, good(1), good(1)]), 2, "counts afresh");
    }

    #[test]
    fn half_a_circle_ahead_is_a_step_backward() {
        assert_eq!(total(&[good(0), good(32_767)]), 32_767);
        assert_eq!(total(&[good(0), good(32_768)]), 1);
    }

    #[test]
    fn a_piece_of_another_session_hides_no_gap_of_this_one() {
        let mut losses = LossCounter::new();
        assert_eq!(losses.take(&BROKEN), 1);
        losses.restart();
        assert_eq!(losses.take(&good(1)), 1);
    }

    #[test]
    fn a_frame_that_comes_again_is_one_loss_not_65535() {
        assert_eq!(total(&[good(0), good(65_535), good(0)]), 1);
    }
}
