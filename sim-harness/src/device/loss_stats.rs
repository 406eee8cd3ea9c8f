//! Loss statistics of a sender's numbered frames.

use std::fmt;

use amiro_ipf::link::{BoardStatus, Frame, Message, Received};
use serde::Serialize;

/// Numbers of the same boot that are kept: a frame may be this late.
const MEMORY: u64 = 64;

/// The counts of a sender's frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrameTally {
    /// Numbers that the sender used.
    pub sent: u64,
    /// Of these received whole, each once.
    pub received: u64,
    /// Of these dropped by the board, by its own count.
    pub dropped: u64,
    /// Of these neither received nor dropped: lost on the line.
    pub lost: u64,
    /// Repeated frames.
    pub repeated: u64,
    /// Pieces of bytes that were no frame.
    pub broken: u64,
    /// Statuses in which the board's own counts contradict its frame numbers.
    pub contradicted: u64,
}

/// Frames that are unaccounted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Imbalance {
    /// The host's counts do not add up to the sender's.
    #[error(
        "{} received, {} dropped and {} lost are not {sent} sent",
        tally.received, tally.dropped, tally.lost
    )]
    Sum {
        /// The host's counts.
        tally: FrameTally,
        /// The sender's count.
        sent: u64,
    },
    /// A board counts other frames than it numbers, or fewer than arrived.
    #[error("in {0} statuses the board's counts are not what its frames' numbers say")]
    Contradicted(u64),
}

impl FrameTally {
    /// The sum rule: received, dropped and lost together are the frames that the sender has
    /// sent. Of a board that reports them only in its statuses, this is `self.sent`: no
    /// status contradicts it.
    ///
    /// # Errors
    /// [`Imbalance`] with the counts.
    pub fn balance(&self, sent: u64) -> Result<(), Imbalance> {
        if self.contradicted > 0 {
            return Err(Imbalance::Contradicted(self.contradicted));
        }
        let found = self.received + self.dropped + self.lost;
        if found == sent && self.sent == sent {
            Ok(())
        } else {
            Err(Imbalance::Sum { tally: *self, sent })
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            sent: self.sent + other.sent,
            received: self.received + other.received,
            dropped: self.dropped + other.dropped,
            lost: self.lost + other.lost,
            repeated: self.repeated + other.repeated,
            broken: self.broken + other.broken,
            contradicted: self.contradicted + other.contradicted,
        }
    }
}

impl fmt::Display for FrameTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames sent: {} received, {} dropped by the sender, {} lost on the line",
            self.sent, self.received, self.dropped, self.lost
        )?;
        if self.broken > 0 {
            write!(f, "; {} pieces were no frame", self.broken)?;
        }
        if self.repeated > 0 {
            write!(f, "; {} came again", self.repeated)?;
        }
        if self.contradicted > 0 {
            write!(f, "; {}", Imbalance::Contradicted(self.contradicted))?;
        }
        Ok(())
    }
}

/// Counts a sender's received, dropped and lost frames by their numbers.
///
/// A board's status, itself a numbered frame, contains the counts of sent and dropped
/// frames since its boot. Between two statuses the numbers used must be the frames sent
/// and dropped, and the frames received leave exactly those that were lost on the line.
/// Frames that are missing before the first status count as lost, even if the board
/// dropped them.
///
/// Numbers have 16 bits; the board's counts give the number of wraps.
#[derive(Clone, Debug, Default)]
pub struct LossStats {
    boot_id: Option<u8>,
    begin: u64,
    /// The number after the highest received one.
    next: u64,
    received: u64,
    /// Which of the last numbers were received: bit i for `next - 1 - i`.
    came: u64,
    dropped: u64,
    /// The board's counts at its last status, or at its boot.
    last: Option<SenderCounts>,
    repeated: u64,
    broken: u64,
    contradicted: u64,
    /// Other boots before this one.
    before: FrameTally,
}

/// A board's counts before the frame with this number.
#[derive(Clone, Copy, Debug, Default)]
struct SenderCounts {
    sent: u32,
    dropped: u32,
    number: u64,
}

