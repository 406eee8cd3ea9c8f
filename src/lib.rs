//! The inverse particle filter of Korthals et al. 2016 for the AMiRo robot.
//!
//! The AMiRo has a ring of eight infrared proximity sensors. Each is cheap,
//! short-ranged and ambiguous over 120 degrees. The filter estimates where surfaces
//! are: each particle is the hypothesis that its position is on a surface. It moves
//! against the robot's motion, is weighed by the sensors' inverse model, and survives
//! or is rejected and drawn again from the current readings. Survivors and rejected
//! particles, counted into a grid, are a map.
//!
//! # The layers
//!
//! Data flow in one direction:
//!
//! ```text
//! counts, odometry -> Input -> Node::handle -> InverseParticleFilter::step -> Event -> frame
//! ```
//!
//! Each layer imports only the layers above it in this list:
//!
//! - [`math`], [`geometry`], [`random`], [`checksum`]: numbers; the only float
//!   functions, the only randomness.
//! - [`model`]: the sensor ring, its photometric law and the inverse kinematics (paper
//!   sections 4.3 and 4.4).
//! - [`filter`]: Algorithms 1 and 2. It has no time, no clock and no link.
//! - [`beam_filter`]: the inverted particle filter for range beams (laser, time of
//!   flight) of Kleppe and Skavhaug 2013. It has no time and no clock.
//! - [`dead_reckoning`]: corrected wheels and a Kalman filter with a compass, of Ivanjko,
//!   Petrovic and Macek 2003.
//! - [`node`]: the portable program from inputs to events: configuration, odometry,
//!   step trigger, sample window.
//! - [`board`]: the robot's board over register traits. Its I2C masters and sensors give
//!   proximity inputs, its CAN controller odometry inputs; offsets, health and
//!   supervision belong to it.
//! - [`link`]: messages, frames and the device endpoint; specified in
//!   `docs/protocol.md`.
//!
//! # What holds everywhere
//!
//! 1. Same configuration and inputs give the same events, byte for byte, on a host,
//!    in the flash image and in an emulator.
//! 2. The core reads no clock, no pin, no global and no random device.
//! 3. No heap, no panic, no unbounded loop.
//! 4. SI units: metres, seconds, radians, counts; stamps in microseconds. x forward,
//!    y left, counter-clockwise positive.
//!
//! # Features
//!
//! - `std` (default): conveniences for a host; inert on the target.
//! - `defmt` (default): formats for logging from the firmware.
//! - `amiro-layout`: links the flash image behind AMiRo's boot loader.
//!
//! # Example
//!
//! ```
//! use amiro_ipf::filter::{ParticleSet, Profile};
//! use amiro_ipf::geometry::Pose;
//! use amiro_ipf::model::Sample;
//! use amiro_ipf::node::{Config, Event, Input, Node};
//!
//! let mut particles = ParticleSet::<800>::new();
//! let mut node = Node::new(&mut particles);
//! let config = Config { particles_per_sensor: 100, ..Config::amiro(Profile::Plus) };
//! let mut steps = 0;
//! let mut count = |event: &Event| steps += u32::from(matches!(event, Event::StepDone(_)));
//! node.handle(&Input::Configure(config), &mut count)?;
//! // Ten centimetres of straight driving with a wall on the left.
//! for millimetre in 0..=100 {
//!     let stamp_us = millimetre * 12_500;
//!     let pose = Pose::new(millimetre as f32 * 1e-3, 0.0, 0.0);
//!     let mut samples = [Sample::Counts(0); 8];
//!     samples[1] = Sample::Counts(110);
//!     samples[2] = Sample::Counts(110);
//!     node.handle(&Input::Odometry { stamp_us, pose }, &mut count)?;
//!     node.handle(&Input::Proximity { stamp_us, samples }, &mut count)?;
//! }
//! // One step at the start, one per 10 mm.
//! assert_eq!(steps, 11);
//! # Ok::<(), amiro_ipf::node::InputError>(())
//! ```
//!
//! Minimum supported Rust version: 1.90.

#![cfg_attr(all(not(test), any(not(feature = "std"), target_os = "none")), no_std)]
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing)
)]

pub mod beam_filter;
pub mod board;
pub mod checksum;
pub mod dead_reckoning;
pub mod filter;
pub mod geometry;
pub mod link;
pub mod math;
pub mod model;
pub mod node;
pub mod random;

/// Whether this build has the feature `std`, and a host to use it on.
///
/// For a test that proves a build without default features to be one.
pub const HAS_STD: bool = cfg!(all(feature = "std", not(target_os = "none")));

/// Hash of the sources that this build was made from; in every boot message.
///
/// Equal on a host and in a flash image exactly when both were built from the same
/// core, firmware and lock file.
pub const BUILD_ID: u64 = build_id();

#[expect(
    clippy::panic,
    reason = "evaluated by the compiler, never on the target"
)]
const fn build_id() -> u64 {
    match u64::from_str_radix(env!("AMIRO_IPF_BUILD_ID"), 16) {
        Ok(id) => id,
        Err(_) => panic!("build.rs wrote a build id that is no number"),
    }
}
