//! The inverse sensor model for what lies near: readings of cones count as far as they are
//! right.

use super::scan_returns::mount_returns;
use super::{Belief, Grid, Map, Mapper};
use crate::drive::{RangeScan, Record, Return};
use crate::lattice::Lattice;
use crate::rig::Rig;
use crate::sensors::{Directivity, RangeSensor, View};

/// How a cone's readings are counted.
///
/// The constants belong to a sensor and a place: they were found on one run of a recording
/// each, and tried on others of the same robot in the same building.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearRangeParameters {
    /// Range below which a reading marks cells, metres (z_h).
    pub hits_below_m: f64,
    /// Distance below which cells before a reading are freed, metres (z_p).
    pub passes_below_m: f64,
    /// Hits that one pass on the axis outweighs (k). More: fewer cells are occupied, right
    /// and wrong ones.
    pub hits_per_pass: f64,
    /// Half width of the band about the reading that is marked, metres (beta).
    pub tolerance_m: f64,
    /// How fast a pass loses weight off the axis (k_p): exp(-k_p (theta / H)^2).
    pub pass_falloff: f64,
    /// How far beyond a reading cells of the cone are known, metres.
    pub margin_m: f64,
}

impl NearRangeParameters {
    /// Found on sonars of 25 degrees in an office corridor (recording `kcma`, run 1).
    pub const SONAR: Self = Self {
        hits_below_m: 1.6,
        passes_below_m: 1.4,
        hits_per_pass: 4.0,
        tolerance_m: 0.08,
        pass_falloff: 1.5,
        margin_m: 0.2,
    };

    /// Found on time-of-flight sensors of 45 degrees in a maze of boards (recording
    /// `nano_swarm`, run `exp1/two-drones`).
    pub const TIME_OF_FLIGHT: Self = Self {
        hits_below_m: 1.1,
        passes_below_m: 2.1,
        hits_per_pass: 4.0,
        tolerance_m: 0.04,
        pass_falloff: 0.0,
        margin_m: 0.1,
    };

    /// Those for sound, or those for light.
    #[must_use]
    pub const fn of(directivity: Directivity) -> Self {
        match directivity {
            Directivity::Piston => Self::SONAR,
            Directivity::Flat => Self::TIME_OF_FLIGHT,
        }
    }

    /// What a reading adds to a cell of its cone.
    fn score(&self, range_m: f64, bearing_share: f64, measured_m: f64) -> f64 {
        let beyond_m = range_m - measured_m;
        if beyond_m.abs() <= self.tolerance_m {
            f64::from(u8::from(measured_m < self.hits_below_m))
        } else if beyond_m < 0.0 && range_m < self.passes_below_m {
            -self.hits_per_pass * libm::exp(-self.pass_falloff * bearing_share * bearing_share)
        } else {
            0.0
        }
    }
}

/// Counts hits of near readings and passes of near cells.
///
/// For a reading z and a cell of its cone at the distance r and the bearing theta:
///
/// ```text
/// hit    z < z_h, |r - z| <= beta      S += 1
/// pass   r < z_p, r < z - beta         S -= k exp(-k_p (theta / H)^2)
/// ```
///
/// A cell is occupied if S > 0. Every other cell that lay in the cone of a reading is free,
/// those too far away for a count included: most cells are. Readings without an echo are
/// passed over, and scanners. The order of readings does not matter.
#[derive(Clone, Debug)]
pub struct NearRangeMapper {
    rig: Rig,
    /// S; `None` for a cell in no cone.
    scores: Grid<Option<f64>>,
}

impl NearRangeMapper {
    /// A mapper for the cones of a rig; the parameters follow from each cone's directivity.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, rig: &Rig) -> Self {
        Self {
            rig: rig.clone(),
            scores: Grid::new(lattice, None),
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Self { rig, scores } = self;
        let mut has_refused = false;
        for mounted in mount_returns(rig, scan) {
            let Some(cone) = mounted.mount.sensor.cone() else {
                continue;
            };
            let parameters = NearRangeParameters::of(cone.directivity);
            for measured in mounted.returns() {
                let Return::Echo { range_m, .. } = measured else {
                    continue;
                };
                let view = View {
                    index: 0,
                    measured,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: parameters.margin_m,
                    lattice: scores.lattice(),
                };
                has_refused |= !cone.footprint(&view, &mut |seen| {
                    let share = seen.bearing_rad / cone.half_angle_rad;
                    if let Some(held) = scores.reach(seen.cell) {
                        *held.get_or_insert(0.0) += parameters.score(seen.range_m, share, range_m);
                    }
                });
            }
        }
        if has_refused {
            scores.refuse();
        }
    }
}

impl Mapper for NearRangeMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn map(&self) -> Map {
        self.scores.map(Belief::UNKNOWN, |held| {
            held.map_or(Belief::UNKNOWN, Belief::of_score)
        })
    }
}

#[cfg(test)]
mod tests;
