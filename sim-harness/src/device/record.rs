//! Recording a robot that reads its own sensors.

use std::io::Write;
use std::time::{Duration, Instant};

use amiro_ipf::link::{Frame, Message};
use amiro_ipf::node::{Config, Event, Input, Source};

use super::board::ANSWER_DEADLINE;
use super::{Board, LinkError};
use crate::log::RecordingWriter;

/// Longest silence of a board, which sends its status at 8 Hz.
const SILENCE: Duration = Duration::from_secs(2);

/// How long after a link was lost it is first opened again; then twice as long, and so
/// on up to the longest.
const FIRST_RETRY: Duration = Duration::from_millis(200);
const LONGEST_RETRY: Duration = Duration::from_secs(5);

/// Longest time between two calls of `wanted`.
const ASKED_EVERY: Duration = Duration::from_millis(100);

/// Resets after which a recording ends: such a board does not work.
pub const MOST_RESETS: u32 = 100;

/// Shortest time from the begin of one part to that of the next.
const SHORTEST_PART: Duration = Duration::from_secs(1);

/// Why a recording ended early.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The link failed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The recording cannot be written.
    #[error("the recording cannot be written: {0}")]
    Write(#[from] std::io::Error),
    /// The board was reset [`MOST_RESETS`] times.
    #[error("the board was reset {MOST_RESETS} times: the recording ends, all its parts are whole")]
    TooManyResets,
}

