//! Drives to maps.

#[path = "../common/mod.rs"]
mod common;

mod beam_particles;
mod drive_by;
mod experiments;
mod likelihood_methods;
mod recorded_drives;
mod recorded_walls;
mod standstill;
mod wall_map;
mod wall_segments;
