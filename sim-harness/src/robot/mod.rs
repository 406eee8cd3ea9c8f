//! A simulated robot: a world before its sensors, the parts on its buses, its own senses.
//!
//! Where [`simulate_with`](crate::world::simulate_with) says what a node would be told,
//! a [`Robot`] has the core find it out: the world's counts are in the registers of the
//! eight sensors when their own clocks say so, [`Acquisition`](amiro_ipf::board::acquisition::Acquisition)
//! reads them over multiplexers and buses, byte for byte, and the pose comes in the
//! frames of the robot's bus. [`ActiveFaults`](crate::faults::ActiveFaults) break what can break.
//!
//! [`SensorFaultTrials`] measure what a broken sensor costs a map, [`StampTrials`] what
//! it costs that a frame does not say when its pose was true.
//!
//! Not modelled: what the flash image's interrupts do (a transaction waits for its end
//! here), lost samples other than by faults on the buses, and a frame's way over its bus.

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

/// What a profile is called in tables.
const fn profile_name(profile: Profile) -> &'static str {
    match profile {
        Profile::Paper => "paper",
        Profile::Plus => "plus",
    }
}
