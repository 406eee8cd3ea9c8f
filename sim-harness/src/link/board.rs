//! A board at the other end of a byte stream.

use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use std::{fmt, thread};

use amiro_ipf::event::{Boot, Event};
use amiro_ipf::fault::Fault;
use amiro_ipf::input::Input;
use amiro_ipf::wire::{Decoder, Encoder, Frame, Message, Outgoing, Received, WIRE_VERSION};

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
    /// It refused an input that the host's own node takes.
    Refused {
        /// Which input, from 0.
        input: usize,
        /// Why.
        fault: Fault,
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
            Self::Refused { input, fault } => write!(f, "input {input} was refused: {fault}"),
        }
    }
}

impl std::error::Error for LinkError {}

/// A board: something that takes input frames and answers with event frames.
pub struct Board {
    outgoing: Box<dyn Write + Send>,
    incoming: Receiver<Vec<u8>>,
    pending: std::collections::VecDeque<Received>,
    decoder: Decoder,
    encoder: Encoder,
    boot: Option<Boot>,
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
            pending: std::collections::VecDeque::new(),
            decoder: Decoder::new(),
            encoder: Encoder::new(HOST_BOOT_ID),
            boot: None,
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
        let deadline = Instant::now() + BOOT_DEADLINE;
        // What a board is sent before its line is up is lost: ask again and again.
        while Instant::now() < deadline {
            self.send(&Input::Hello)?;
            let patience = Instant::now() + Duration::from_millis(500);
            while let Some(received) = self.receive(patience)? {
                let Received::Frame { frame, .. } = received else {
                    continue;
                };
                match frame.message {
                    Message::Event(Event::Boot(boot)) => {
                        self.boot = Some(boot);
                        if boot.wire_version != WIRE_VERSION {
                            return Err(LinkError::Version {
                                board: boot.wire_version,
                            });
                        }
                    }
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

    /// Frames of the board that never arrived whole, since the greeting.
    #[must_use]
    pub fn lost_frames(&self) -> u64 {
        self.lost_frames
    }

    /// Takes the bytes that were received since the greeting or the last call.
    pub fn take_raw(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.raw)
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
            if let Some(received) = self.pending.pop_front() {
                self.lost_frames += match &received {
                    Received::Frame { lost, .. } => u64::from(*lost),
                    Received::Broken(_) => 1,
                };
                return Ok(Some(received));
            }
            let patience = deadline.saturating_duration_since(Instant::now());
            let bytes = match self.incoming.recv_timeout(patience) {
                Ok(bytes) => bytes,
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => return Err(LinkError::Gone),
            };
            self.raw.extend_from_slice(&bytes);
            let decoder = &mut self.decoder;
            self.pending
                .extend(bytes.into_iter().filter_map(|byte| decoder.push(byte)));
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
