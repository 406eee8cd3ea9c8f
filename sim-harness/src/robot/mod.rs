//! A simulated robot: a world, its sensors, the parts on its buses, its acquisition.
//!
//! [`simulate_with`](crate::world::simulate_with) gives a node's inputs directly. A
//! [`Robot`] lets the core acquire them: the world's counts appear in the registers of the
//! eight sensors by the sensors' own clocks,
//! [`Acquisition`](amiro_ipf::board::acquisition::Acquisition) reads them over multiplexers
//! and buses, byte for byte, and the pose comes in the frames of the robot's bus.
//! [`ActiveFaults`](crate::faults::ActiveFaults) are injected.
//!
//! [`SensorFaultTrials`] measure the effect of a broken sensor on a map, [`StampTrials`]
//! the effect of odometry frames without stamps.
//!
//! Not modelled: the flash image's interrupts (a transaction waits
//! for its end here), lost samples other than by faults on the buses, and a frame's way
//! over its bus.

mod bring_up;
mod bus_faults;
mod frames;
mod node_run;
mod robot_drive;
mod sensed_world;
mod sensor_clock;
mod sensor_faults;
mod simulated;
mod stamps;
mod wheel_module;

pub use bring_up::OFFSETS;
pub use node_run::{NodeRun, map};
pub use robot_drive::{RobotDrive, drive};
pub use sensed_world::SensedWorld;
pub use sensor_clock::{PartClocks, SensorClocks};
pub use sensor_faults::{SensorBreak, SensorFaultRow, SensorFaultTrials};
pub use simulated::{AcquisitionReport, ReportContent, Robot, STARTS_DRIVING_US};
pub use stamps::{StampRow, StampTrials};

use amiro_ipf::filter::Profile;

/// The name of a profile in tables.
const fn profile_name(profile: Profile) -> &'static str {
    match profile {
        Profile::Paper => "paper",
        Profile::Plus => "plus",
    }
}
