//! Recordings and the formats of other robots.

#[path = "../common/mod.rs"]
mod common;

mod datasets;
mod joined_recordings;
mod recordings;
mod stamps;
