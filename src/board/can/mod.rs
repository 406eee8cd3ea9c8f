//! The robot's bus: the controller of CAN1, without a wait.
//!
//! Everything here is bounded: a call reads and writes some registers and returns, and
//! what takes time is looked for at the next [`CanController::poll`]. The crate `bxcan`
//! does not serve: several of its calls, leaving initialisation among them, poll until
//! the unit answers, which without a bus or in an emulator is never.

mod bit_timing;
mod controller;
mod encode;
mod filters;
mod frame;
mod identifier;
mod mailboxes;
mod message;
mod registers;
mod schedule;
mod speed;
mod state;
mod transmitted;

pub use bit_timing::BitTiming;
pub use controller::{CanController, CanControllerHealth};
pub use encode::{actual_speed, odometry, proximity_ring, scaled_above_offset, target_speed};
pub use frame::CanFrame;
pub use identifier::{AmiroModule, CanIdentifier, StandardId};
pub use message::{CanMessage, IgnoredFrame, READ_IDS};
pub use registers::{CanRegister, CanRegisters};
pub use schedule::{CYCLE_US, LEAST_GAP_US, RingSchedule};
pub use speed::BodySpeed;
pub use state::CanState;
pub use transmitted::TransmittedPose;
