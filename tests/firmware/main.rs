//! The flash image: what it is built from, what is flashed, what reading the robot costs.

#[path = "../common/mod.rs"]
mod common;

mod build_id;
mod hardware;
mod image;
mod sampling;
