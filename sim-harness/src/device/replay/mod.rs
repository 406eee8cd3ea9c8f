//! Replays of recordings, on the host's node or on a board.

mod board;
mod error;
mod host;
mod plan;
mod replayed;
mod stream;

pub use board::replay_on_board;
pub use error::ReplayError;
pub use host::replay_on_host;
pub use plan::{ReplayPass, ReplayPlan};
pub use replayed::{KeptEvents, Replayed, StepCycles};
