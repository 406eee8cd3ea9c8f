//! Recordings and the formats of other robots.

#[path = "../common/mod.rs"]
mod common;

mod amiro;
mod datasets;
mod joined_recordings;
#[cfg(target_os = "linux")]
mod memory;
mod mutated_files;
mod nano_swarm;
mod player;
mod recordings;
mod sharp_ir;
mod stamps;
