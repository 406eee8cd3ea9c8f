//! Recording a robot that reads its own sensors.

use std::io::Write;
use std::time::{Duration, Instant};

use amiro_ipf::config::{Config, Source};
use amiro_ipf::event::Event;
use amiro_ipf::input::Input;
use amiro_ipf::wire::Message;

use super::board::ANSWER_DEADLINE;
use super::{Board, LinkError};
use crate::log::RecordingWriter;

/// How long a board that has said nothing may stay silent: it says how it is at 8 Hz.
const SILENCE: Duration = Duration::from_secs(2);

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

/// Starts a greeted board with a configuration, its own sensors as the source, and
/// writes whatever it says until `wanted` says that it is enough.
///
/// The recording begins with the configuration and holds the readings that the board
/// took from then on, so that it replays as any other. It is flushed at every status, eight times a
/// second: that much is lost when the host dies. `wanted` sees each event.
///
/// # Errors
/// [`LinkError::Silent`] after two seconds without a frame, [`LinkError::Restarted`]
/// when the board starts anew, a link or a file that fails.
pub fn record(
    board: &mut Board,
    config: &Config,
    writer: &mut RecordingWriter<impl Write>,
    mut wanted: impl FnMut(&Event) -> bool,
) -> Result<(), RecordError> {
    let own = Config {
        source: Source::Board,
        ..*config
    };
    let start = Input::Configure(own);
    writer.write_input(&start)?;
    writer.write_frames(&begin(board, &start)?)?;
    loop {
        let Some(frame) = board.receive_frame(Instant::now() + SILENCE)? else {
            return Err(LinkError::Silent.into());
        };
        if board.boot_id() != Some(frame.boot_id) {
            return Err(LinkError::Restarted { input: 0 }.into());
        }
        writer.write_frames(&board.take_raw())?;
        let Message::Event(event) = frame.message else {
            continue;
        };
        if matches!(event, Event::Status(_)) {
            writer.flush()?;
        }
        if !wanted(&event) {
            return Ok(());
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
