//! A board at the other end of a byte stream.

use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use std::{fmt, thread};

use amiro_ipf::event::{Boot, Event, OffsetReport};
use amiro_ipf::fault::Fault;
use amiro_ipf::input::Input;
use amiro_ipf::wire::{Decoder, Encoder, Frame, Losses, Message, Outgoing, Received, WIRE_VERSION};

/// How long a board may take to answer.
pub(super) const ANSWER_DEADLINE: Duration = Duration::from_secs(2);

/// How long a board may take to come up.
const BOOT_DEADLINE: Duration = Duration::from_secs(10);

/// Boot id of the frames that a host sends; a board's own counts from 0.
const HOST_BOOT_ID: u8 = 0xa5;

/// Why a live board is of no use.
#[derive(Debug)]
pub enum LinkError {
    /// It could not be started or opened.
    Start(String),
    /// Writing to it failed.
    Write(std::io::Error),
    /// It closed the stream.
    Gone,
    /// It said nothing that can be read within the deadline.
    NoBoot,
    /// It speaks another version of the protocol.
    Version {
        /// The board's version.
        board: u8,
    },
    /// It left an input without an answer within the deadline.
    NoAnswer {
        /// Which input, from 0.
        input: usize,
    },
    /// It said nothing within the deadline.
    Silent,
    /// It refused what it was told to begin with.
    Refused(Fault),
    /// It started anew in the middle of a run: what it knew is gone.
    Restarted {
        /// The first input without an answer, from 0.
        input: usize,
    },
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start(reason) => write!(f, "the board cannot be reached: {reason}"),
            Self::Write(error) => write!(f, "writing to the board failed: {error}"),
            Self::Gone => f.write_str("the board closed the link"),
            Self::NoBoot => write!(
                f,
                "the board did not introduce itself within {} s (wrong port or baud rate?)",
                BOOT_DEADLINE.as_secs()
            ),
            Self::Version { board } => write!(
                f,
                "the board speaks protocol version {board}, this host {WIRE_VERSION}"
            ),
            Self::NoAnswer { input } => write!(
                f,
                "input {input} was not answered within {} s",
                ANSWER_DEADLINE.as_secs()
            ),
            Self::Refused(fault) => write!(f, "the board refused what it was told: {fault}"),
            Self::Silent => f.write_str("the board fell silent"),
            Self::Restarted { input } => {
                write!(f, "the board started anew before it answered input {input}")
            }
        }
    }
}

impl std::error::Error for LinkError {}

/// A board: something that takes input frames and answers with event frames.
pub struct Board {
    outgoing: Box<dyn Write + Send>,
    incoming: Receiver<Vec<u8>>,
    /// Received bytes that were not looked at yet.
    unread: std::vec::IntoIter<u8>,
    decoder: Decoder,
    encoder: Encoder,
    boot: Option<Boot>,
    boot_id: Option<u8>,
    offsets: Option<OffsetReport>,
    losses: Losses,
    lost_frames: u64,
    raw: Vec<u8>,
    /// Whatever must live as long as the link: an emulator's process, a thread.
    _keep: Box<dyn Send>,
}

impl Board {
    /// A board behind a reader and a writer; `keep` is dropped with it.
    ///
    /// A thread of its own reads, so that waiting always has a deadline.
    pub(super) fn over(
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
        keep: impl Send + 'static,
    ) -> Self {
        let (sender, incoming) = sync_channel(1024);
        thread::spawn(move || pump(&mut reader, &sender));
        Self {
            outgoing: Box::new(writer),
            incoming,
            unread: Vec::new().into_iter(),
            decoder: Decoder::new(),
            encoder: Encoder::new(HOST_BOOT_ID),
            boot: None,
            boot_id: None,
            offsets: None,
            losses: Losses::new(),
            lost_frames: 0,
            raw: Vec::new(),
            _keep: Box::new(keep),
        }
    }

    /// Greets the board until it introduces itself.
    ///
    /// # Errors
    /// [`LinkError::NoBoot`], [`LinkError::Version`], or a broken link.
    pub fn greet(&mut self) -> Result<Boot, LinkError> {
        self.greet_within(BOOT_DEADLINE)
    }

    fn greet_within(&mut self, patience: Duration) -> Result<Boot, LinkError> {
        let deadline = Instant::now() + patience;
        // What a board is sent before its line is up is lost: ask again and again.
        while Instant::now() < deadline {
            self.send(&Input::Hello)?;
            let next_greeting = deadline.min(Instant::now() + Duration::from_millis(500));
            while let Some(received) = self.receive(next_greeting)? {
                let Received::Frame { frame, .. } = received else {
                    continue;
                };
                match frame.message {
                    Message::Event(Event::Boot(boot)) => {
                        self.boot = Some(boot);
                        self.boot_id = Some(frame.boot_id);
                        self.offsets = None;
                        if boot.wire_version != WIRE_VERSION {
                            return Err(LinkError::Version {
                                board: boot.wire_version,
                            });
                        }
                    }
                    Message::Event(Event::Offsets(offsets)) => self.offsets = Some(offsets),
                    // The answer to the greeting: everything before it is behind us.
                    Message::Event(Event::Answer { input, .. })
                        if input == self.encoder.sequence().wrapping_sub(1) =>
                    {
                        if let Some(boot) = self.boot {
                            self.lost_frames = 0;
                            self.raw.clear();
                            return Ok(boot);
                        }
                    }
                    _ => {}
                }
            }
        }
        Err(LinkError::NoBoot)
    }

