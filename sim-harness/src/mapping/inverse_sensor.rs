//! The inverse sensor model: the occupancy grid that the paper compares itself with.
//!
//! Log odds as in Thrun, Burgard and Fox 2005, table 4.2, with the lobe of a proximity
//! sensor in place of a beam. A reading with the arc x and its error sigma_x adds to a
//! cell at range r and bearing theta, with the band b = max(sigma_x, 0.75 cells):
//!
//! ```text
//! r < x - b       - l_free cos(xi theta)
//! |r - x| <= b    + l_occ  cos(xi theta)
//! beyond          nothing
//! ```
//!
//! The paper names its sources for the method (section 5, Stachniss and Haehnel) and
//! prints no formula; this is ours, and the comparison stands and falls with it.

use amiro_ipf::math;
use amiro_ipf::node::{Config, Event, StepBegun};

use super::lobes::{CellView, Lobes};
use super::{Grid, Map, Mapper};

/// Least cos(xi theta) at which a sensor says anything about a cell.
const LEAST_DIRECTIVITY: f64 = 0.05;
/// Least half width of an arc, cells: no arc slips between the centres of cells.
const LEAST_BAND_CELLS: f64 = 0.75;

/// What a reading of nothing in range is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaxRange {
    /// Free space up to the limit, nothing on it.
    DrawnFree,
    /// Not at all.
    Dropped,
    /// An object at the limit, as the raw distance has it.
    TakenAsObject,
}

/// Evidence of one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseSensorParameters {
    /// Log odds on the arc and the sensor's axis (l_occ). More: thicker walls.
    pub occupied: f64,
    /// Log odds against occupied before the arc, on the axis (l_free). More: more
    /// readings are needed to turn a free cell into wall.
    pub free: f64,
    /// What nothing in range is drawn as.
    pub max_range: MaxRange,
}

impl InverseSensorParameters {
    /// The usual choice, for sensors with narrow beams: p = 0.70 on the arc, 0.40 before.
    pub const STANDARD: Self = Self {
        occupied: 0.85,
        free: 0.40,
        max_range: MaxRange::DrawnFree,
    };

    /// The best of some twenty choices on the paper's scenarios: p = 0.60 on the
    /// arc, 0.30 before. For lobes of 120 degrees most of an arc is no wall.
    pub const TUNED: Self = Self {
        occupied: 0.40,
        free: 0.85,
        ..Self::STANDARD
    };

    /// The same evidence with another rule for nothing in range.
    #[must_use]
    pub const fn with(self, max_range: MaxRange) -> Self {
        Self { max_range, ..self }
    }
}

/// Adds up the log odds of all readings in a grid that is fixed in the world.
///
/// It takes the readings of the filter's steps, no others, and needs no particles.
#[derive(Clone, Debug)]
pub struct InverseSensorMapper {
    parameters: InverseSensorParameters,
    lobes: Lobes,
    log_odds: Grid<f64>,
}

impl InverseSensorMapper {
    /// A mapper for the sensors of a configuration, with cells of the given size, metres.
    #[must_use]
    pub fn new(cell_m: f64, config: &Config, parameters: InverseSensorParameters) -> Self {
        Self {
            parameters,
            lobes: Lobes::of(config, cell_m),
            log_odds: Grid::new(cell_m, 0.0),
        }
    }

    fn add(&mut self, step: &StepBegun) {
        let Self {
            parameters,
            lobes,
            log_odds,
        } = self;
        let least_band_m = LEAST_BAND_CELLS * log_odds.cell_m();
        let are_all_shown = lobes.show(step, |cell, view| {
            let Some(evidence) = parameters.evidence(&view, least_band_m) else {
                return;
            };
            if let Some(sum) = log_odds.reach(cell) {
                *sum += evidence;
            }
        });
        if !are_all_shown {
            log_odds.refuse();
        }
    }
}

