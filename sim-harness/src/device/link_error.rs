//! The errors of the link to a board.

use std::fmt;

use amiro_ipf::link::WIRE_VERSION;
use amiro_ipf::node::InputError;

use super::board::{ANSWER_DEADLINE, BOOT_DEADLINE};

/// Why a board cannot be used.
#[derive(Debug)]
pub enum LinkError {
    /// It could not be started or opened.
    Start(String),
    /// More than half of its bytes are no frames.
    MostlyNoise,
    /// Writing to it failed.
    Write(std::io::Error),
    /// It closed the stream: the device is gone, not silent.
    Gone,
    /// The user ended the program: see [`Interrupt`](super::Interrupt).
    Interrupted,
    /// It sent no valid frame within the deadline.
    NoBoot,
    /// Answers came within the deadline, and none to this session's greeting.
    OtherSession,
    /// It has another version of the protocol.
    Version {
        /// The board's version.
        board: u8,
    },
    /// It left an input without an answer within the deadline.
    NoAnswer {
        /// Which input, from 0.
        input: usize,
    },
    /// It sent nothing within the deadline.
    Silent,
    /// It refused the configuration.
    Refused(InputError),
    /// It was reset repeatedly while it was greeted.
    KeepsResetting {
        /// How often.
        resets: u32,
    },
    /// It was reset in the middle of a run, which loses its state.
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
            Self::MostlyNoise => f.write_str(
                "more than half of what comes is no frame: this looks like a wrong baud rate",
            ),
            Self::Gone => f.write_str("the board closed the link"),
            Self::Interrupted => f.write_str("interrupted"),
            Self::NoBoot => write!(
                f,
                "the board did not introduce itself within {} s (wrong port or baud rate?)",
                BOOT_DEADLINE.as_secs()
            ),
            Self::OtherSession => write!(
                f,
                "no answer to this session's greeting within {} s: what comes answers an \
                 earlier session or another host",
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
            Self::Refused(fault) => {
                write!(f, "the board refused what it was told: {fault:?}, {fault}")
            }
            Self::Silent => f.write_str("the board fell silent"),
            Self::KeepsResetting { resets } => {
                write!(f, "the board was reset {resets} times while it was greeted")
            }
            Self::Restarted { input } => {
                write!(f, "the board started anew before it answered input {input}")
            }
        }
    }
}

impl std::error::Error for LinkError {}
