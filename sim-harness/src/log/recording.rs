//! What was read from a source: a drive, and what is known about it.

use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Event, Input};

use super::Refusals;

/// How a source was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// AMiRo's own text: a header, then eleven tab-separated integers a row.
    AmiroText,
    /// The bytes of the link: COBS frames between zero bytes.
    Stream,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::AmiroText => "AMiRo text",
            Self::Stream => "frames of the link",
        })
    }
}

/// One run: its configuration, inputs and what was recorded beside them.
///
/// Stamps of each kind of input never decrease within what one sender said, poses and
/// speeds are finite and the configuration is legal. A node may still refuse what came
/// too early: a reading without odometry near it, a tick before any reading, what a host
/// and a board both said.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The configuration that the inputs were recorded under, if the source has one.
    pub config: Option<Config>,
    /// Odometry, wheel speeds, readings and ticks, in the order of the source.
    pub inputs: Vec<Input>,
    /// What only a simulator knows; `None` for a real drive.
    pub truth: Option<GroundTruth>,
    /// The messages of a board, in the order of the source.
    pub messages: Vec<Message>,
    /// Lines and frames that were not used, with place and reason.
    pub refusals: Refusals,
    /// How the source was written.
    pub format: Format,
    /// Stretches without a gap of more than a second between inputs; 0 without inputs.
    pub segments: usize,
}

impl Recording {
    /// What the board's node emitted, in the order of the source.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.messages.iter().filter_map(|message| match message {
            Message::Event(event) => Some(event),
            _ => None,
        })
    }
}

/// What a simulator knows and a robot does not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroundTruth {
    /// Seed of the simulation.
    pub seed: Option<u64>,
    /// The scenario file, as its text.
    pub scenario: Option<String>,
    /// What was broken on purpose, each text with the seed of what was random about it.
    pub faults: Vec<(String, u64)>,
    /// Where the robot really was: stamps in microseconds, never decreasing. Empty in an
    /// [`Overview`](super::Overview).
    pub poses: Vec<(u64, Pose)>,
}
