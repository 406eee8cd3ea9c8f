//! Why a replay ended before its recording did.

use std::io;

use crate::RunError;
use crate::device::LinkError;
use crate::faults::NotOnInputs;
use crate::log::LogError;

/// Why a replay ended before its recording did.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be read again.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The host's node did not begin.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The board is of no use.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A fault that cannot be seen in a recording's inputs.
    #[error(transparent)]
    Fault(#[from] NotOnInputs),
    /// A temporary file failed.
    #[error(transparent)]
    Spool(#[from] io::Error),
}
