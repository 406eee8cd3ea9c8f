//! Whether the robot's footprint is free in a map.

use amiro_ipf::node::Config;
use clap::ValueEnum;
use sim_harness::rig::Rig;

/// Whether the cells under the robot's hull are free in the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FootprintSwitch {
    /// Cells whose centre has been under the hull are free.
    On,
    /// The map is what was counted, as in the paper.
    Off,
}

impl FootprintSwitch {
    /// Radius of the hull of a configuration's robot, metres; `None` when off.
    pub(super) fn radius_m(self, config: &Config) -> Option<f64> {
        match self {
            Self::On => Some(Rig::from(config).radius_m),
            Self::Off => None,
        }
    }
}