impl LossStats {
    /// Statistics that begin with the first received frame.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Statistics since a sender's boot: its first frame has number 0, and nothing was
    /// dropped before it.
    #[must_use]
    pub fn since_boot(boot_id: u8) -> Self {
        Self {
            boot_id: Some(boot_id),
            last: Some(SenderCounts::default()),
            ..Self::default()
        }
    }

    /// Statistics that begin after this frame.
    #[must_use]
    pub fn after(frame: &Frame) -> Self {
        let begin = u64::from(frame.sequence) + 1;
        Self {
            boot_id: Some(frame.boot_id),
            begin,
            next: begin,
            ..Self::default()
        }
    }

    /// Takes the decoder's next result.
    pub fn take(&mut self, received: &Received) {
        match received {
            Received::Broken(_) => self.broken += 1,
            Received::Frame { frame, .. } => self.take_frame(frame),
        }
    }

    fn take_frame(&mut self, frame: &Frame) {
        if self.boot_id != Some(frame.boot_id) {
            let begin = u64::from(frame.sequence);
            *self = Self {
                boot_id: Some(frame.boot_id),
                begin,
                next: begin,
                before: self.tally(),
                ..Self::default()
            };
        }
        let behind = u64::from((self.next as u16).wrapping_sub(frame.sequence));
        if (1..=MEMORY.min(self.next - self.begin)).contains(&behind) {
            let bit = 1 << (behind - 1);
            if self.came & bit == 0 {
                self.came |= bit;
                self.received += 1;
            } else {
                self.repeated += 1;
            }
            return;
        }
        let ahead = u64::from(frame.sequence.wrapping_sub(self.next as u16));
        self.go_on(ahead);
        if let Message::Status(status) = &frame.message {
            self.settle(&status.board);
        }
        self.go_on(1);
        self.came |= 1;
        self.received += 1;
    }

    /// Takes the board's counts before the next frame.
    fn settle(&mut self, board: &BoardStatus) {
        let mut mark = SenderCounts {
            sent: board.sent_frames,
            dropped: board.dropped_frames,
            number: self.next,
        };
        if let Some(last) = self.last {
            let sent = u64::from(mark.sent.wrapping_sub(last.sent));
            let dropped = u64::from(mark.dropped.wrapping_sub(last.dropped));
            let more = (sent + dropped).checked_sub(self.next - last.number);
            let more = more.filter(|more| {
                let numbers = self.next + more - self.begin;
                more % (1 << 16) == 0 && self.received + self.dropped + dropped <= numbers
            });
            match more {
                Some(more) => {
                    self.go_on(more);
                    self.dropped += dropped;
                }
                // One of the counts is wrong, and it is unknown which: none of them is taken.
                None => self.contradicted += 1,
            }
            mark.number = self.next;
        }
        self.last = Some(mark);
    }

    fn go_on(&mut self, numbers: u64) {
        self.next += numbers;
        let shift = u32::try_from(numbers).unwrap_or(u32::MAX);
        self.came = self.came.checked_shl(shift).unwrap_or(0);
    }

    /// Closes the statistics with the number of frames that the sender has sent since they
    /// began: those after the last received one are lost too.
    pub fn close(&mut self, sent: u64) {
        let end = self.begin + sent;
        if end > self.next {
            self.go_on(end - self.next);
        }
    }

    /// The statistics so far, over all boots.
    #[must_use]
    pub fn tally(&self) -> FrameTally {
        let sent = self.next - self.begin;
        let lost = (sent - self.received).saturating_sub(self.dropped);
        self.before.plus(FrameTally {
            sent,
            received: self.received,
            dropped: self.dropped,
            lost,
            repeated: self.repeated,
            broken: self.broken,
            contradicted: self.contradicted,
        })
    }
}

#[cfg(test)]
mod tests {
    use amiro_ipf::link::{BoardStatus, FrameError, Status};

    use super::*;

    fn frame(boot_id: u8, number: u64, message: Message) -> Received {
        let frame = Frame {
            boot_id,
            sequence: number as u16,
            message,
        };
        Received::Frame { frame, lost: 0 }
    }

    fn hello(number: u64) -> Received {
        frame(3, number, Message::Hello)
    }

