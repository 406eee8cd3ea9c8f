//! The serial protocol: messages, frames, and the board's end of a link.
//!
//! `docs/protocol.md` is the specification; this code follows it. A change there
//! raises [`WIRE_VERSION`] in the same commit and adds a golden frame to
//! `tests/link/wire.rs`.

mod decoder;
mod device_endpoint;
mod frame;
mod loss_counter;
mod message;
mod report;
mod wire_format;

pub use decoder::{Decoder, Received};
pub use device_endpoint::{DeviceEndpoint, Priority};
pub use frame::{Encoder, Frame, FrameError, MAX_FRAME};

pub use loss_counter::LossCounter;
pub use message::{FAULTS_CHUNK, Message, MessageRef, SCENARIO_CHUNK, TruthMessage};
pub use report::{BoardStatus, Boot, Status};

/// Version of the messages, sent in every boot message.
pub const WIRE_VERSION: u8 = 4;

/// Inputs that a board takes ahead of their answers.
pub const WINDOW: u8 = 8;

const _: () = assert!(crate::board::budget::RECEIVE_QUEUE >= 2 * WINDOW as usize * MAX_FRAME);
