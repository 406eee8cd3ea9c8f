//! The rule of Nav2's range sensor layer, as a row to compare with.

use super::scan_returns::mount_returns;
use super::{Belief, Grid, Map, Mapper, NoEcho};
use crate::drive::{RangeScan, Record, Return};
use crate::geometry::{Turn, Vector};
use crate::lattice::Lattice;
use crate::rig::Rig;
use crate::sensors::{RangeSensor, Sensor, View};

/// Cost that stands for a probability of 1.
const CERTAIN: f64 = 254.0;

/// Cost that the cell at the end of a reading's axis has before the reading is added.
const MARKED: u8 = 233;

/// Parameters of the layer, under the names of its documentation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeLayerParameters {
    /// Distance at which a cell is trusted half as much as at the sensor, metres (`phi`).
    pub visibility_m: f64,
    /// Probability below which a cell is free (`clear_threshold`).
    pub clear_below: f64,
    /// Probability above which a cell is occupied (`mark_threshold`).
    pub mark_above: f64,
    /// Whether a return without an echo clears the cells up to its limit
    /// (`clear_on_max_reading`).
    pub clears_without_echo: bool,
}

impl RangeLayerParameters {
    /// The defaults of the documentation.
    pub const NAV2: Self = Self {
        visibility_m: 1.2,
        clear_below: 0.2,
        mark_above: 0.8,
        clears_without_echo: false,
    };

    /// Probability that a place is occupied, given a reading.
    ///
    /// `bearing_share` is the bearing over the half cone, `band` the band's half width as a
    /// share of the range: the size of a cell in metres, read as a number.
    fn occupancy(&self, range_m: f64, bearing_share: f64, measured_m: f64, band: f64) -> f64 {
        let off_axis = (1.0 - bearing_share * bearing_share).max(0.0);
        let visibility = 0.5 * (1.0 - libm::tanh(2.0 * (range_m - self.visibility_m)));
        let trust = off_axis * visibility;
        let along = (range_m - measured_m) / (band * measured_m);
        let lean = if along < -2.0 {
            -trust
        } else if along < -1.0 {
            -trust * (1.0 - (along + 2.0) * (along + 2.0))
        } else if along < 1.0 {
            trust * (1.0 - along * along)
        } else {
            0.0
        };
        0.5 * (1.0 + lean)
    }

    /// The class of a cost.
    fn belief(&self, cost: u8) -> Belief {
        let level = |probability: f64| (probability * CERTAIN) as u8;
        if cost > level(self.mark_above) || cost < level(self.clear_below) {
            Belief::of_probability((f64::from(cost) / CERTAIN) as f32)
        } else {
            Belief::UNKNOWN
        }
    }
}

/// The cost of a cell after a reading: Bayes' rule, rounded down to a level.
fn updated(cost: u8, occupancy: f64) -> u8 {
    let prior = f64::from(cost) / CERTAIN;
    let occupied = occupancy * prior;
    let free = (1.0 - occupancy) * (1.0 - prior);
    if occupied + free > 0.0 {
        (occupied / (occupied + free) * CERTAIN) as u8
    } else {
        cost
    }
}

/// Maps ranges as the range sensor layer of the navigation stack Nav2 does.
///
/// Its documentation, <https://docs.nav2.org/configuration/packages/costmap-plugins/range.html>,
/// gives the parameters and their defaults; the model is that of its public source,
/// `nav2_costmap_2d`, written anew here. For a reading r and a cell at the distance phi and
/// the bearing theta in a cone of half angle H, with cells of c metres:
///
/// ```text
/// q = (1 - (theta / H)^2) (1 - (1 + tanh(2 (phi - 1.2))) / 2)
/// a = (phi - r) / (c r)
/// L = (1 - q) / 2                     a < -2
///     (1 - q (1 - (2 + a)^2)) / 2     -2 <= a < -1
///     (1 + q (1 - a^2)) / 2           -1 <= a < 1
///     1 / 2                           beyond
/// p := L p / (L p + (1 - L) (1 - p))
/// ```
///
/// It differs from [`SonarModel`](super::SonarModel) in the band, whose half width grows
/// with the range, and in the store: a cell has 255 levels, p = cost / 254, each update
/// rounds down, and the cell at the end of the axis is set to 233 before each reading. So
/// weak evidence always clears, a cost of 0 never rises again but at the end of an axis, and
/// each reading marks one cell whatever was measured before. A cell is occupied above 0.8,
/// free below 0.2, and unknown between: the layer leaves it to other layers there.
///
/// Cells outside of the cone are not visited. The layer does visit those of a rectangle
/// about it (`inflate_cone` 1.0), where L is 1/2 and rounding alone can change a cost. A
/// beam of a scanner is a ray on the axis. The order of readings matters. Memory: a byte per
/// cell.
#[derive(Clone, Debug)]
pub struct RangeLayerMapper {
    rig: Rig,
    parameters: RangeLayerParameters,
    costs: Grid<u8>,
}

