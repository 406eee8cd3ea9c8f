//! A board at the other end of a byte stream.

use std::io::{Read, Write};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::board::supervision::PostMortem;
use amiro_ipf::link::{Boot, Decoder, Encoder, Frame, MAX_FRAME, Message, MessageRef, Received};

use super::baud_check::BaudCheck;
use super::greeting::{Answerer, Numbers, random_numbers};
use super::raw::RawBytes;
use super::transport::{Ends, MOST_WAITING, Opener, Transport};
use super::{FaultInjector, FrameTally, Interrupt, LineTally, LinkError, LossStats};

/// How long a board may take to answer.
pub(super) const ANSWER_DEADLINE: Duration = Duration::from_secs(2);

/// How long a board may take to come up.
pub(super) const BOOT_DEADLINE: Duration = Duration::from_secs(10);

/// Longest time between two checks for an interrupt by the user.
const INTERRUPTED_WITHIN: Duration = Duration::from_millis(100);

/// Boot id of the frames that a host sends; a board's own counts from 0.
pub(super) const HOST_BOOT_ID: u8 = 0xa5;

/// The two directions of a line with faults.
struct Disturbance {
    to_board: FaultInjector,
    from_board: FaultInjector,
    since: Instant,
}

/// A board: something that takes input frames and answers with event frames.
pub struct Board {
    transport: Transport,
    opener: Option<Opener>,
    disturbance: Option<Disturbance>,
    /// Received bytes that were not decoded yet.
    unread: std::vec::IntoIter<u8>,
    decoder: Decoder,
    pub(super) encoder: Encoder,
    pub(super) numbers: Numbers,
    pub(super) greeted: Option<Answerer>,
    /// Number of the last greeting's frames.
    pub(super) greeted_as: u16,
    pub(super) loss_stats: LossStats,
    baud_check: BaudCheck,
    /// Bytes since the last piece ended.
    piece_bytes: u64,
    pub(super) raw: RawBytes,
    /// Pieces that were received in a row after a deadline had passed.
    late: usize,
    interrupt: Option<Interrupt>,
    /// A value that is dropped with the board: an emulator's process.
    _keep: Box<dyn Send>,
}

impl Board {
    /// A board behind a reader and a writer; `keep` is dropped with it.
    pub(super) fn over(
        reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
        keep: impl Send + 'static,
    ) -> Self {
        Self::on(Transport::over(reader, writer), None, keep)
    }

    /// A board behind what `open` opens, now and whenever the link is gone; `keep` is
    /// dropped with it.
    ///
    /// # Errors
    /// The error of `open`.
    pub fn reopened_by(
        mut open: impl FnMut() -> Result<Ends, LinkError> + Send + 'static,
        keep: impl Send + 'static,
    ) -> Result<Self, LinkError> {
        let (reader, writer) = open()?;
        let transport = Transport::over(reader, writer);
        Ok(Self::on(transport, Some(Box::new(open)), keep))
    }

    fn on(transport: Transport, opener: Option<Opener>, keep: impl Send + 'static) -> Self {
        Self {
            transport,
            opener,
            disturbance: None,
            unread: Vec::new().into_iter(),
            decoder: Decoder::new(),
            encoder: Encoder::new(HOST_BOOT_ID),
            numbers: random_numbers(),
            greeted: None,
            greeted_as: 0,
            loss_stats: LossStats::new(),
            baud_check: BaudCheck::default(),
            piece_bytes: 0,
            raw: RawBytes::default(),
            late: 0,
            interrupt: None,
            _keep: Box::new(keep),
        }
    }

    /// The board at the other end of a line with faults, one per direction.
    #[must_use]
    pub fn behind(mut self, to_board: FaultInjector, from_board: FaultInjector) -> Self {
        self.disturbance = Some(Disturbance {
            to_board,
            from_board,
            since: Instant::now(),
        });
        self
    }

    /// Begins each greeting with a number from `numbers` instead of a random one.
    #[must_use]
    pub fn numbered_by(mut self, numbers: impl FnMut() -> u16 + Send + 'static) -> Self {
        self.numbers = Box::new(numbers);
        self
    }

    /// Ends all waiting for the board with [`LinkError::Interrupted`] when `interrupt` is
    /// requested.
    #[must_use]
    pub fn ended_by(mut self, interrupt: Interrupt) -> Self {
        self.interrupt = Some(interrupt);
        self
    }

    /// Whether the user has interrupted the program.
    pub(super) fn is_interrupted(&self) -> bool {
        let interrupt = self.interrupt.as_ref();
        interrupt.is_some_and(Interrupt::is_requested)
    }

    /// The faults of the line so far, to the board and from it.
    #[must_use]
    pub fn line_tallies(&self) -> Option<(LineTally, LineTally)> {
        let lines = self.disturbance.as_ref()?;
        Some((lines.to_board.tally(), lines.from_board.tally()))
    }

