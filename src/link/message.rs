//! The messages of the link.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::report::{Boot, Status};
use crate::board::health::Health;
use crate::board::offsets::OffsetReport;
use crate::board::supervision::{PostMortem, Supervision};
use crate::geometry::Pose;
use crate::node::{Event, Input, InputError};

/// Bytes of a scenario in one truth message.
pub const SCENARIO_CHUNK: usize = 96;

/// Bytes of the faults' text in one truth message.
pub const FAULTS_CHUNK: usize = 96;

/// One message of the link, in either direction.
///
/// What the node takes and emits is one message each, [`Input`](Self::Input) and
/// [`Event`](Self::Event); all others are exchanged by the two ends of the link. The
/// bytes of each message are listed in `wire_format.rs`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Message {
    /// Host to board: asks for an introduction. The answer begins with a boot message.
    Hello,
    /// Host to board: measures the sensors' offsets, with nothing near the robot.
    Calibrate,
    /// Input of the node: from the host, or from the board's own sensors.
    Input(Input),
    /// Event of the node.
    Event(Event),
    /// Board to host: its introduction, after a reset and in answer to a hello.
    Boot(Boot),
    /// Board to host: the frame with this number was handled. Its events came before.
    Answer {
        /// Sequence number of the host's frame.
        input: u16,
        /// Why it was refused, if it was.
        refused: Option<InputError>,
    },
    /// Board to host: the state of node and board, at 8 Hz.
    Status(Status),
    /// Board to host: the state of sensors and buses, beside each status.
    Health(Health),
    /// Board to host: the sensors' offsets, after they were read, measured or refused.
    Offsets(OffsetReport),
    /// Board to host: how the boot before this one ended, after the boot message.
    PostMortem(PostMortem),
    /// Board to host: the state of the image, after a start and once per second.
    Supervision(Supervision),
    /// Simulator to host, in a recording only; a board refuses it.
    Truth(TruthMessage),
}

impl Message {
    /// Whether only a board sends such a message.
    ///
    /// A board also sends its own inputs, which are not distinguished from a host's.
    #[must_use]
    pub fn is_from_board(&self) -> bool {
        !matches!(
            self,
            Self::Hello | Self::Calibrate | Self::Input(_) | Self::Truth(_)
        )
    }
}

impl From<Input> for Message {
    fn from(input: Input) -> Self {
        Self::Input(input)
    }
}

impl From<Event> for Message {
    fn from(event: Event) -> Self {
        Self::Event(event)
    }
}

/// A message that is about to be encoded, without a copy of its contents.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "as the variants of Message")]
pub enum MessageRef<'a> {
    Hello,
    Calibrate,
    Input(&'a Input),
    Event(&'a Event),
    Boot(&'a Boot),
    Answer {
        input: u16,
        refused: Option<InputError>,
    },
    Status(&'a Status),
    Health(&'a Health),
    Offsets(&'a OffsetReport),
    PostMortem(&'a PostMortem),
    Supervision(&'a Supervision),
    Truth(&'a TruthMessage),
}

impl<'a> From<&'a Input> for MessageRef<'a> {
    fn from(input: &'a Input) -> Self {
        Self::Input(input)
    }
}

impl<'a> From<&'a Event> for MessageRef<'a> {
    fn from(event: &'a Event) -> Self {
        Self::Event(event)
    }
}

impl<'a> From<&'a Message> for MessageRef<'a> {
    fn from(message: &'a Message) -> Self {
        match message {
            Message::Hello => Self::Hello,
            Message::Calibrate => Self::Calibrate,
            Message::Input(input) => Self::Input(input),
            Message::Event(event) => Self::Event(event),
            Message::Boot(boot) => Self::Boot(boot),
            Message::Answer { input, refused } => Self::Answer {
                input: *input,
                refused: *refused,
            },
            Message::Status(status) => Self::Status(status),
            Message::Health(health) => Self::Health(health),
            Message::Offsets(offsets) => Self::Offsets(offsets),
            Message::PostMortem(record) => Self::PostMortem(record),
            Message::Supervision(state) => Self::Supervision(state),
            Message::Truth(truth) => Self::Truth(truth),
        }
    }
}

/// What only a simulator can report: true poses, the scenario, seeds, faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TruthMessage {
    /// The true pose of the robot.
    Pose {
        /// Time of the pose.
        stamp_us: u64,
        /// World frame.
        pose: Pose,
    },
    /// A piece of the scenario file, in order.
    Scenario(Vec<u8, SCENARIO_CHUNK, u8>),
    /// The seed of the simulation.
    Seed(u64),
    /// A piece of the text of the injected faults, in order.
    Faults {
        /// The seed of their random part; another seed begins another text.
        seed: u64,
        /// The piece.
        text: Vec<u8, FAULTS_CHUNK, u8>,
    },
}
