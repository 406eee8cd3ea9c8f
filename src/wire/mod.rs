//! The serial protocol: messages, frames, and the board's end of a link.
//!
//! `docs/protocol.md` is the specification; this code follows it. A change there
//! raises [`WIRE_VERSION`] in the same commit and adds a golden frame to
//! `tests/link/wire.rs`.

mod decoder;
mod frame;
mod losses;
mod message;
mod terminal;

pub use decoder::{Decoder, Received};
pub use frame::{Encoder, Frame, FrameError, MAX_FRAME};
pub use losses::Losses;
pub use message::{FAULTS_CHUNK, Message, Outgoing, SCENARIO_CHUNK, Truth};
pub use terminal::{Importance, Terminal};

/// Version of the messages; said in every boot event.
pub const WIRE_VERSION: u8 = 3;

/// Inputs that a board takes ahead of their answers.
pub const WINDOW: u8 = 8;