impl RangeLayerMapper {
    /// A mapper for all sensors of a rig.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, rig: &Rig, parameters: RangeLayerParameters) -> Self {
        Self {
            rig: rig.clone(),
            parameters,
            costs: Grid::new(lattice, (0.5 * CERTAIN) as u8),
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Self {
            rig,
            parameters,
            costs,
        } = self;
        let mut has_refused = false;
        for mounted in mount_returns(rig, scan) {
            let sensor = &mounted.mount.sensor;
            for (index, measured) in mounted.returns().enumerate() {
                let reading = PlacedReturn {
                    sensor,
                    view: View {
                        index,
                        measured,
                        world_from_sensor: mounted.world_from_sensor,
                        tolerance_m: 0.0,
                        lattice: costs.lattice(),
                    },
                };
                has_refused |= !reading.add(parameters, costs);
            }
        }
        if has_refused {
            costs.refuse();
        }
    }
}

/// A return of a sensor and where it was measured.
struct PlacedReturn<'a> {
    sensor: &'a Sensor,
    view: View,
}

impl PlacedReturn<'_> {
    /// Adds the return to the costs; whether all cells have a place in the lattice.
    fn add(&self, parameters: &RangeLayerParameters, costs: &mut Grid<u8>) -> bool {
        let band = costs.cell_m();
        match self.view.measured {
            Return::Echo { range_m, .. } => {
                if !self.mark_end(range_m, costs) {
                    return false;
                }
                let echo = Return::Echo {
                    range_m,
                    sigma_m: 0.0,
                };
                self.visit(echo, band * range_m, &mut |cell, distance_m, share| {
                    let occupancy = parameters.occupancy(distance_m, share, range_m, band);
                    if let Some(cost) = costs.reach(cell) {
                        *cost = updated(*cost, occupancy);
                    }
                })
            }
            Return::NoEcho { limit_m, .. } if parameters.clears_without_echo => {
                let no_echo = Return::NoEcho {
                    limit_m,
                    sigma_m: 0.0,
                };
                self.visit(no_echo, 0.0, &mut |cell, _, _| {
                    if let Some(cost) = costs.reach(cell) {
                        *cost = 0;
                    }
                })
            }
            Return::NoEcho { .. } | Return::TooClose | Return::Invalid => true,
        }
    }

    /// Sets the cost of the cell at the end of the axis.
    fn mark_end(&self, range_m: f64, costs: &mut Grid<u8>) -> bool {
        let bearing_rad = match self.sensor {
            Sensor::Scanner(it) => it.bearing_rad(self.view.index),
            Sensor::Cone(_) | Sensor::Infrared(_) => 0.0,
        };
        let direction = Turn::by_radians_f64(bearing_rad).direction();
        let end: Vector = self.view.world_from_sensor.place(direction.scaled(range_m));
        let Some(cell) = costs.cell_at(end.x, end.y) else {
            return false;
        };
        if let Some(cost) = costs.reach(cell) {
            *cost = MARKED;
        }
        true
    }

    /// Visits the cells of the return with their distance and their bearing over the half
    /// cone, 0 for a beam.
    fn visit(
        &self,
        measured: Return,
        tolerance_m: f64,
        visit: &mut dyn FnMut(crate::lattice::Cell, f64, f64),
    ) -> bool {
        let view = View {
            measured,
            tolerance_m,
            ..self.view
        };
        match self.sensor.cone() {
            Some(cone) => cone.footprint(&view, &mut |seen| {
                let share = seen.bearing_rad / cone.half_angle_rad;
                visit(seen.cell, seen.range_m, share);
            }),
            // All cells before the end, however wide the band.
            None => {
                let ray = View {
                    tolerance_m: 0.0,
                    ..view
                };
                let model = self.sensor.model();
                model.footprint(&ray, &mut |seen| visit(seen.cell, seen.range_m, 0.0))
            }
        }
    }
}

impl Mapper for RangeLayerMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.add(scan);
        }
    }

    fn map(&self) -> Map {
        let belief = |cost: &u8| self.parameters.belief(*cost);
        self.costs.map(Belief::UNKNOWN, belief)
    }
}

impl RangeLayerParameters {
    /// The defaults with another rule for returns without an echo.
    #[must_use]
    pub fn with(self, no_echo: Option<NoEcho>) -> Self {
        Self {
            clears_without_echo: no_echo == Some(NoEcho::Free),
            ..self
        }
    }
}

#[cfg(test)]
mod tests;
