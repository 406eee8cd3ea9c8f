//! Experiments of the papers on mapping: what they report, computed again.
//!
//! A servo scan ([`ServoScan`]) and flights of several drones ([`Flight`]) run the inverted
//! particle filter for range beams over recordings. The others are simulated: a
//! [`RangeWorld`] is measured by the sensors of a rig along a drive, and the records of the
//! drive are mapped by the methods that a paper compares ([`specular_room`], [`corridor`], [`two_sensors`]);
//! [`odometry_lap`] compares ways to compute a robot's pose.

mod check;
mod corridor;
mod error;
mod flight;
mod odometry_lap;
mod range_drive;
mod range_world;
mod report;
mod room_walls;
mod servo_scan;
mod servo_scan_study;
mod servo_sweep;
mod specular_room;
mod two_sensors;

pub use check::ExperimentCheck;
pub use corridor::corridor;
pub use error::ExperimentError;
pub use flight::{Drone, Flight, FlightFigures, FlightForm, FlightRun, RUNS};
pub use odometry_lap::odometry_lap;
pub use range_drive::{DriftingOdometry, poses_along, simulated_records};
pub use range_world::{RangeWorld, SonarEchoes};
pub use report::ExperimentReport;
pub use room_walls::RoomWalls;
pub use servo_scan::{MaximumRange, ServoParticle, ServoScan, ServoScanFigures, ServoScanRun};
pub use servo_scan_study::ServoScanStudy;
pub use servo_sweep::{ServoSweep, SweepReading, sweeps};
pub use specular_room::specular_room;
pub use two_sensors::two_sensors;
