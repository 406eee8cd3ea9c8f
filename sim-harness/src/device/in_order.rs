//! Frames in the order in which they were sent, each once.

use amiro_ipf::link::Frame;

/// Frames that may wait for one that is missing before them.
const DEPTH: usize = 8;

/// Puts frames back into their sender's order and drops repeated ones.
///
/// A serial line neither repeats nor reorders; a recording or a network may. A frame
/// waits for earlier ones until eight later frames have arrived; then the missing ones
/// are given up. A frame that arrives after it was given up, up to 64 places late, is
/// dropped, and so is a repeated one.
#[derive(Clone, Debug, Default)]
pub struct InOrder {
    boot_id: Option<u8>,
    next: u16,
    waiting: Vec<Frame>,
}

impl InOrder {
    /// No frame yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// No frame yet, from a sender whose first frame has number 0.
    #[must_use]
    pub fn since_boot(boot_id: u8) -> Self {
        Self {
            boot_id: Some(boot_id),
            ..Self::default()
        }
    }

    /// Takes a frame and passes on all that are now in order.
    pub fn take(&mut self, frame: Frame, mut hand_on: impl FnMut(&Frame)) {
        if self.boot_id != Some(frame.boot_id) {
            self.finish(&mut hand_on);
            self.boot_id = Some(frame.boot_id);
            self.next = frame.sequence;
        }
        let late = self.next.wrapping_sub(frame.sequence);
        if (1..=64).contains(&late) {
            return;
        }
        let ahead = |frame: &Frame, next: u16| frame.sequence.wrapping_sub(next);
        let place = ahead(&frame, self.next);
        match self
            .waiting
            .binary_search_by_key(&place, |waiting| ahead(waiting, self.next))
        {
            Ok(_) => {}
            Err(index) => self.waiting.insert(index, frame),
        }
        if self.waiting.len() > DEPTH
            && let Some(first) = self.waiting.first()
        {
            self.next = first.sequence;
        }
        let ready = self
            .waiting
            .iter()
            .zip(0_u16..)
            .take_while(|(frame, index)| ahead(frame, self.next) == *index)
            .count();
        for frame in self.waiting.drain(..ready) {
            self.next = frame.sequence.wrapping_add(1);
            hand_on(&frame);
        }
    }

    /// Passes on all waiting frames at the end of the stream.
    pub fn finish(&mut self, mut hand_on: impl FnMut(&Frame)) {
        for frame in self.waiting.drain(..) {
            hand_on(&frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use amiro_ipf::link::Message;

    use super::*;

    fn order_of(numbers: impl IntoIterator<Item = u16>) -> Vec<u16> {
        through(InOrder::new(), numbers)
    }

    fn through(mut order: InOrder, numbers: impl IntoIterator<Item = u16>) -> Vec<u16> {
        let mut came = Vec::new();
        for sequence in numbers {
            let frame = Frame {
                boot_id: 1,
                sequence,
                message: Message::Hello,
            };
            order.take(frame, |frame| came.push(frame.sequence));
        }
        order.finish(|frame| came.push(frame.sequence));
        came
    }

    #[test]
    fn swapped_and_repeated_frames_come_out_once_and_in_order() {
        assert_eq!(order_of([5, 7, 6, 8, 8, 6, 9]), [5, 6, 7, 8, 9]);
        assert_eq!(order_of([65_534, 0, 65_535, 1]), [65_534, 65_535, 0, 1]);
    }

    #[test]
    fn the_first_frame_of_a_boot_may_come_second() {
        assert_eq!(through(InOrder::since_boot(1), [1, 0, 2]), [0, 1, 2]);
        assert_eq!(order_of([1, 0, 2]), [1, 2], "nobody knew of it");
    }

    #[test]
    fn a_lost_frame_is_not_waited_for_for_ever() {
        let with_a_hole = (0..30).filter(|number| *number != 4);
        assert_eq!(
            order_of(with_a_hole.clone()),
            with_a_hole.collect::<Vec<_>>()
        );
        assert_eq!(order_of([1, 50_000, 50_001]), [1, 50_000, 50_001]);
    }
}
