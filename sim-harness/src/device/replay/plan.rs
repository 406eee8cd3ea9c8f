//! How a recording is replayed.

use amiro_ipf::node::{Config, Input};

use super::ReplayError;
use crate::faults::Faults;
use crate::log::Overview;
use crate::{RunRecord, TICK_PERIOD_US, Ticked};

/// How a recording is replayed, wherever the filter runs.
#[derive(Clone, Copy, Debug)]
pub struct ReplayPlan<'a> {
    /// The configuration in force.
    pub config: &'a Config,
    /// Whether the configuration is the recorded one.
    pub is_recorded_config: bool,
    /// Whether the filter gets ticks at a fixed rate.
    pub is_fixed: bool,
    /// What is broken: of the recorded inputs, and of the line behind the filter.
    pub faults: &'a Faults,
    /// Seed of what is random about the faults.
    pub seed_of_faults: u64,
    /// Size of the map's cells, metres.
    pub cell_m: f64,
    /// Radius of the hull whose footprint is free in the map, metres, if any.
    pub hull_radius_m: Option<f64>,
    /// Whether the events are kept for the scores on the way.
    pub is_scored: bool,
}

/// A pass over the recording, as progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayPass {
    /// The inputs go through the filter.
    Replay,
    /// The recorded messages are compared.
    Compare,
}

impl ReplayPlan<'_> {
    /// Whether the filter runs as it did when it was recorded, and its steps were recorded.
    pub(super) fn is_compared(&self, overview: &Overview) -> bool {
        let is_recorded = overview.config.is_some() && overview.steps > 0;
        is_recorded && self.is_recorded_config && self.faults.parts().is_empty()
    }

    pub(super) fn has_line_faults(&self) -> bool {
        !self.faults.line().is_empty()
    }

    /// The recorded inputs with the faults and ticks that were asked for.
    pub(super) fn inputs<'a>(
        &self,
        inputs: impl Iterator<Item = Input> + 'a,
    ) -> Result<Box<dyn Iterator<Item = Input> + 'a>, ReplayError> {
        let faulty = self.faults.on_stream(self.seed_of_faults, inputs)?;
        Ok(if self.is_fixed {
            Box::new(Ticked::new(faulty, TICK_PERIOD_US))
        } else {
            Box::new(faulty)
        })
    }

    /// An empty run record.
    pub(super) fn run_record(&self) -> RunRecord {
        RunRecord::new(self.config, self.cell_m, self.hull_radius_m)
    }
}
