//! The CAN bus of the robot: its messages and the controller of the unit CAN1.
//!
//! # Messages
//!
//! 1 Mbit/s, 11-bit identifiers, little-endian payloads. An identifier is the message's
//! device number and the sender's module number, `device << 3 | module`. This board reads
//! the DiWheelDrive's odometry and speeds, target speeds, the request to calibrate the
//! ring and the request to switch off. It sends the ring's eight readings, paced. Every
//! other frame is an [`IgnoredFrame`] with its reason. Numbers and layouts are those of
//! the robots' public firmware, generation 1.0, as facts.
//!
//! # Controller
//!
//! Every call of [`CanController`] reads and writes a few registers and returns; what
//! takes time is checked at the next [`CanController::poll`]. The crate `bxcan` does not
//! fit: several of its calls, leaving initialisation among them, wait until the unit
//! answers, which without a bus or in an emulator never happens.

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
