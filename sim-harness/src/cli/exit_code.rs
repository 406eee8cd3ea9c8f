//! The exit codes of the program, in one place.

use std::error::Error;
use std::process::ExitCode;

use sim_harness::console::{self, Printed};
use sim_harness::device::{LinkError, RecordError, ReplayError};

use super::{CommandResult, ExitStatus};

/// Each exit code and what it means; the help and `docs/faults.md` list the same.
pub(super) const EXIT_CODES: &str = "\
Exit codes:
  0  done; also record that was interrupted (SIGINT, SIGTERM) while it recorded, or whose
     board sent nothing for 2 s
  1  done, and what was to be shown does not hold: replay says DIFFERENT, offsets refused
     a sensor or no measurement was reported, image has problems, evaluate --check misses
     a threshold, experiments prints FAIL
  2  not done: a word, a file or a board that is of no use, a recording that leads to no
     step or whose odometry does not move, a drive of which map has nothing to map, or
     --strict of replay or map and a recording with something left out
  3  the board speaks another version of the protocol
  4  replay says EQUAL with particle messages lost: all digests were met, and the map is
     the host's own
  5  done, and the files are whole, but standard output could not be written
  6  the board was reset too often to be greeted or recorded; what was recorded is whole
130  interrupted while it used a board, before it was done";

/// The exit code of a command that ended.
///
/// A standard output that was closed changes nothing: `head` closes it on purpose.
pub(super) fn of(outcome: CommandResult) -> ExitCode {
    let code = match outcome {
        Ok(ExitStatus::Good) => 0,
        Ok(ExitStatus::Failed) => 1,
        Ok(ExitStatus::Refused) => 2,
        Ok(ExitStatus::ParticlesLost) => 4,
        Err(error) => {
            console::warn_text(format_args!("ipf: {error}"));
            // A board of another version is no mistake of the caller's.
            match link_error(&*error) {
                Some(LinkError::Version { .. }) => 3,
                Some(LinkError::Interrupted) => 130,
                Some(LinkError::KeepsResetting { .. }) => 6,
                _ if is_reset_too_often(&*error) => 6,
                _ => 2,
            }
        }
    };
    ExitCode::from(match (code, console::printed()) {
        (0, Printed::Failed) => 5,
        _ => code,
    })
}

fn is_reset_too_often(error: &(dyn Error + 'static)) -> bool {
    matches!(error.downcast_ref(), Some(RecordError::TooManyResets))
}

/// What is wrong with the link, whoever found it.
fn link_error<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a LinkError> {
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(RecordError::Link(error)), _) | (_, Some(ReplayError::Link(error))) => Some(error),
        _ => error.downcast_ref(),
    }
}