    /// A status of a board that counts as it numbers.
    fn status(number: u64, dropped_frames: u32) -> Received {
        status_with(number, number as u32 - dropped_frames, dropped_frames)
    }

    fn status_with(number: u64, sent_frames: u32, dropped_frames: u32) -> Received {
        let board = BoardStatus {
            sent_frames,
            dropped_frames,
            ..BoardStatus::default()
        };
        let status = Status {
            board,
            ..Status::default()
        };
        frame(3, number, Message::Status(status))
    }

    fn tally(received: impl IntoIterator<Item = Received>) -> [u64; 5] {
        let mut loss_stats = LossStats::new();
        for received in received {
            loss_stats.take(&received);
        }
        let tally = loss_stats.tally();
        assert_eq!(tally.balance(tally.sent), Ok(()));
        [
            tally.sent,
            tally.received,
            tally.dropped,
            tally.lost,
            tally.repeated,
        ]
    }

    #[test]
    fn gaps_are_losses_but_what_comes_late_or_twice_is_none() {
        assert_eq!(tally([5, 6, 7].map(hello)), [3, 3, 0, 0, 0]);
        assert_eq!(tally([5, 8].map(hello)), [4, 2, 0, 2, 0]);
        assert_eq!(tally([5, 7, 6, 8].map(hello)), [4, 4, 0, 0, 0]);
        assert_eq!(tally([5, 6, 6, 5, 7].map(hello)), [3, 3, 0, 0, 2]);
        assert_eq!(tally([65_534, 65_537].map(hello)), [4, 2, 0, 2, 0]);
        // 40 000 at once: more than half of the circle.
        assert_eq!(tally([0, 40_001].map(hello)), [40_002, 2, 0, 40_000, 0]);
    }

    #[test]
    fn what_the_board_dropped_was_not_lost_on_the_line() {
        let stream = [status(110, 100), hello(111), hello(115), status(118, 104)];
        assert_eq!(tally(stream), [9, 4, 4, 1, 0]);
    }

    #[test]
    fn a_board_that_counts_other_frames_than_it_numbers_is_named() {
        let contradicted = |second: Received| {
            let mut loss_stats = LossStats::since_boot(3);
            for received in [hello(0), hello(1), status_with(2, 2, 0), second] {
                loss_stats.take(&received);
            }
            let tally = loss_stats.tally();
            assert_eq!(tally.balance(tally.sent).is_err(), tally.contradicted > 0);
            tally.contradicted
        };
        assert_eq!(contradicted(status_with(6, 6, 0)), 0);
        assert_eq!(contradicted(status_with(6, 4, 2)), 0);
        // One too many and one too few sent, or dropped.
        for (sent, dropped) in [(7, 0), (5, 0), (4, 3), (4, 1)] {
            assert_eq!(contradicted(status_with(6, sent, dropped)), 1);
        }
        // Numbers agree, but a frame that is said to be dropped has come.
        assert_eq!(contradicted(status_with(3, 2, 1)), 1);
    }

    #[test]
    fn numbers_that_went_round_while_the_host_was_away_are_found_by_the_counts() {
        // 200 000 frames dropped: three times round and 3392 more.
        let stream = [status(10, 0), status(200_011, 200_000), hello(200_012)];
        assert_eq!(tally(stream), [200_003, 3, 200_000, 0, 0]);
    }

    #[test]
    fn boots_are_accounted_for_one_after_another() {
        let other = frame(4, 0, Message::Hello);
        let stream = [hello(5), hello(7), other];
        assert_eq!(tally(stream), [4, 3, 0, 1, 0]);
    }

    #[test]
    fn loss_stats_since_boot_include_losses_at_both_ends() {
        let mut loss_stats = LossStats::since_boot(3);
        loss_stats.take(&Received::Broken(FrameError::BadChecksum));
        loss_stats.take(&hello(2));
        loss_stats.close(10);
        let tally = loss_stats.tally();
        assert_eq!((tally.received, tally.lost, tally.broken), (1, 9, 1));
        assert_eq!(tally.balance(10), Ok(()));
        let error = tally.balance(11).unwrap_err();
        assert_eq!(
            error.to_string(),
            "1 received, 0 dropped and 9 lost are not 11 sent"
        );
    }
}