    /// How the board introduced itself.
    #[must_use]
    pub fn boot(&self) -> Option<&Boot> {
        self.boot.as_ref()
    }

    /// The boot that the board was greeted in; another one later is a restart.
    #[must_use]
    pub fn boot_id(&self) -> Option<u8> {
        self.boot_id
    }

    /// The offsets that the board had when it was greeted; `None` if it had none yet.
    #[must_use]
    pub fn offsets(&self) -> Option<&OffsetReport> {
        self.offsets.as_ref()
    }

    /// Frames of the board that never arrived whole, since the greeting.
    #[must_use]
    pub fn lost_frames(&self) -> u64 {
        self.lost_frames
    }

    /// Takes the bytes that were received since the greeting or the last call.
    pub fn take_raw(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.raw)
    }

    /// The board's next event.
    ///
    /// # Errors
    /// [`LinkError::Silent`] when none comes within the deadline; a broken link.
    pub fn next_event(&mut self) -> Result<Event, LinkError> {
        let deadline = Instant::now() + ANSWER_DEADLINE;
        while let Some(frame) = self.receive_frame(deadline)? {
            if let Message::Event(event) = frame.message {
                return Ok(event);
            }
        }
        Err(LinkError::Silent)
    }

    /// Sends bytes as they are: what a disturbed line might deliver.
    ///
    /// # Errors
    /// [`LinkError::Write`].
    pub fn send_raw(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.outgoing.write_all(bytes).map_err(LinkError::Write)?;
        self.outgoing.flush().map_err(LinkError::Write)
    }

    /// Sends an input; the sequence number of its frame.
    pub(super) fn send(&mut self, input: &Input) -> Result<u16, LinkError> {
        let sequence = self.encoder.sequence();
        let frame = self.encoder.encode(Outgoing::Input(input));
        self.outgoing.write_all(frame).map_err(LinkError::Write)?;
        self.outgoing.flush().map_err(LinkError::Write)?;
        Ok(sequence)
    }

    /// The next frame, whole or broken; `None` when there is none before the deadline.
    pub(super) fn receive(&mut self, deadline: Instant) -> Result<Option<Received>, LinkError> {
        loop {
            // One frame at a time: what is raw then always ends where the frames end
            // that were handed on, whatever the pieces in which bytes arrive.
            for byte in self.unread.by_ref() {
                self.raw.push(byte);
                if let Some(received) = self.decoder.push(byte) {
                    self.lost_frames += u64::from(self.losses.take(&received));
                    return Ok(Some(received));
                }
            }
            let patience = deadline.saturating_duration_since(Instant::now());
            self.unread = match self.incoming.recv_timeout(patience) {
                Ok(bytes) => bytes.into_iter(),
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => return Err(LinkError::Gone),
            };
        }
    }

    /// The next whole frame before the deadline; broken ones are counted and passed over.
    pub(super) fn receive_frame(&mut self, deadline: Instant) -> Result<Option<Frame>, LinkError> {
        while let Some(received) = self.receive(deadline)? {
            if let Received::Frame { frame, .. } = received {
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }
}

/// Reads until the stream ends or nobody listens any more.
fn pump(reader: &mut impl Read, sender: &SyncSender<Vec<u8>>) {
    let mut buffer = [0; 4096];
    loop {
        match reader.read(&mut buffer) {
            Ok(0) => return,
            Ok(count) => {
                let bytes = buffer.get(..count).unwrap_or_default().to_vec();
                if sender.send(bytes).is_err() {
                    return;
                }
            }
            Err(error) => match error.kind() {
                std::io::ErrorKind::Interrupted => {}
                // A serial port that is silent.
                std::io::ErrorKind::TimedOut | std::io::ErrorKind::WouldBlock => {}
                _ => return,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, sink};

    use amiro_ipf::BUILD_ID;
    use amiro_ipf::event::{ClockSource, Status};

    use super::*;

    fn boot() -> Event {
        Event::Boot(Boot {
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
    fn raw_bytes_begin_with_a_whole_frame_after_the_greeting() {
        let mut encoder = Encoder::new(3);
        let mut frame = |event: &Event| encoder.encode(Outgoing::Event(event)).to_vec();
        let greeting = [
            frame(&boot()),
            frame(&Event::Answer {
                input: 0,
                refused: None,
            }),
        ]
        .concat();
        let statuses = [(); 2].map(|()| frame(&Event::Status(Status::default())));
        // The first piece ends within the first status.
        let (head, tail) = statuses[0].split_at(9);
        let mut board = board_that_says([&greeting, head].concat(), [tail, &statuses[1]].concat());
        board.greet().unwrap();
        let deadline = Instant::now() + Duration::from_secs(1);
        for status in statuses {
            assert!(board.receive_frame(deadline).unwrap().is_some());
            assert_eq!(board.take_raw(), status);
        }
        assert_eq!(board.lost_frames(), 0);
    }
}