impl Mapper for InverseSensorMapper {
    fn take(&mut self, event: &Event) {
        if let Event::StepBegun(step) = event {
            self.add(step);
        }
    }

    fn map(&self) -> Map {
        self.log_odds
            .map(0.5, |log_odds| probability(*log_odds as f32))
    }
}

impl InverseSensorParameters {
    /// Log odds that a reading adds to a cell; `None` where it says nothing.
    fn evidence(&self, view: &CellView, least_band_m: f64) -> Option<f64> {
        let is_dropped = view.is_limit && self.max_range == MaxRange::Dropped;
        if is_dropped || view.directivity < LEAST_DIRECTIVITY {
            return None;
        }
        let is_free_limit = view.is_limit && self.max_range == MaxRange::DrawnFree;
        let band_m = view.sigma_m.max(least_band_m);
        if view.range_m < view.arc_m - band_m {
            Some(-self.free * view.directivity)
        } else if view.range_m <= view.arc_m + band_m && !is_free_limit {
            Some(self.occupied * view.directivity)
        } else {
            None
        }
    }
}

/// p = 1 - 1 / (1 + e^l), without cancellation for either sign.
fn probability(log_odds: f32) -> f32 {
    let odds_against = math::exp_of_minus(log_odds.abs());
    if log_odds < 0.0 {
        odds_against / (1.0 + odds_against)
    } else {
        1.0 / (1.0 + odds_against)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;
    use amiro_ipf::filter::Profile;
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::{Ring, SENSORS, Sample, SensorMask};

    /// One sensor that looks along x, its axis through the centres of a row of cells.
    fn config() -> Config {
        let mut ring = Ring::AMIRO;
        ring.axis_rad[0] = 0.0;
        Config {
            ring,
            sensors: SensorMask::NONE.with(0),
            ..Config::amiro(Profile::Paper)
        }
    }

    /// The map after a number of readings of the given counts; the sensor is at x = 0.
    fn map(parameters: InverseSensorParameters, counts: i32, readings: u32) -> Map {
        let mut mapper = InverseSensorMapper::new(0.01, &config(), parameters);
        for index in 0..readings {
            mapper.take(&Event::StepBegun(StepBegun {
                index,
                stamp_us: u64::from(index),
                pose: Pose::new(-0.05, 0.005, 0.0),
                samples: [Sample::Counts(counts); SENSORS],
            }));
        }
        mapper.map()
    }

    /// p_occ on the axis, so many millimetres before the sensor.
    fn on_axis(map: &Map, millimetres: u32) -> f32 {
        let x = 0.001 * f64::from(millimetres);
        let cell = map.cell_at(x, 0.005).unwrap();
        map.get(cell).copied().unwrap_or(0.5)
    }

    #[test]
    fn profile_on_the_axis_is_free_then_peaks_at_the_object_then_unknown() {
        // 361 counts are an object at 50 mm.
        for parameters in [
            InverseSensorParameters::STANDARD,
            InverseSensorParameters::TUNED,
        ] {
            let map = map(parameters, 361, 1);
            let free = probability(-parameters.free as f32);
            let occupied = probability(parameters.occupied as f32);
            for millimetres in [5, 15, 25, 35] {
                let p = on_axis(&map, millimetres);
                assert!((p - free).abs() < 1e-3, "{millimetres} mm: {p}");
            }
            for millimetres in [45, 55] {
                let p = on_axis(&map, millimetres);
                assert!((p - occupied).abs() < 1e-3, "{millimetres} mm: {p}");
            }
            for millimetres in (65..300).step_by(10) {
                let p = on_axis(&map, millimetres);
                assert_eq!(Occupancy::of(p), Occupancy::Unknown, "{millimetres} mm");
            }
        }
    }

    #[test]
    fn evidence_weakens_off_the_axis() {
        let map = map(InverseSensorParameters::STANDARD, 361, 1);
        let off_axis = map.cell_at(0.025, 0.005 + 0.020).unwrap();
        let p = map.get(off_axis).unwrap();
        // 25 mm ahead and 20 mm aside are 38.66 degrees: cos(1.2365 x 38.66 deg) = 0.6717.
        assert!((p - probability(-0.40 * 0.6717)).abs() < 1e-3, "{p}");
        // 10 mm aside of 5 mm ahead are 63 degrees: out of view.
        let out_of_view = map.cell_at(0.005, 0.015).unwrap();
        assert_eq!(
            Occupancy::of(map.get(out_of_view).copied().unwrap()),
            Occupancy::Unknown
        );
    }

    #[test]
    fn adding_log_odds_is_the_rule_of_bayes() {
        // From an even prior each reading multiplies the odds: p' = p q / (p q + (1-p)(1-q)).
        let parameters = InverseSensorParameters::STANDARD;
        for millimetres in [15, 45] {
            let single = on_axis(&map(parameters, 361, 1), millimetres);
            let mut p = single;
            for readings in 2..=8 {
                let (yes, no) = (p * single, (1.0 - p) * (1.0 - single));
                p = yes / (yes + no);
                let summed = on_axis(&map(parameters, 361, readings), millimetres);
                assert!(
                    (summed - p).abs() < 2e-6,
                    "{readings} readings: {summed}, {p}"
                );
            }
        }
    }

    #[test]
    fn probability_inverts_the_log_odds() {
        for tenths in -100_i16..=100 {
            let log_odds = f32::from(tenths) / 10.0;
            let p = probability(log_odds);
            if log_odds.abs() < 8.0 {
                let back = math::ln(p) - math::ln(1.0 - p);
                // 1 - p keeps seven digits less those of e^-8.
                assert!((back - log_odds).abs() < 1e-3, "{log_odds}: {back}");
            }
            assert_eq!(p > 0.5, log_odds > 0.0);
        }
        assert_eq!(Occupancy::of(probability(0.0)), Occupancy::Unknown);
    }

    #[test]
    fn nothing_in_range_is_free_or_nothing_or_an_object_by_rule() {
        let standard = InverseSensorParameters::STANDARD;
        // At beta nothing is in range; the limit is 200 mm with a band of 19.4 mm.
        let maps = [
            MaxRange::DrawnFree,
            MaxRange::Dropped,
            MaxRange::TakenAsObject,
        ]
        .map(|rule| map(standard.with(rule), -16, 1));
        let said = |millimetres| {
            let said = |map: &Map| Occupancy::of(on_axis(map, millimetres));
            maps.each_ref().map(said)
        };
        use Occupancy::{Free, Occupied, Unknown};
        assert_eq!(said(105), [Free, Unknown, Free]);
        assert_eq!(said(175), [Free, Unknown, Free]);
        assert_eq!(said(195), [Unknown, Unknown, Occupied]);
        assert_eq!(said(215), [Unknown, Unknown, Occupied]);
        assert_eq!(said(225), [Unknown, Unknown, Unknown]);
        // An object in range is the same to all three.
        let [free, dropped, object] = [
            MaxRange::DrawnFree,
            MaxRange::Dropped,
            MaxRange::TakenAsObject,
        ]
        .map(|rule| map(standard.with(rule), 78, 3));
        assert_eq!(free, dropped);
        assert_eq!(free, object);
    }

    #[test]
    fn sensors_that_say_nothing_touch_nothing() {
        let mut mapper =
            InverseSensorMapper::new(0.01, &config(), InverseSensorParameters::STANDARD);
        mapper.take(&Event::StepBegun(StepBegun {
            index: 0,
            stamp_us: 0,
            pose: Pose::default(),
            samples: [
                Sample::Missing,
                Sample::Counts(78),
                Sample::Counts(78),
                Sample::Counts(78),
                Sample::Saturated,
                Sample::Saturated,
                Sample::Saturated,
                Sample::Saturated,
            ],
        }));
        assert_eq!(mapper.map().iter().count(), 0);
    }
}