    /// Closes the link; the board keeps running. [`reconnect`](Self::reconnect) opens it again.
    pub fn disconnect(&mut self) {
        // The old link is closed before a new one is opened: a port opens only once.
        self.transport = Transport::closed();
        self.unread = Vec::new().into_iter();
    }

    /// Tries once to open the link again. A frame that was half received is dropped; the
    /// board's frames continue with its current number.
    ///
    /// # Errors
    /// [`LinkError::Gone`] for a link that cannot be opened again, or why it was not.
    pub fn reconnect(&mut self) -> Result<(), LinkError> {
        self.disconnect();
        let (reader, writer) = self.opener.as_mut().ok_or(LinkError::Gone)?()?;
        self.transport = Transport::over(reader, writer);
        if self.decoder.is_inside_frame() {
            // Ends the piece, so that it does not cost the next frame.
            self.unread = vec![0].into_iter();
        }
        Ok(())
    }

    /// Whether more than half of the bytes of two seconds were no frames; `true` once.
    pub fn take_baud_warning(&mut self) -> bool {
        self.baud_check.take_warning()
    }

    /// Whether most received bytes are no frames.
    pub(super) fn receives_noise(&self) -> bool {
        self.baud_check.is_mostly_noise()
    }

    /// The board's answer to the greeting.
    #[must_use]
    pub fn boot(&self) -> Option<&Boot> {
        self.greeted.as_ref().map(|board| &board.boot)
    }

    /// The boot that the board was greeted in; another one later is a restart.
    #[must_use]
    pub fn boot_id(&self) -> Option<u8> {
        self.greeted.as_ref().map(|board| board.boot_id)
    }

    /// Number of frames that greeted the board, each of which is answered.
    pub(super) fn greeted_as(&self) -> u16 {
        self.greeted_as
    }

    /// Restarts the loss statistics after this frame: earlier frames belong to another run.
    pub(super) fn begin_loss_stats(&mut self, frame: &Frame) {
        self.loss_stats = LossStats::after(frame);
    }

    /// The offsets that the board had when it was greeted; `None` if it had none yet.
    #[must_use]
    pub fn offsets(&self) -> Option<&OffsetReport> {
        self.greeted.as_ref()?.offsets.as_ref()
    }

    /// How the boot before the greeted one ended, if it failed.
    #[must_use]
    pub fn post_mortem(&self) -> Option<&PostMortem> {
        self.greeted.as_ref()?.post_mortem.as_ref()
    }

    /// Frames of the board that were lost on the line since the greeting.
    #[must_use]
    pub fn lost_frames(&self) -> u64 {
        self.tally().lost
    }

    /// The loss statistics of the board's frames since the greeting.
    #[must_use]
    pub fn tally(&self) -> FrameTally {
        self.loss_stats.tally()
    }

    /// Takes the bytes that were received since the greeting or the last call.
    ///
    /// Of bytes without a zero byte the first 512 are kept: no frame is as long.
    pub fn take_raw(&mut self) -> Vec<u8> {
        self.raw.take()
    }

    /// Takes the same bytes up to the last zero byte.
    pub(super) fn take_whole_raw(&mut self) -> Vec<u8> {
        self.raw.take_whole()
    }

    /// The board's next message.
    ///
    /// # Errors
    /// [`LinkError::Silent`] when none comes within the deadline; a broken link.
    pub fn next_message(&mut self) -> Result<Message, LinkError> {
        let deadline = Instant::now() + ANSWER_DEADLINE;
        while let Some(frame) = self.receive_frame(deadline)? {
            if frame.message.is_from_board() {
                return Ok(frame.message);
            }
        }
        Err(LinkError::Silent)
    }

    /// Sends bytes unchanged, as a disturbed line might deliver them.
    ///
    /// # Errors
    /// [`LinkError::Write`].
    pub fn send_raw(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        match &mut self.disturbance {
            None => self.transport.write(bytes),
            Some(lines) => {
                let now = lines.since.elapsed();
                lines.to_board.send(bytes, now);
                self.transport.write(&lines.to_board.receive(now))
            }
        }
    }

