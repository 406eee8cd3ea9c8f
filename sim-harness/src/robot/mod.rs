//! A simulated robot: a world, its sensors, the parts on its buses, its acquisition.
//!
//! [`simulate_with`](crate::world::simulate_with) gives a node's inputs directly. A
//! [`Robot`] lets the core acquire them: the world's counts appear in the registers of the
//! eight sensors by the sensors' own clocks,
//! [`Acquisition`](amiro_ipf::board::acquisition::Acquisition) reads them over multiplexers
//! and buses, byte for byte, and the pose comes in the frames of the robot's bus.
//! [`ActiveFaults`](crate::faults::ActiveFaults) are injected. A [`SimulatedDrive`] is a
//! drive with its recording, with such a robot or without.
//!
//! Not modelled: the flash image's interrupts (a transaction waits for its end here), lost
//! samples other than by faults on the buses, and a frame's way over its bus.

mod bring_up;
mod bus_faults;
mod frames;
mod robot_drive;
mod sensed_world;
mod sensor_clock;
mod simulated;
mod simulated_drive;
mod wheel_module;

pub use bring_up::OFFSETS;
pub use robot_drive::{RobotDrive, drive};
pub use sensed_world::SensedWorld;
pub use sensor_clock::{PartClocks, SensorClocks};
pub use simulated::{AcquisitionReport, ReportContent, Robot, STARTS_DRIVING_US};
pub use simulated_drive::{SimulatedDrive, SimulationRefused};
