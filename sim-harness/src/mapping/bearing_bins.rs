//! Hits and passes counted per bearing, for sonars that must be believed near by only.

use super::scan_returns::mount_returns;
use super::{Belief, Grid, Map, Mapper};
use crate::drive::{RangeScan, Record, Return};
use crate::lattice::Lattice;
use crate::rig::Rig;
use crate::sensors::{Cone, Directivity, RangeSensor, SeenCell, View};

/// How a cone's readings are counted.
///
/// The constants belong to a sensor and a place, as those of
/// [`NearRangeParameters`](super::NearRangeParameters).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BearingBinParameters {
    /// Bins of bearing around a cell (NB), at least 3.
    pub bins: usize,
    /// Distance at which a cell is trusted half as much as at the sensor, metres (r_0).
    pub trust_range_m: f64,
    /// How sharply the trust falls there, metres (w_r).
    pub trust_width_m: f64,
    /// Half width of the band about a reading that is hit, metres (beta).
    pub tolerance_m: f64,
    /// How fast a hit loses weight off the axis (k_hit).
    pub hit_falloff: f64,
    /// How fast a pass does (k_pass).
    pub pass_falloff: f64,
    /// Most that the hits of a bin count (c_h).
    pub most_hits: f32,
    /// Most that the passes of a bin count (c_p).
    pub most_passes: f32,
    /// Weight of a pass from where there was no hit (k_0).
    pub pass_weight: f32,
    /// Weight of a pass from where there were hits (k_1): a wall that was seen from there
    /// and is not seen any more.
    pub contradicting_pass_weight: f32,
    /// Hits from about a bearing that count as a wall seen from there (h_s).
    pub support_hits: f32,
    /// Score above which a cell is occupied: the one of least error (OE).
    pub threshold: f64,
    /// Distance up to which a reading without an echo passes, metres.
    pub no_echo_passes_m: f64,
    /// How far beyond a reading cells of the cone are known, metres.
    pub margin_m: f64,
}

impl BearingBinParameters {
    /// Found on sonars of 25 degrees in an office corridor (recording `kcma`, run 1). With
    /// the threshold 3.4e-5 a share of 0.04 of the free cells is called occupied.
    pub const SONAR: Self = Self {
        bins: 24,
        trust_range_m: 0.384,
        trust_width_m: 0.272,
        tolerance_m: 0.080,
        hit_falloff: 0.271,
        pass_falloff: 0.191,
        most_hits: 0.329,
        most_passes: 0.321,
        pass_weight: 0.512,
        contradicting_pass_weight: 1.747,
        support_hits: 0.608,
        threshold: 0.0443,
        no_echo_passes_m: 3.0,
        margin_m: 0.2,
    };

    /// Found on time-of-flight sensors of 45 degrees in a maze of boards (recording
    /// `nano_swarm`, run `exp1/two-drones`). The threshold for the share of 0.04 is -4.689.
    pub const TIME_OF_FLIGHT: Self = Self {
        bins: 12,
        trust_range_m: 2.115,
        trust_width_m: 0.183,
        tolerance_m: 0.038,
        hit_falloff: 4.874,
        pass_falloff: 0.481,
        most_hits: 17.5,
        most_passes: 74.2,
        pass_weight: 0.878,
        contradicting_pass_weight: 3.959,
        support_hits: 0.220,
        threshold: -1.584,
        no_echo_passes_m: 3.0,
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

    /// How much a cell at a distance is trusted, in (0, 1) (v).
    fn trust(&self, range_m: f64) -> f64 {
        1.0 / (1.0 + libm::exp((range_m - self.trust_range_m) / self.trust_width_m))
    }

    /// The bin of a direction in the world, radians.
    fn bin(&self, direction_rad: f64) -> usize {
        let share = direction_rad / core::f64::consts::TAU;
        let turns = share - libm::floor(share);
        (turns * self.bins as f64) as usize % self.bins
    }

    /// S of a cell.
    fn score(&self, bins: &[Bin]) -> f64 {
        let count = bins.len();
        let hits = |index: usize| bins.get(index % count.max(1)).map_or(0.0, |bin| bin.hits);
        let score = bins.iter().enumerate().map(|(index, bin)| {
            let about = 0.5 * (hits(index + count - 1) + hits(index + 1));
            let support = ((bin.hits + about) / self.support_hits).min(1.0);
            let gain = self.contradicting_pass_weight - self.pass_weight;
            let weight = self.pass_weight + gain * support;
            f64::from(bin.hits.min(self.most_hits) - weight * bin.passes.min(self.most_passes))
        });
        score.sum()
    }
}

/// What was counted from one bearing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bin {
    /// Weighted hits (H).
    hits: f32,
    /// Weighted passes (M).
    passes: f32,
}

