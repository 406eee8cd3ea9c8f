//! A map from the readings of cones, under any calculus.

use super::{ConePlace, SonarModel};
use crate::drive::{RangeScan, Record, Return};
use crate::lattice::Lattice;
use crate::mapping::scan_returns::mount_returns;
use crate::mapping::{Belief, Calculus, Grid, Map, Mapper};
use crate::rig::Rig;
use crate::sensors::{RangeSensor, View};

/// Adds what readings of cones say about the cells in the cone to a calculus.
///
/// A cell is represented by its centre. Readings without an echo are passed over, and those
/// from [`SonarModel::rejected_from_m`] on. Scanners are passed over; an infrared sensor is
/// taken as its [`cone`](crate::sensors::Sensor::cone). Memory: one [`Calculus::Held`] per
/// cell of the reached tiles. Cost: the cells of the square about each sensor.
#[derive(Clone, Debug)]
pub struct ConeEvidenceMapper<C: Calculus> {
    rig: Rig,
    model: SonarModel,
    pub(super) calculus: C,
    /// What a reading says about a place.
    evidence: fn(&SonarModel, &ConePlace) -> C::Evidence,
    cells: Grid<C::Held>,
}

impl<C: Calculus> ConeEvidenceMapper<C> {
    /// A mapper for the cones of a rig with a form of evidence: [`SonarModel::occupancy`],
    /// [`SonarModel::masses`] or [`SonarModel::memberships`].
    #[must_use]
    pub fn new(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        calculus: C,
        evidence: fn(&SonarModel, &ConePlace) -> C::Evidence,
    ) -> Self {
        let lattice = lattice.into();
        Self {
            rig: rig.clone(),
            model: SonarModel::for_cells(lattice.cell_m()),
            evidence,
            cells: Grid::new(lattice, calculus.blank()),
            calculus,
        }
    }

    /// The evidence that the cells hold.
    #[must_use]
    pub fn cells(&self) -> &Grid<C::Held> {
        &self.cells
    }

    fn add(&mut self, scan: &RangeScan) {
        let Self {
            rig,
            model,
            calculus,
            evidence,
            cells,
        } = self;
        let mut has_refused = false;
        for mounted in mount_returns(rig, scan) {
            let Some(cone) = mounted.mount.sensor.cone() else {
                continue;
            };
            for measured in mounted.returns() {
                let Return::Echo { range_m, .. } = measured else {
                    continue;
                };
                if range_m >= model.rejected_from_m {
                    continue;
                }
                let view = View {
                    index: 0,
                    measured,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: model.band_m,
                    lattice: cells.lattice(),
                };
                has_refused |= !cone.footprint(&view, &mut |seen| {
                    let place = ConePlace {
                        range_m: seen.range_m,
                        bearing_share: seen.bearing_rad / cone.half_angle_rad,
                        measured_m: range_m,
                    };
                    if let Some(held) = cells.reach(seen.cell) {
                        calculus.update(held, evidence(model, &place));
                    }
                });
            }
        }
        if has_refused {
            cells.refuse();
        }
    }
}

impl<C: Calculus> Mapper for ConeEvidenceMapper<C> {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn map(&self) -> Map {
        let belief = |held: &C::Held| self.calculus.belief(held);
        self.cells.map(Belief::UNKNOWN, belief)
    }
}
