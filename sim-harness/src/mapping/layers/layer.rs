//! The evidence of one kind of sensor.

use crate::drive::{RangeScan, Return};
use crate::lattice::{Cell, Lattice};
use crate::mapping::scan_returns::{MountReturns, mount_returns};
use crate::mapping::{Calculus, Evidence, Grid, LogOdds, NoEcho};
use crate::rig::Rig;
use crate::sensors::{Region, SeenCell, Sensor, SensorKind, View};

/// Evidence of one observation of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerParameters {
    /// Log odds of one hit, and of one pass with the other sign. More: a layer saturates
    /// after fewer observations, and wins over others earlier.
    pub hit: f64,
    /// Largest magnitude of a cell's log odds.
    pub limit: f64,
    /// Range of a scanner up to which echoes count, metres; a beam that measures farther
    /// passes the cells up to there.
    pub scanner_reach_m: f64,
    /// Distance before the end of a beam within which cells are not passed, metres: a beam
    /// that meets a wall at a grazing angle touches its cells before it ends in one.
    pub scanner_tolerance_m: f64,
    /// What a return of a scanner without an echo counts as: [`NoEcho::Free`] or nothing.
    pub scanner_no_echo: NoEcho,
    /// The same of a cone.
    pub cone_no_echo: NoEcho,
}

impl LayerParameters {
    /// p(hit | occupied) = p(no hit | free) = 0.55, the first as the source prints it.
    ///
    /// With a tolerance of 0 the walls of the drones' maze (recording `nano_swarm`, cells of
    /// 0.05 m) are found at a rate of 0.57, with 0.05 m at 0.66; those of the corridor
    /// (`kcma`, cells of 0.10 m) at 0.78 and 0.79.
    pub const LEE: Self = Self {
        // ln(0.55 / 0.45)
        hit: 0.200_670_695_462_151_1,
        limit: 20.0,
        scanner_reach_m: 8.0,
        scanner_tolerance_m: 0.05,
        scanner_no_echo: NoEcho::Free,
        cone_no_echo: NoEcho::Dropped,
    };
}

/// The log odds that one kind of sensor gives the cells.
///
/// A scan gives a cell at most one hit and, if it has none, at most one pass, however many
/// of its beams meet the cell. A scanner hits the cell that holds the end of a beam and
/// passes those before it, up to the tolerance; a cone hits the cells within a cell's size
/// of the measured range and passes those before them.
#[derive(Clone, Debug)]
pub struct SensorLayer {
    kind: SensorKind,
    parameters: LayerParameters,
    calculus: LogOdds,
    log_odds: Grid<f64>,
}

impl SensorLayer {
    /// An empty layer of a kind of sensor.
    #[must_use]
    pub fn new(lattice: Lattice, kind: SensorKind, parameters: LayerParameters) -> Self {
        let calculus = LogOdds {
            limit: parameters.limit,
        };
        Self {
            kind,
            parameters,
            calculus,
            log_odds: Grid::new(lattice, calculus.blank()),
        }
    }

    /// The kind of sensor.
    #[must_use]
    pub fn kind(&self) -> SensorKind {
        self.kind
    }

    /// The log odds of the cells.
    #[must_use]
    pub fn log_odds(&self) -> &Grid<f64> {
        &self.log_odds
    }

    /// Probability that a cell is free; 0.5 where the layer has no cell.
    #[must_use]
    pub fn free(&self, cell: Cell) -> f64 {
        let log_odds = self.log_odds.get(cell).copied().unwrap_or_default();
        1.0 / (1.0 + libm::exp(log_odds))
    }

    /// Adds the returns of a scan; those of other kinds of sensors are passed over.
    pub(super) fn add(&mut self, rig: &Rig, scan: &RangeScan) {
        for mounted in mount_returns(rig, scan) {
            if mounted.mount.sensor.kind() == self.kind {
                self.add_mount(&mounted);
            }
        }
    }

    fn add_mount(&mut self, mounted: &MountReturns<'_>) {
        let (mut hits, mut passes) = (Vec::new(), Vec::new());
        let mut has_refused = false;
        for (index, measured) in mounted.returns().enumerate() {
            let Some((measured, tolerance_m)) = self.counted(&mounted.mount.sensor, measured)
            else {
                continue;
            };
            let view = View {
                index,
                measured,
                world_from_sensor: mounted.world_from_sensor,
                tolerance_m,
                lattice: self.log_odds.lattice(),
            };
            let model = mounted.mount.sensor.model();
            has_refused |=
                !model.footprint(&view, &mut |SeenCell { cell, region, .. }| match region {
                    Region::AtEcho => hits.push(cell),
                    Region::Before | Region::BeforeLimit => passes.push(cell),
                    Region::AtLimit => {}
                });
        }
        for cells in [&mut hits, &mut passes] {
            cells.sort_unstable();
            cells.dedup();
        }
        passes.retain(|cell| hits.binary_search(cell).is_err());
        self.count(&hits, true);
        self.count(&passes, false);
        if has_refused {
            self.log_odds.refuse();
        }
    }

    /// The return as this layer counts it, and the half width of the band of its echo;
    /// `None` for no evidence.
    fn counted(&self, sensor: &Sensor, measured: Return) -> Option<(Return, f64)> {
        let no_echo = match sensor {
            Sensor::Scanner(_) => self.parameters.scanner_no_echo,
            Sensor::Cone(_) | Sensor::Infrared(_) => self.parameters.cone_no_echo,
        };
        if !matches!(sensor, Sensor::Scanner(_)) {
            let is_dropped = matches!(measured, Return::NoEcho { .. }) && no_echo != NoEcho::Free;
            return (!is_dropped).then_some((measured, self.log_odds.cell_m()));
        }
        let reach_m = self.parameters.scanner_reach_m;
        // The tolerance is that of the parameters, whatever the standard deviation.
        let sigma_m = 0.0;
        let passed = |limit_m: f64| {
            let limit_m = limit_m.min(reach_m);
            Some((Return::NoEcho { limit_m, sigma_m }, 0.0))
        };
        match measured {
            Return::Echo { range_m, .. } if range_m < reach_m => {
                let echo = Return::Echo { range_m, sigma_m };
                Some((echo, self.parameters.scanner_tolerance_m))
            }
            Return::Echo { range_m, .. } => passed(range_m),
            Return::NoEcho { limit_m, .. } if no_echo == NoEcho::Free => passed(limit_m),
            Return::NoEcho { .. } | Return::TooClose | Return::Invalid => None,
        }
    }

    fn count(&mut self, cells: &[Cell], is_occupied: bool) {
        let weight = self.parameters.hit;
        for cell in cells {
            if let Some(held) = self.log_odds.reach(*cell) {
                let evidence = Evidence {
                    is_occupied,
                    weight,
                };
                self.calculus.update(held, evidence);
            }
        }
    }
}
