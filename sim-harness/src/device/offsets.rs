//! Measures the sensors' offsets with a board and formats its report.

use std::fmt::Write;
use std::time::{Duration, Instant};

use amiro_ipf::board::offsets::{OffsetOrigin, OffsetReport};
use amiro_ipf::link::Message;

use super::{Board, LinkError, drive};

/// How long a measurement may take: 40 rounds at 125 Hz are 0.32 s.
const PATIENCE: Duration = Duration::from_secs(5);

/// Has a greeted board measure its sensors' offsets; `None` when no measurement was
/// reported within five seconds.
///
/// The report of a board without working sensors refuses each
/// sensor. A report that neither holds measured offsets nor refuses a sensor, such as that
/// of the memory's offsets after a start, is no measurement and is skipped.
///
/// # Errors
/// [`LinkError::NoAnswer`], [`LinkError::Refused`], [`LinkError::Restarted`]; a broken
/// link.
pub fn measure_offsets(board: &mut Board) -> Result<Option<OffsetReport>, LinkError> {
    let mut refusal = None;
    drive(
        board,
        &[Message::Calibrate],
        |_| (),
        |_, refused| refusal = refused,
    )?;
    if let Some(fault) = refusal {
        return Err(LinkError::Refused(fault));
    }
    let deadline = Instant::now() + PATIENCE;
    while let Some(frame) = board.receive_frame(deadline)? {
        if board.boot_id() != Some(frame.boot_id) {
            return Err(LinkError::Restarted { input: 0 });
        }
        if let Message::Offsets(report) = frame.message
            && is_of_a_measurement(&report)
        {
            return Ok(Some(report));
        }
    }
    Ok(None)
}

/// Whether a report is the outcome of a measurement, good or not.
fn is_of_a_measurement(report: &OffsetReport) -> bool {
    report.offsets.origin == OffsetOrigin::Measured || report.refused.iter().any(Option::is_some)
}

/// The offsets in use, their origin, and each refused sensor on a line of its own; the last
/// line has no line end.
#[must_use]
pub fn offsets_in_words(report: &OffsetReport) -> String {
    let counts = report.offsets.counts.map(|count| count.to_string());
    let origin = match report.offsets.origin {
        OffsetOrigin::Defaults => "defaults",
        OffsetOrigin::Stored => "stored",
        OffsetOrigin::Measured => "measured",
    };
    let kept = if report.is_kept { "kept" } else { "not kept" };
    let mut words = format!(
        "offsets of sensors 0 to 7: {} counts\n{origin}, {kept} in the board's memory",
        counts.join(" ")
    );
    for (sensor, refusal) in report.refused.iter().enumerate() {
        if let Some(refusal) = refusal {
            // Writing to a string does not fail.
            let _ = write!(words, "\nsensor {sensor} refused: {refusal}");
        }
    }
    words
}
