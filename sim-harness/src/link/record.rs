//! Recording a robot that reads its own sensors.

use std::io::Write;
use std::time::{Duration, Instant};

use amiro_ipf::config::{Config, Source};
use amiro_ipf::event::Event;
use amiro_ipf::input::Input;
use amiro_ipf::wire::{Frame, Message};

use super::board::ANSWER_DEADLINE;
use super::{Board, LinkError};
use crate::log::RecordingWriter;

/// How long a board that has said nothing may stay silent: it says how it is at 8 Hz.
const SILENCE: Duration = Duration::from_secs(2);

/// How long after a link was lost it is first opened again; then twice as long, and so
/// on up to the longest.
const FIRST_RETRY: Duration = Duration::from_millis(200);
const LONGEST_RETRY: Duration = Duration::from_secs(5);

/// How often someone who waits for a link is asked whether to go on.
const ASKED_EVERY: Duration = Duration::from_millis(100);

/// Why a recording ended early.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The link failed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The recording cannot be written.
    #[error("the recording cannot be written: {0}")]
    Write(#[from] std::io::Error),
}

/// What happens while a board is recorded.
#[derive(Debug)]
pub enum News<'a> {
    /// The board said something.
    Event(&'a Event),
    /// The link is gone, and why; it is being opened again.
    Vanished(&'a LinkError),
    /// The link is still gone.
    Away,
    /// The link is back.
    Back,
    /// The board started anew: its next words go to this part, counted from 1.
    Restarted {
        /// The part that begins.
        part: u32,
    },
    /// The board's steps took too long: it goes on with so many particles a sensor.
    Limited {
        /// How many.
        particles_per_sensor: u16,
    },
    /// More than half of what comes is no frame: a wrong baud rate?
    Junk,
}

/// How one part of a recording ended.
enum PartEnd {
    /// Enough was recorded.
    Enough,
    /// The board started anew.
    Restarted,
}

/// Starts a greeted board with a configuration, its own sensors as the source, and
/// writes whatever it says until `wanted` says that it is enough. The number of parts.
///
/// Each part begins with the configuration and holds what the board says from then on,
/// so that it replays as any other recording: who it is and how its life before ended, in
/// answer to another greeting, and the readings that it takes. `open` opens each, counted
/// from 1; there is one for each boot of the board, since what a board knew is gone with
/// its reset.
/// Parts are flushed at every status, eight times a second: that much is lost when the
/// host dies. `wanted` sees all news, while the link is gone ten times a second.
///
/// A link that goes away is opened again after 0.2 s, 0.4 s and so on up to every 5 s,
/// without end. The board has gone on meanwhile: what it said is lost and shows as a
/// gap in its numbers.
///
/// # Errors
/// [`LinkError::Silent`] after two seconds without a frame over a link that is there; a
/// board that refuses the configuration or does not answer; a file that fails.
pub fn record<W: Write>(
    board: &mut Board,
    config: &Config,
    mut open: impl FnMut(u32) -> std::io::Result<W>,
    mut wanted: impl FnMut(News<'_>) -> bool,
) -> Result<u32, RecordError> {
    let mut part = 1;
    loop {
        let mut writer = RecordingWriter::new(open(part)?)?;
        let ended = record_part(board, config, &mut writer, &mut wanted);
        // Whatever ended it: what came is kept.
        writer.finish()?;
        match ended? {
            PartEnd::Enough => return Ok(part),
            PartEnd::Restarted => part += 1,
        }
        if !wanted(News::Restarted { part }) {
            return Ok(part - 1);
        }
        match board.greet() {
            Ok(_) => {}
            Err(error) if is_gone(&error) => {
                if !reconnect(board, &error, &mut wanted) {
                    return Ok(part - 1);
                }
                board.greet()?;
            }
            Err(error) => return Err(error.into()),
        }
    }
}

fn record_part(
    board: &mut Board,
    config: &Config,
    writer: &mut RecordingWriter<impl Write>,
    wanted: &mut impl FnMut(News<'_>) -> bool,
) -> Result<PartEnd, RecordError> {
    let own = Config {
        source: Source::Board,
        ..*config
    };
    let start = Input::Configure(own);
    writer.write_input(&start)?;
    writer.write_frames(&begin(board, &start)?)?;
    writer.flush()?;
    // Who it is and how its life before ended is said in answer: it is part of the record.
    board.send(&Input::Hello)?;
    let mut uptime_ms = 0;
    loop {
        let frame = match board.receive_frame(Instant::now() + SILENCE) {
            Ok(Some(frame)) => frame,
            Ok(None) if board.take_junk() || board.hears_junk() => {
                if wanted(News::Junk) {
                    continue;
                }
                return Ok(PartEnd::Enough);
            }
            Ok(None) => return Err(LinkError::Silent.into()),
            Err(error) if is_gone(&error) => {
                if reconnect(board, &error, wanted) {
                    continue;
                }
                return Ok(PartEnd::Enough);
            }
            Err(error) => return Err(error.into()),
        };
        if is_of_another_boot(board, &frame, &mut uptime_ms) {
            return Ok(PartEnd::Restarted);
        }
        writer.write_frames(&board.take_raw())?;
        if board.take_junk() && !wanted(News::Junk) {
            return Ok(PartEnd::Enough);
        }
        if matches!(frame.message, Message::Event(Event::Status(_))) {
            writer.flush()?;
        }
        let news = match &frame.message {
            Message::Event(event) => News::Event(event),
            Message::Input(Input::Limit {
                particles_per_sensor,
            }) => News::Limited {
                particles_per_sensor: *particles_per_sensor,
            },
            _ => continue,
        };
        if !wanted(news) {
            return Ok(PartEnd::Enough);
        }
    }
}

/// Configures the board; its frames from the one on that says that it is.
///
/// What it said before belongs to the run that it was amid.
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
        if let Message::Event(Event::Answer { input, refused }) = frame.message
            && input == sequence
        {
            return refused.map_or(Ok(frames), |fault| Err(LinkError::Refused(fault)));
        }
    }
    Err(LinkError::NoAnswer { input: 0 })
}

/// Whether the board was reset since it was greeted: its boot id says so, or, should
/// two boots share one, a clock that went back.
fn is_of_another_boot(board: &Board, frame: &Frame, uptime_ms: &mut u64) -> bool {
    let mut went_back = false;
    if let Message::Event(Event::Status(status)) = &frame.message {
        went_back = status.board.uptime_ms < *uptime_ms;
        *uptime_ms = status.board.uptime_ms;
    }
    board.boot_id() != Some(frame.boot_id) || went_back
}

fn is_gone(error: &LinkError) -> bool {
    matches!(error, LinkError::Gone | LinkError::Write(_))
}

/// Opens the link again, however long it takes; `false` when that is not wanted.
fn reconnect(
    board: &mut Board,
    error: &LinkError,
    wanted: &mut impl FnMut(News<'_>) -> bool,
) -> bool {
    let mut goes_on = wanted(News::Vanished(error));
    board.hang_up();
    let mut pause = FIRST_RETRY;
    while goes_on {
        let next = Instant::now() + pause;
        while goes_on && Instant::now() < next {
            let rest = next.saturating_duration_since(Instant::now());
            std::thread::sleep(rest.min(ASKED_EVERY));
            goes_on = wanted(News::Away);
        }
        if goes_on && board.reconnect().is_ok() {
            return wanted(News::Back);
        }
        pause = (2 * pause).min(LONGEST_RETRY);
    }
    false
}
