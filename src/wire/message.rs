//! The messages: what either end may say, and what only a host reads.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::event::Event;
use crate::geometry::Pose;
use crate::input::Input;

/// Bytes of a scenario in one truth message.
pub const SCENARIO_CHUNK: usize = 96;

/// Bytes of the faults' text in one truth message.
pub const FAULTS_CHUNK: usize = 96;

/// One message. Variants are appended, never reordered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Message {
    /// To the board.
    Input(Input),
    /// From the board.
    Event(Event),
    /// Beside them in a simulated recording; a board refuses it.
    Truth(Truth),
}

/// A message that is about to be encoded: the same bytes as a [`Message`], no copy.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum Outgoing<'a> {
    /// As [`Message::Input`].
    Input(&'a Input),
    /// As [`Message::Event`].
    Event(&'a Event),
    /// As [`Message::Truth`].
    Truth(&'a Truth),
}

impl<'a> From<&'a Message> for Outgoing<'a> {
    fn from(message: &'a Message) -> Self {
        match message {
            Message::Input(input) => Self::Input(input),
            Message::Event(event) => Self::Event(event),
            Message::Truth(truth) => Self::Truth(truth),
        }
    }
}

/// What a simulator knows and a robot does not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Truth {
    /// Where the robot really was.
    Pose {
        /// When.
        stamp_us: u64,
        /// World frame.
        pose: Pose,
    },
    /// A piece of the scenario file, in order.
    Scenario(Vec<u8, SCENARIO_CHUNK, u8>),
    /// The seed of the simulation.
    Seed(u64),
    /// A piece of the text of what was broken on purpose, in order.
    Faults {
        /// The seed of what was random about that; another seed begins another text.
        seed: u64,
        /// The piece.
        text: Vec<u8, FAULTS_CHUNK, u8>,
    },
}
