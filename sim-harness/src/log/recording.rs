//! The contents of a source: a drive and its metadata.

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

/// One run: its configuration, its inputs and everything recorded with them.
///
/// Stamps of each kind of input never decrease within one sender's inputs, poses and
/// speeds are finite and the configuration is legal. A node may still refuse an input
/// that came too early: a reading without odometry near it, a tick before any reading, an
/// input that a host and a board both sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The configuration that the inputs were recorded under, if the source has one.
    pub config: Option<Config>,
    /// Odometry, wheel speeds, readings and ticks, in the order of the source.
    pub inputs: Vec<Input>,
    /// The simulator's ground truth; `None` for a real drive.
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
    /// The events of the board's node, in the order of the source.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.messages.iter().filter_map(|message| match message {
            Message::Event(event) => Some(event),
            _ => None,
        })
    }
}

/// The ground truth of a simulator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroundTruth {
    /// Seed of the simulation.
    pub seed: Option<u64>,
    /// The scenario file, as its text.
    pub scenario: Option<String>,
    /// The injected faults, each text with the seed of its random part.
    pub faults: Vec<(String, u64)>,
    /// The robot's true poses: stamps in microseconds, never decreasing. Empty in an
    /// [`Overview`](super::Overview).
    pub poses: Vec<(u64, Pose)>,
}
