//! The inverse sensor model: log odds per cell from the ranges alone.
//!
//! Thrun, Burgard and Fox 2005, table 4.2; Carvalho and Ventura 2013, section II. Each
//! return adds to the log odds l = ln(p / (1 - p)) of a cell, from l = 0:
//!
//! ```text
//! at the echo       + weight l_occ
//! before it         - weight l_free
//! beyond it         nothing
//! ```
//!
//! A cell is represented by its centre. The weight is 1 on the sensor's axis (see
//! [`sensors`](crate::sensors)); with a decay length z_0 it is multiplied by 1 - z / z_0,
//! at least 0, where z is the measured range: far echoes of a wide cone are weaker evidence.
//!
//! Korthals et al. 2016 compare their filter with such a map, name their sources
//! (section 5, Stachniss and Haehnel) and print no formula. [`InverseSensorParameters`]
//! has the variants that the comparison is made with.

use super::{Belief, Calculus, Evidence, Grid, LogOdds, Map, Mapper, mount_returns};
use crate::drive::{RangeScan, Record};
use crate::lattice::Lattice;
use crate::rig::Rig;
use crate::sensors::{Region, View};

/// What a return without an echo counts as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoEcho {
    /// Free space up to the limit, nothing at it.
    Free,
    /// No evidence.
    Dropped,
    /// An object at the limit, as the raw distance has it.
    Object,
}

/// Evidence of one return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseSensorParameters {
    /// Log odds at the echo, on the sensor's axis (l_occ). More: thicker walls.
    pub occupied: f64,
    /// Log odds against occupied before the echo, on the axis (l_free). More: more
    /// readings are needed to turn a free cell into wall.
    pub free: f64,
    /// Least half width of the band in which an echo lies, cells (beta). Below 0.71 an
    /// arc may slip between the centres of cells.
    pub tolerance_cells: f64,
    /// What a return without an echo counts as.
    pub no_echo: NoEcho,
    /// Range at which an echo has no weight any more, metres (z_0); `None` gives all
    /// echoes the same weight.
    pub decay_m: Option<f64>,
    /// Largest magnitude of a cell's log odds.
    pub limit: f64,
}

impl InverseSensorParameters {
    /// The usual choice for proximity sensors: p = 0.70 on the arc, 0.40 before it.
    pub const STANDARD: Self = Self {
        occupied: 0.85,
        free: 0.40,
        tolerance_cells: 0.75,
        no_echo: NoEcho::Free,
        decay_m: None,
        limit: f64::INFINITY,
    };

    /// The best of some twenty choices on the paper's scenarios: p = 0.60 on the
    /// arc, 0.30 before. For lobes of 120 degrees most of an arc is no wall.
    pub const TUNED: Self = Self {
        occupied: 0.40,
        free: 0.85,
        ..Self::STANDARD
    };

    /// p = 0.7 at the echo, 0.3 before it, a band of a cell's size each way; returns
    /// without an echo are dropped, as Carvalho and Ventura 2013 do.
    pub const RANGE: Self = Self {
        // ln(0.7 / 0.3)
        occupied: 0.847_297_860_387_203_6,
        free: 0.847_297_860_387_203_6,
        tolerance_cells: 1.0,
        no_echo: NoEcho::Dropped,
        decay_m: None,
        limit: 20.0,
    };

    /// The same evidence with another rule for returns without an echo.
    #[must_use]
    pub const fn with(self, no_echo: NoEcho) -> Self {
        Self { no_echo, ..self }
    }

    /// The evidence of a region of a return; `None` for no evidence.
    fn evidence(&self, region: Region) -> Option<Evidence> {
        let is_occupied = match (region, self.no_echo) {
            (Region::AtEcho, _) => true,
            (Region::Before, _) => false,
            (_, NoEcho::Dropped) | (Region::AtLimit, NoEcho::Free) => return None,
            (Region::BeforeLimit, _) => false,
            (Region::AtLimit, NoEcho::Object) => true,
        };
        let weight = if is_occupied {
            self.occupied
        } else {
            self.free
        };
        Some(Evidence {
            is_occupied,
            weight,
        })
    }

    /// The weight of an echo at a range.
    fn decay(&self, range_m: f64) -> f64 {
        let share = |decay_m: f64| (1.0 - range_m / decay_m).max(0.0);
        self.decay_m.map_or(1.0, share)
    }
}

/// Adds up the log odds of all returns in a grid that is fixed in the world.
#[derive(Clone, Debug)]
pub struct InverseSensorMapper {
    rig: Rig,
    parameters: InverseSensorParameters,
    calculus: LogOdds,
    log_odds: Grid<f64>,
}

impl InverseSensorMapper {
    /// A mapper for the sensors of a rig, with cells of the given size, metres.
    #[must_use]
    pub fn new(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        parameters: InverseSensorParameters,
    ) -> Self {
        let calculus = LogOdds {
            limit: parameters.limit,
        };
        Self {
            rig: rig.clone(),
            parameters,
            calculus,
            log_odds: Grid::new(lattice, calculus.blank()),
        }
    }

    /// Adds the returns of a scan. Mounts that the rig does not have are left out.
    fn add(&mut self, scan: &RangeScan) {
        let Self {
            rig,
            parameters,
            calculus,
            log_odds,
        } = self;
        let mut has_refused = false;
        for mounted in mount_returns(rig, scan) {
            let model = mounted.mount.sensor.model();
            for (index, measured) in mounted.recorded().enumerate() {
                let view = View {
                    index,
                    measured,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: parameters.tolerance_cells * log_odds.cell_m(),
                    lattice: log_odds.lattice(),
                };
                has_refused |= !model.footprint(&view, &mut |seen| {
                    let Some(mut evidence) = parameters.evidence(seen.region) else {
                        return;
                    };
                    evidence.weight *= seen.weight * parameters.decay(seen.measured_m);
                    if let Some(held) = log_odds.reach(seen.cell) {
                        calculus.update(held, evidence);
                    }
                });
            }
        }
        if has_refused {
            log_odds.refuse();
        }
    }
}

impl Mapper for InverseSensorMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn map(&self) -> Map {
        self.log_odds
            .map(Belief::UNKNOWN, |held| self.calculus.belief(held))
    }
}

#[cfg(test)]
mod tests;
