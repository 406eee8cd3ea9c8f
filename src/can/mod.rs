//! The AMiRo's CAN messages: what its modules say to each other, as frames.
//!
//! 1 Mbit/s, 11-bit identifiers, little-endian payloads. An identifier is the message's
//! device number and the sender's board number, `device << 3 | board`. What this board
//! reads: the DiWheelDrive's odometry and speeds, the speeds that somebody wants, the
//! call to calibrate the ring, the call to switch off. What it sends: the ring's eight
//! readings, paced. Everything else is [`Ignored`] with its reason.
//!
//! Numbers and layouts are those of the robots' public firmware, generation 1.0, as
//! facts; a controller that moves frames is the flash image's business.

mod encode;
mod frame;
mod identifier;
mod message;
mod schedule;
mod speed;
mod state;
mod transmitted;

pub use encode::{actual_speed, odometry, proximity_ring, scaled_above_offset, target_speed};
pub use frame::Frame;
pub use identifier::{Board, Identifier, StandardId};
pub use message::{Ignored, Message, READ};
pub use schedule::{CYCLE_US, LEAST_GAP_US, RingSchedule};
pub use speed::BodySpeed;
pub use state::CanState;
pub use transmitted::TransmittedPose;
