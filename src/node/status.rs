//! The state of the node.

use serde::{Deserialize, Serialize};

use super::InputError;

/// The state of the node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeStatus {
    /// Steps since the configuration.
    pub steps: u32,
    /// Inputs handled since boot.
    pub inputs: u32,
    /// Inputs refused since boot.
    pub refused: u32,
    /// Why the last one was refused.
    pub last_fault: Option<InputError>,
    /// The sensors without counts in the last step, as a mask.
    pub without: u8,
    /// Nearest obstacle of the last step.
    pub obstacle: Option<Obstacle>,
    /// Whether the board makes its own ticks.
    pub own_ticks: bool,
}

/// The nearest obstacle among the particles past the gate, for a motion controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Obstacle {
    /// Distance from the robot's centre, metres.
    pub range_m: f32,
    /// Direction in the body frame, radians, within 0.004.
    pub bearing_rad: f32,
}