/// Counts hits and passes of cones per cell and bearing.
///
/// For a cell at the distance r and the bearing theta off the axis, x = theta / H, in the
/// bin b of the direction from the sensor to the cell in the world:
///
/// ```text
/// v(r) = 1 / (1 + exp((r - r_0) / w_r))
/// hit    |r - z| <= beta                             H[b] += v(r) exp(-k_hit x^2)
/// pass   r < z - beta; no echo: r < 3.0 m - beta     M[b] += v(r) exp(-k_pass x^2)
/// sup[b] = min(1, (H[b] + H[b-1] / 2 + H[b+1] / 2) / h_s)
/// S      = sum_b min(H[b], c_h) - sum_b (k_0 + (k_1 - k_0) sup[b]) min(M[b], c_p)
/// ```
///
/// A cell is occupied if S is above the threshold, and free otherwise; p_occ is that of
/// [`Belief::of_score`], which ranks cells as S does and is above 0.5 where S is above the
/// threshold. A bin counts up to a limit: a hundred readings from one place say no more
/// than a few. Scanners are passed over. It maps every pose, not keyframes. The order of
/// readings does not matter but for rounding.
///
/// Memory: eight bytes per bin of a cell that lay in a cone, 192 bytes with 24 bins; none
/// for other cells. A robot with cones of both directivities has the constants of the first.
#[derive(Clone, Debug)]
pub struct BearingBinMapper {
    rig: Rig,
    parameters: BearingBinParameters,
    cells: Grid<Option<Box<[Bin]>>>,
}

impl BearingBinMapper {
    /// A mapper for the cones of a rig; the parameters follow from their directivity.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, rig: &Rig) -> Self {
        let cone = rig.mounts.iter().find_map(|mount| mount.sensor.cone());
        let directivity = cone.map(|cone| cone.directivity).unwrap_or_default();
        Self {
            rig: rig.clone(),
            parameters: BearingBinParameters::of(directivity),
            cells: Grid::new(lattice, None),
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Self {
            rig,
            parameters,
            cells,
        } = self;
        let mut has_refused = false;
        for mounted in mount_returns(rig, scan) {
            let Some(cone) = mounted.mount.sensor.cone() else {
                continue;
            };
            let heading_rad = mounted.world_from_sensor.heading_rad();
            for measured in mounted.returns() {
                let Some((view_of, echo_m)) = parameters.counted(measured) else {
                    continue;
                };
                let view = View {
                    index: 0,
                    measured: view_of,
                    world_from_sensor: mounted.world_from_sensor,
                    tolerance_m: parameters.margin_m,
                    lattice: cells.lattice(),
                };
                has_refused |= !cone.footprint(&view, &mut |seen| {
                    let Some(held) = cells.reach(seen.cell) else {
                        return;
                    };
                    let blank = || vec![Bin::default(); parameters.bins].into_boxed_slice();
                    let bins = held.get_or_insert_with(blank);
                    let bin = parameters.bin(heading_rad + seen.bearing_rad);
                    if let Some(bin) = bins.get_mut(bin) {
                        parameters.count(bin, &cone, &seen, echo_m);
                    }
                });
            }
        }
        if has_refused {
            cells.refuse();
        }
    }
}

impl BearingBinParameters {
    /// The return whose cells are visited, and its echo's range, infinite without an echo;
    /// `None` for no measurement.
    fn counted(&self, measured: Return) -> Option<(Return, f64)> {
        let sigma_m = 0.0;
        match measured {
            Return::Echo { range_m, .. } => Some((Return::Echo { range_m, sigma_m }, range_m)),
            Return::NoEcho { limit_m, .. } => {
                // The cells that are passed end a margin before the limit that is visited.
                let limit_m = limit_m.min(self.no_echo_passes_m) - self.tolerance_m + self.margin_m;
                Some((Return::NoEcho { limit_m, sigma_m }, f64::INFINITY))
            }
            Return::TooClose | Return::Invalid => None,
        }
    }

    /// Counts a reading in the bin of a cell.
    fn count(&self, bin: &mut Bin, cone: &Cone, seen: &SeenCell, echo_m: f64) {
        let share = seen.bearing_rad / cone.half_angle_rad;
        let weight =
            |falloff: f64| (self.trust(seen.range_m) * libm::exp(-falloff * share * share)) as f32;
        let beyond_m = seen.range_m - echo_m;
        if beyond_m.abs() <= self.tolerance_m {
            bin.hits += weight(self.hit_falloff);
        } else if beyond_m < 0.0 {
            bin.passes += weight(self.pass_falloff);
        }
    }
}

impl Mapper for BearingBinMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn map(&self) -> Map {
        self.cells.map(Belief::UNKNOWN, |held| {
            let Some(bins) = held else {
                return Belief::UNKNOWN;
            };
            Belief::of_score(self.parameters.score(bins) - self.parameters.threshold)
        })
    }
}

#[cfg(test)]
mod tests;
