//! A simulated robot: a world before its sensors, the parts on its buses, its own senses.
//!
//! Where [`simulate_with`](crate::world::simulate_with) says what a node would be told,
//! a [`Robot`] has the core find it out: the world's counts are in the registers of the
//! eight sensors when their own clocks say so, [`Acquisition`](amiro_ipf::board::acquisition::Acquisition)
//! reads them over multiplexers and buses, byte for byte, and the pose comes in the
//! frames of the robot's bus. [`ActiveFaults`](crate::faults::ActiveFaults) break what can break.
//!
//! A [`SimulatedDrive`] is one with its recording, with a whole robot or without.
//!
//! Not modelled: what the flash image's interrupts do (a transaction waits for its end
//! here), lost samples other than by faults on the buses, and a frame's way over its bus.

mod bring_up;
mod bus_faults;
mod driven;
mod frames;
mod scene;
mod sensor_clock;
mod simulated;
mod simulated_drive;
mod wheel_module;

pub use bring_up::OFFSETS;
pub use driven::{RobotDrive, drive};
pub use scene::Scene;
pub use sensor_clock::{Rhythm, SensorClocks};
pub use simulated::{AcquisitionReport, ReportContent, Robot, STARTS_DRIVING_US};
pub use simulated_drive::{SimulatedDrive, SimulationRefused};
