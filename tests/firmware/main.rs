//! The flash image: what it is built from, what reading the robot costs.

#[path = "../common/mod.rs"]
mod common;

mod beam_filter_cost;
mod budget;
mod build_id;
mod hardware;
mod sampling;