/// What happens during a recording.
#[derive(Debug)]
pub enum RecordingEvent<'a> {
    /// A message of the board.
    Message(&'a Message),
    /// The link is gone, and why; it is being opened again.
    Vanished(&'a LinkError),
    /// The board sent an input of its own, such as a reading.
    Input(&'a Input),
    /// Nothing was received for a tenth of a second.
    Waiting,
    /// The link is still gone.
    Away,
    /// The link is back.
    Back,
    /// The board was reset: its next frames go to this part, counted from 1. The part is
    /// opened when the board has taken its configuration again.
    Restarted {
        /// The part that begins.
        part: u32,
    },
    /// The board's steps took too long: it continues with fewer particles per sensor.
    Limited {
        /// How many.
        particles_per_sensor: u16,
    },
    /// More than half of the received bytes are no frames, perhaps because of a wrong baud
    /// rate. At most once.
    MostlyNoise,
    /// The board has sent nothing for two seconds: the recording ends.
    Silent,
}

impl<'a> RecordingEvent<'a> {
    fn of(message: &'a Message) -> Self {
        match message {
            Message::Input(Input::Limit {
                particles_per_sensor,
            }) => Self::Limited {
                particles_per_sensor: *particles_per_sensor,
            },
            Message::Input(input) => Self::Input(input),
            Message::Hello | Message::Calibrate | Message::Truth(_) => Self::Waiting,
            message => Self::Message(message),
        }
    }
}

/// How one part of a recording ended.
enum PartEnd {
    /// Enough was recorded.
    Enough,
    /// The board was reset.
    Restarted,
}

/// Starts a greeted board with a configuration, its own sensors as the source, and writes
/// its frames until `wanted` returns `false` or the board's [`Interrupt`](super::Interrupt)
/// is requested. Returns the number of parts.
///
/// Each part begins with the configuration and holds the board's frames from then on, so
/// that it replays as any other recording: its boot and post-mortem messages, in answer to
/// another greeting, and its readings. `open` opens each, counted from 1, once the board
/// has taken its configuration: a board that refuses it leaves no file. There is one part
/// per boot of the board, because a reset loses its state; parts begin at least a second
/// apart. Parts are flushed at every status, eight times per second, so a failure of the
/// host loses at most that much. `wanted` gets all events, at least ten per second.
///
/// Received bytes are written and not kept; of bytes that are no frame, 512 of each piece
/// between two zero bytes.
///
/// A link that goes away is opened again after 0.2 s, 0.4 s and so on up to every 5 s,
/// without end. The board keeps running meanwhile: its frames are lost and leave a gap in
/// its numbers.
///
/// # Errors
/// [`LinkError::Silent`] when a board that was never recorded sends nothing for two seconds
/// over a link that is there; after a frame of its drive the recording ends without an
/// error. A board that refuses the configuration or does not answer, or an interrupt before
/// it did; a file that fails; [`RecordError::TooManyResets`]. What was written before is
/// whole.
pub fn record<W: Write>(
    board: &mut Board,
    config: &Config,
    open: impl FnMut(u32) -> std::io::Result<W>,
    wanted: impl FnMut(RecordingEvent<'_>) -> bool,
) -> Result<u32, RecordError> {
    record_at_pace(board, config, SHORTEST_PART, open, wanted)
}

fn record_at_pace<W: Write>(
    board: &mut Board,
    config: &Config,
    shortest_part: Duration,
    mut open: impl FnMut(u32) -> std::io::Result<W>,
    mut wanted: impl FnMut(RecordingEvent<'_>) -> bool,
) -> Result<u32, RecordError> {
    let own = Config {
        source: Source::Board,
        ..*config
    };
    let start = Input::Configure(own);
    let mut part = 1;
    for _ in 0..MOST_RESETS {
        let next_part = Instant::now() + shortest_part;
        let frames = match begin(board, &start) {
            // Reset again before it answered: the part has not begun yet.
            Err(LinkError::Restarted { .. }) => None,
            Err(LinkError::Interrupted) if part > 1 => return Ok(part - 1),
            frames => Some(frames?),
        };
        if let Some(frames) = frames {
            let mut writer = RecordingWriter::new(open(part)?)?;
            let ended = record_part(board, &start, &frames, &mut writer, &mut wanted);
            // The bytes so far are kept, also after an error.
            writer.finish()?;
            match ended? {
                PartEnd::Enough => return Ok(part),
                PartEnd::Restarted => part += 1,
            }
            if !wanted(RecordingEvent::Restarted { part }) {
                return Ok(part - 1);
            }
        }
        while Instant::now() < next_part {
            let rest = next_part.saturating_duration_since(Instant::now());
            std::thread::sleep(rest.min(ASKED_EVERY));
            if board.is_interrupted() || !wanted(RecordingEvent::Waiting) {
                return Ok(part - 1);
            }
        }
        match board.greet() {
            Ok(_) => {}
            Err(LinkError::Interrupted) => return Ok(part - 1),
            Err(error) if is_gone(&error) => {
                if !reconnect(board, &error, &mut wanted) {
                    return Ok(part - 1);
                }
                board.greet()?;
            }
            Err(error) => return Err(error.into()),
        }
    }
    Err(RecordError::TooManyResets)
}

fn record_part(
    board: &mut Board,
    start: &Input,
    configured: &[u8],
    writer: &mut RecordingWriter<impl Write>,
    wanted: &mut impl FnMut(RecordingEvent<'_>) -> bool,
) -> Result<PartEnd, RecordError> {
    writer.write_input(start)?;
    writer.write_frames(configured)?;
    writer.flush()?;
    // The answer contains the boot and post-mortem messages, which are part of the recording.
    board.send(&Message::Hello)?;
    let mut uptime_ms = 0;
    let mut silent_at = Instant::now() + SILENCE;
    let mut has_recorded = false;
    loop {
        let asked_at = silent_at.min(Instant::now() + ASKED_EVERY);
        let frame = match board.receive_frame(asked_at) {
            Ok(Some(frame)) => frame,
            Ok(None) => {
                writer.write_frames(&board.take_whole_raw())?;
                let is_silent = Instant::now() >= silent_at;
                if is_silent && board.receives_noise() {
                    silent_at = Instant::now() + SILENCE;
                } else if is_silent && has_recorded {
                    wanted(RecordingEvent::Silent);
                    return Ok(PartEnd::Enough);
                } else if is_silent {
                    return Err(LinkError::Silent.into());
                }
                let event = if board.take_baud_warning() {
                    RecordingEvent::MostlyNoise
                } else {
                    RecordingEvent::Waiting
                };
                if wanted(event) {
                    continue;
                }
                return Ok(PartEnd::Enough);
            }
            Err(LinkError::Interrupted) => return Ok(PartEnd::Enough),
            Err(error) if is_gone(&error) => {
                if reconnect(board, &error, wanted) {
                    silent_at = Instant::now() + SILENCE;
                    continue;
                }
                return Ok(PartEnd::Enough);
            }
            Err(error) => return Err(error.into()),
        };
        silent_at = Instant::now() + SILENCE;
        if is_of_another_boot(board, &frame, &mut uptime_ms) {
            return Ok(PartEnd::Restarted);
        }
        writer.write_frames(&board.take_raw())?;
        has_recorded |= is_of_the_drive(&frame.message);
        if board.take_baud_warning() && !wanted(RecordingEvent::MostlyNoise) {
            return Ok(PartEnd::Enough);
        }
        if matches!(frame.message, Message::Status(_)) {
            writer.flush()?;
        }
        if !wanted(RecordingEvent::of(&frame.message)) {
            return Ok(PartEnd::Enough);
        }
    }
}

/// Configures the board; returns its frames from `Configured` on.
///
/// Earlier frames belong to the board's earlier run.
fn begin(board: &mut Board, start: &Input) -> Result<Vec<u8>, LinkError> {
    let sequence = board.send(start)?;
    let deadline = Instant::now() + ANSWER_DEADLINE;
    let mut frames = Vec::new();
    let mut is_configured = false;
    while let Some(frame) = board.receive_frame(deadline)? {
        if board.boot_id() != Some(frame.boot_id) {
            return Err(LinkError::Restarted { input: 0 });
        }
        let raw = board.take_raw();
        is_configured |= matches!(frame.message, Message::Event(Event::Configured(_)));
        if is_configured {
            frames.extend(raw);
        }
        if let Message::Answer { input, refused } = frame.message
            && input == sequence
        {
            return refused.map_or(Ok(frames), |fault| Err(LinkError::Refused(fault)));
        }
    }
    Err(LinkError::NoAnswer { input: 0 })
}

/// Whether a message is more than an answer to the recorder.
fn is_of_the_drive(message: &Message) -> bool {
    !matches!(
        message,
        Message::Boot(_)
            | Message::Event(Event::Configured(_))
            | Message::Answer { .. }
            | Message::Offsets(_)
            | Message::PostMortem(_)
    )
}

/// Whether the board was reset since it was greeted: by its boot id or, if two boots share
/// one, by a clock that went back.
fn is_of_another_boot(board: &Board, frame: &Frame, uptime_ms: &mut u64) -> bool {
    let mut went_back = false;
    if let Message::Status(status) = &frame.message {
        went_back = status.board.uptime_ms < *uptime_ms;
        *uptime_ms = status.board.uptime_ms;
    }
    board.boot_id() != Some(frame.boot_id) || went_back
}

fn is_gone(error: &LinkError) -> bool {
    matches!(error, LinkError::Gone | LinkError::Write(_))
}

/// Opens the link again without a time limit; `false` when `wanted` ends it.
fn reconnect(
    board: &mut Board,
    error: &LinkError,
    wanted: &mut impl FnMut(RecordingEvent<'_>) -> bool,
) -> bool {
    let mut goes_on = !board.is_interrupted() && wanted(RecordingEvent::Vanished(error));
    board.disconnect();
    let mut pause = FIRST_RETRY;
    while goes_on {
        let next = Instant::now() + pause;
        while goes_on && Instant::now() < next {
            let rest = next.saturating_duration_since(Instant::now());
            std::thread::sleep(rest.min(ASKED_EVERY));
            goes_on = !board.is_interrupted() && wanted(RecordingEvent::Away);
        }
        if goes_on && board.reconnect().is_ok() {
            return wanted(RecordingEvent::Back);
        }
        pause = (2 * pause).min(LONGEST_RETRY);
    }
    false
}

#[cfg(test)]
mod tests {
    use std::io::{Read, pipe};

    use amiro_ipf::board::clock_choice::ClockSource;
    use amiro_ipf::link::{Boot, Decoder, Encoder, Received, Status, WIRE_VERSION};

    use super::*;

    /// A board that takes its configuration and is reset, again and again.
    fn reset_in_a_loop() -> Board {
        let (mut received, to_board) = pipe().unwrap();
        let (from_board, mut sent) = pipe().unwrap();
        std::thread::spawn(move || {
            let mut decoder = Decoder::new();
            let mut encoder = Encoder::new(0);
            let mut boot_id = 0_u8;
            let mut byte = [0];
            while received.read_exact(&mut byte).is_ok() {
                let Some(Received::Frame { frame, .. }) = decoder.push(byte[0]) else {
                    continue;
                };
                let answer = Message::Answer {
                    input: frame.sequence,
                    refused: None,
                };
                let events = match frame.message {
                    Message::Hello => {
                        let boot = Boot {
                            wire_version: WIRE_VERSION,
                            build_id: 7,
                            capacity: 8000,
                            window: 8,
                            baud: 2_000_000,
                            clock: ClockSource::CrystalPll,
                            core_hz: 168_000_000,
                        };
                        vec![Message::Boot(boot), answer]
                    }
                    Message::Input(Input::Configure(config)) => {
                        vec![Event::Configured(config).into(), answer]
                    }
                    _ => continue,
                };
                let is_configured = events
                    .iter()
                    .any(|it| matches!(it, Message::Event(Event::Configured(_))));
                for event in &events {
                    sent.write_all(encoder.encode(event)).unwrap();
                }
                if is_configured {
                    boot_id = boot_id.wrapping_add(1);
                    encoder = Encoder::new(boot_id);
                    let status = Message::Status(Status::default());
                    sent.write_all(encoder.encode(&status)).unwrap();
                }
            }
        });
        Board::over(from_board, to_board, ())
    }

    #[test]
    fn a_board_that_resets_in_a_loop_does_not_begin_parts_without_end() {
        let mut board = reset_in_a_loop();
        board.greet().unwrap();
        let mut parts = 0;
        let open = |part| {
            parts = part;
            Ok(std::io::sink())
        };
        let ended = record_at_pace(&mut board, &Config::default(), Duration::ZERO, open, |_| {
            true
        });
        assert!(
            matches!(ended, Err(RecordError::TooManyResets)),
            "{ended:?}"
        );
        assert_eq!(parts, MOST_RESETS);
    }

    #[test]
    fn a_board_that_resets_in_a_loop_begins_a_part_a_second_at_most() {
        let mut board = reset_in_a_loop();
        board.greet().unwrap();
        let start = Instant::now();
        let mut opened = Vec::new();
        let open = |_| {
            opened.push(start.elapsed());
            Ok(std::io::sink())
        };
        let wanted = |_: RecordingEvent<'_>| start.elapsed() < Duration::from_millis(2500);
        record(&mut board, &Config::default(), open, wanted).unwrap();
        assert!((1..=3).contains(&opened.len()), "{opened:?}");
    }
}