    /// Sends a message; the sequence number of its frame.
    pub(super) fn send<'m>(
        &mut self,
        message: impl Into<MessageRef<'m>>,
    ) -> Result<u16, LinkError> {
        let sequence = self.encoder.sequence();
        let frame = self.encoder.encode(message).to_vec();
        self.send_raw(&frame)?;
        Ok(sequence)
    }

    /// The next frame, whole or broken; `None` when there is none before the deadline.
    pub(super) fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, LinkError> {
        loop {
            // One frame at a time, so that the raw bytes always end with the last frame
            // that was returned.
            for byte in self.unread.by_ref() {
                self.raw.push(byte);
                let received = self.decoder.push(byte);
                if byte == 0 && self.piece_bytes == 0 {
                    // Nothing between two zero bytes: an idle line may send any number.
                    continue;
                }
                self.piece_bytes += 1;
                if received.is_none() && self.piece_bytes < 4 * MAX_FRAME as u64 {
                    continue;
                }
                let is_frame = matches!(received, Some(Received::Frame { .. }));
                self.baud_check
                    .take(self.piece_bytes, is_frame, Instant::now());
                self.piece_bytes = 0;
                if let Some(received) = received {
                    self.loss_stats.take(&received);
                    return Ok(Some(received));
                }
            }
            let Some(bytes) = self.arrivals(deadline)? else {
                return Ok(None);
            };
            self.unread = bytes.into_iter();
        }
    }

    /// Bytes that have arrived, perhaps none yet; `None` at the deadline.
    ///
    /// Bytes that arrived in time are still decoded after the deadline, and no later
    /// ones: a board that never stops sending does not block its host.
    fn arrivals(&mut self, deadline: Instant) -> Result<Option<Vec<u8>>, LinkError> {
        if self.is_interrupted() {
            return Err(LinkError::Interrupted);
        }
        let mut patience = deadline.saturating_duration_since(Instant::now());
        if !patience.is_zero() {
            self.late = 0;
        } else if self.late > MOST_WAITING {
            self.late = 0;
            return Ok(None);
        } else {
            self.late += 1;
        }
        if self.interrupt.is_some() {
            patience = patience.min(INTERRUPTED_WITHIN);
        }
        if let Some(lines) = &mut self.disturbance {
            let now = lines.since.elapsed();
            self.transport.write(&lines.to_board.receive(now))?;
            let arrived = lines.from_board.receive(now);
            if !arrived.is_empty() {
                return Ok(Some(arrived));
            }
            let next = [&lines.to_board, &lines.from_board];
            for due in next.into_iter().filter_map(FaultInjector::next_arrival) {
                patience = patience.min(due.saturating_sub(now));
            }
        }
        match self.transport.incoming.recv_timeout(patience) {
            Ok(bytes) => Ok(Some(match &mut self.disturbance {
                None => bytes,
                Some(lines) => {
                    let now = lines.since.elapsed();
                    lines.from_board.send(&bytes, now);
                    lines.from_board.receive(now)
                }
            })),
            Err(RecvTimeoutError::Timeout) if Instant::now() < deadline => Ok(Some(Vec::new())),
            Err(RecvTimeoutError::Timeout) => {
                self.late = 0;
                Ok(None)
            }
            Err(RecvTimeoutError::Disconnected) => Err(LinkError::Gone),
        }
    }

    /// The next whole frame before the deadline; broken ones are counted and skipped.
    pub(super) fn receive_frame(&mut self, deadline: Instant) -> Result<Option<Frame>, LinkError> {
        while let Some(received) = self.receive(deadline)? {
            if let Received::Frame { frame, .. } = received {
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, sink};
    use std::thread;

    use amiro_ipf::BUILD_ID;
    use amiro_ipf::board::clock_choice::ClockSource;
    use amiro_ipf::link::{Status, WIRE_VERSION};
    use amiro_ipf::node::{Config, Input};

    use super::super::raw::LONGEST_PIECE;
    use super::*;

    fn boot() -> Message {
        Message::Boot(Boot {
            wire_version: WIRE_VERSION,
            build_id: BUILD_ID,
            capacity: 8000,
            window: 8,
            baud: 2_000_000,
            clock: ClockSource::CrystalPll,
            core_hz: 168_000_000,
        })
    }

    /// A board that says these bytes, in two pieces, whatever it is told.
    fn board_that_says(first: Vec<u8>, second: Vec<u8>) -> Board {
        Board::over(Cursor::new(first).chain(Cursor::new(second)), sink(), ())
    }

    #[test]
    fn a_board_that_never_boots_is_given_up_at_the_deadline() {
        let mut silent = Board::in_memory(|_| false);
        let start = Instant::now();
        let patience = Duration::from_millis(50);
        let greeted = silent.greet_within(patience);
        assert!(matches!(greeted, Err(LinkError::NoBoot)), "{greeted:?}");
        assert!(start.elapsed() >= patience);
        assert!(start.elapsed() < Duration::from_secs(2));
        let words = LinkError::NoBoot.to_string();
        assert!(words.contains("within 10 s"), "{words}");
    }

    #[test]
    fn noise_without_a_zero_byte_is_neither_kept_nor_waited_for_beyond_the_deadline() {
        let mut board = Board::over(std::io::repeat(0x55), sink(), ());
        let start = Instant::now();
        let deadline = start + Duration::from_millis(50);
        assert!(board.receive_frame(deadline).unwrap().is_none());
        assert!(start.elapsed() < Duration::from_secs(5));
        assert!(board.take_whole_raw().is_empty());
        assert_eq!(board.take_raw().len(), LONGEST_PIECE);
    }

    #[test]
    fn broken_frames_without_end_are_not_waited_for_beyond_the_deadline() {
        let broken = [0x55, 0x55, 0x55, 0].repeat(10_000_000);
        let mut board = Board::over(Cursor::new(broken), sink(), ());
        let deadline = Instant::now() + Duration::from_millis(50);
        assert!(board.receive_frame(deadline).unwrap().is_none());
        // Whole pieces can be written down while the line is amid one.
        assert_eq!(board.take_whole_raw().last(), Some(&0));
    }

    #[test]
    fn what_came_before_a_greeting_is_not_kept() {
        let statuses = Encoder::new(3)
            .encode(&Message::Status(Status::default()))
            .repeat(100);
        let mut board = board_that_says(statuses, Vec::new());
        assert!(board.greet().is_err());
        assert!(board.take_raw().is_empty());
    }

    /// Bytes that were sent once, then silence: a tape.
    struct Tape(Cursor<Vec<u8>>);

    impl Read for Tape {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            match self.0.read(buffer)? {
                0 => {
                    thread::sleep(Duration::from_millis(20));
                    Err(std::io::ErrorKind::WouldBlock.into())
                }
                count => Ok(count),
            }
        }
    }

    /// All bytes that a board sent in a session of a greeting and a configuration.
    fn taped_session() -> Vec<u8> {
        let (sender, sent) = std::sync::mpsc::channel();
        let mut board = Board::in_memory(move |frame| sender.send(frame.clone()).is_ok());
        board.greet().unwrap();
        let start = [Input::Configure(Config::default())];
        super::super::drive(&mut board, &start, |_| (), |_, _| ()).unwrap();
        drop(board);
        sent.into_iter().flatten().collect()
    }

    #[test]
    fn a_tape_of_an_earlier_session_does_not_answer_a_greeting() {
        let tape = Tape(Cursor::new(taped_session()));
        let mut board = Board::over(tape, sink(), ());
        let greeted = board.greet_within(Duration::from_millis(300));
        assert!(
            matches!(greeted, Err(LinkError::OtherSession)),
            "{greeted:?}"
        );
        assert_eq!(board.boot(), None);
    }

    #[test]
    fn stale_frames_in_front_of_the_answer_are_of_no_session() {
        let stale = taped_session();
        let other: Vec<u8> = {
            let mut encoder = Encoder::new(77);
            let boot = Message::Boot(Boot {
                capacity: 1,
                ..*Board::in_memory(|_| true).greet().as_ref().unwrap()
            });
            let answer = Message::Answer {
                input: 0,
                refused: None,
            };
            [boot, answer]
                .iter()
                .flat_map(|message| encoder.encode(message).to_vec())
                .collect()
        };
        for stale in [stale, other] {
            let mut is_first = true;
            let mut board = Board::in_memory(move |frame| {
                if std::mem::take(&mut is_first) {
                    frame.splice(0..0, stale.clone());
                }
                true
            });
            let boot = board.greet().unwrap();
            assert_eq!(boot.capacity, 8000);
            assert_eq!(board.boot_id(), Some(0));
            let inputs = [Message::Hello, Message::Hello];
            let audit = super::super::drive(&mut board, &inputs, |_| (), |_, _| ()).unwrap();
            assert_eq!(audit, super::super::AnswerAudit::default());
            let tally = board.tally();
            assert_eq!((tally.lost, tally.repeated, tally.broken), (0, 0, 0));
        }
    }

    #[test]
    fn raw_bytes_begin_with_a_whole_frame_after_the_greeting() {
        let mut encoder = Encoder::new(3);
        let mut frame = |message: &Message| encoder.encode(message).to_vec();
        let greeting = [(); 2].map(|()| {
            let answer = Message::Answer {
                input: 0,
                refused: None,
            };
            [frame(&boot()), frame(&answer)].concat()
        });
        let greeting = greeting.concat();
        let statuses = [(); 2].map(|()| frame(&Message::Status(Status::default())));
        // The first piece ends within the first status.
        let (head, tail) = statuses[0].split_at(9);
        let board = board_that_says([&greeting, head].concat(), [tail, &statuses[1]].concat());
        let mut board = board.numbered_by(|| 0);
        board.greet().unwrap();
        let deadline = Instant::now() + Duration::from_secs(1);
        for status in statuses {
            assert!(board.receive_frame(deadline).unwrap().is_some());
            assert_eq!(board.take_raw(), status);
        }
        assert_eq!(board.lost_frames(), 0);
    }
}
