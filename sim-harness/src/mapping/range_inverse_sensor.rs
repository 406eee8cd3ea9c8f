//! The inverse sensor model of range sensors: log odds per cell.
//!
//! Thrun, Burgard and Fox 2005, table 4.2; Carvalho and Ventura 2013, section II. Each
//! return adds to the log odds l = ln(p / (1 - p)) of a cell, from l = 0:
//!
//! ```text
//! at the echo       + ln(p_occ / (1 - p_occ))
//! before it         + ln(p_free / (1 - p_free))
//! ```
//!
//! A cell is represented by its centre; l is kept within +-20. With a decay length z_0
//! both are multiplied by 1 - z / z_0, at least 0, where z is the measured range: far
//! echoes of a wide cone say less.

use super::{Grid, Map};
use crate::drive::{Return, Scan};
use crate::geometry::Pose2;
use crate::rig::{Rig, Sensor};
use crate::sensors::{Region, footprint};

/// Most and least log odds of a cell.
const MAX_LOG_ODDS: f64 = 20.0;

/// Evidence of one return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeInverseSensorParameters {
    /// Probability that a cell at the echo is occupied (p_occ), above 0.5.
    pub occupied: f64,
    /// Probability that a cell before the echo is occupied (p_free), below 0.5.
    pub free: f64,
    /// Half width of the band in which an echo lies, metres (beta).
    pub tolerance_m: f64,
    /// Whether cells before the limit of a return without an echo count as free.
    pub no_echo_is_free: bool,
    /// Range at which an echo has no weight any more, metres (z_0); `None` gives all
    /// echoes the same weight.
    pub decay_m: Option<f64>,
}

impl RangeInverseSensorParameters {
    /// p = 0.7 at the echo, 0.3 before it, a band of a cell's size each way; returns
    /// without an echo are left out, as Carvalho and Ventura do.
    #[must_use]
    pub const fn standard(cell_m: f64) -> Self {
        Self {
            occupied: 0.7,
            free: 0.3,
            tolerance_m: cell_m,
            no_echo_is_free: false,
            decay_m: None,
        }
    }
}

/// Adds up the log odds of all returns in a grid that is fixed in the world.
#[derive(Clone, Debug)]
pub struct RangeInverseSensorMapper {
    parameters: RangeInverseSensorParameters,
    at_echo: f64,
    before_echo: f64,
    log_odds: Grid<Option<f64>>,
}

impl RangeInverseSensorMapper {
    /// A mapper with cells of the given size, metres.
    #[must_use]
    pub fn new(cell_m: f64, parameters: RangeInverseSensorParameters) -> Self {
        let logit = |p: f64| libm::log(p / (1.0 - p));
        Self {
            parameters,
            at_echo: logit(parameters.occupied),
            before_echo: logit(parameters.free),
            log_odds: Grid::new(cell_m, None),
        }
    }

    /// Takes the returns of a scan. Mounts that the rig does not have are left out.
    pub fn take(&mut self, rig: &Rig, scan: &Scan) {
        let mut returns = scan.returns.iter();
        for mount in rig.mounts.get(scan.mounts.clone()).unwrap_or_default() {
            let world_from_sensor = scan.world_from_body * mount.body_from_sensor;
            let of_mount = returns.by_ref().take(mount.sensor.returns());
            for (index, measured) in of_mount.enumerate() {
                self.add(&mount.sensor, index, *measured, &world_from_sensor);
            }
        }
    }

    fn add(&mut self, sensor: &Sensor, index: usize, measured: Return, at: &Pose2) {
        let Self {
            parameters,
            at_echo,
            before_echo,
            log_odds,
        } = self;
        let (lattice, tolerance_m) = (log_odds.lattice(), parameters.tolerance_m);
        let weight = |range_m: f64| match parameters.decay_m {
            Some(decay_m) => (1.0 - range_m / decay_m).max(0.0),
            None => 1.0,
        };
        footprint(
            sensor,
            index,
            measured,
            tolerance_m,
            lattice,
            at,
            &mut |view| {
                let evidence = match view.region {
                    Region::AtEcho => *at_echo,
                    Region::Before => *before_echo,
                    Region::BeforeLimit if parameters.no_echo_is_free => *before_echo,
                    Region::BeforeLimit => return,
                };
                if let Some(cell) = log_odds.reach(view.cell) {
                    let sum = cell.unwrap_or(0.0) + weight(view.measured_m) * evidence;
                    *cell = Some(sum.clamp(-MAX_LOG_ODDS, MAX_LOG_ODDS));
                }
            },
        );
    }

    /// How often a cell was left out because the grid would have become too large.
    #[must_use]
    pub fn refused_cells(&self) -> u64 {
        self.log_odds.refused()
    }

    /// The map so far: p = 1 - 1 / (1 + e^l), and 0.5 where no return spoke of a cell.
    #[must_use]
    pub fn map(&self) -> Map {
        self.log_odds.map(0.5, |log_odds| {
            log_odds.map_or(0.5, |l| (1.0 / (1.0 + libm::exp(-l))) as f32)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;
    use crate::rig::{Cone, Mount, Scanner};

    fn rig(sensor: Sensor) -> Rig {
        Rig {
            name: "one".to_owned(),
            about: "One sensor that looks forward.".to_owned(),
            radius_m: 0.1,
            track_m: None,
            mounts: vec![Mount {
                name: "sensor".to_owned(),
                body_from_sensor: Pose2::new(0.0, 0.0, 0.0),
                sensor,
            }],
        }
    }

    fn cone() -> Rig {
        rig(Sensor::Cone(Cone {
            half_angle_rad: 12.5_f64.to_radians(),
            range_m: [0.1, 5.0],
            sigma_m: 0.0,
        }))
    }

    /// The mapper after one scan at each place.
    fn mapped(
        rig: &Rig,
        parameters: RangeInverseSensorParameters,
        scans: &[((f64, f64), Return)],
    ) -> RangeInverseSensorMapper {
        let mut mapper = RangeInverseSensorMapper::new(0.1, parameters);
        for ((x, y), measured) in scans {
            let scan = Scan {
                stamp_us: 0,
                world_from_body: Pose2::new(*x, *y, 0.0),
                mounts: 0..1,
                returns: vec![*measured],
            };
            mapper.take(rig, &scan);
        }
        mapper
    }

    fn echo(range_m: f64) -> Return {
        Return::Echo {
            range_m,
            sigma_m: 0.0,
        }
    }

    fn count(map: &Map, wanted: Occupancy) -> usize {
        map.iter()
            .filter(|(_, p)| Occupancy::of(**p) == wanted)
            .count()
    }

    #[test]
    fn four_echoes_give_the_tabulated_cells_and_log_odds() {
        let scans = [
            ((0.51, 1.53), echo(1.52)),
            ((0.51, 1.23), echo(1.52)),
            ((0.51, 1.83), echo(1.52)),
            ((0.51, 1.53), echo(2.61)),
        ];
        let standard = RangeInverseSensorParameters::standard(0.1);
        let mapper = mapped(&cone(), standard, &scans);
        let map = mapper.map();
        assert_eq!(count(&map, Occupancy::Occupied), 48);
        assert_eq!(count(&map, Occupancy::Free), 185);
        let sum: f64 = mapper.log_odds.iter().filter_map(|(_, l)| *l).sum();
        assert!((sum + 169.459_572_077).abs() < 1e-8, "{sum}");
        let cell = map.cell_at(2.05, 1.55).unwrap();
        let l = mapper.log_odds.get(cell).copied().flatten().unwrap();
        assert!((l - 1.694_595_721).abs() < 1e-9, "{l}");
    }

    #[test]
    fn decay_weighs_an_echo_by_what_is_left_of_the_range() {
        let parameters = RangeInverseSensorParameters {
            decay_m: Some(5.0),
            ..RangeInverseSensorParameters::standard(0.1)
        };
        let mapper = mapped(&cone(), parameters, &[((0.0, 0.05), echo(2.0))]);
        let at = |x| {
            let cell = mapper.log_odds.cell_at(x, 0.05).unwrap();
            mapper.log_odds.get(cell).copied().flatten()
        };
        // 0.6 ln(0.7 / 0.3).
        assert!((at(1.95).unwrap() - 0.508_378_716).abs() < 1e-9);
        assert!((at(1.75).unwrap() + 0.508_378_716).abs() < 1e-9);
        assert_eq!(at(2.15), None);
    }

    #[test]
    fn the_order_of_the_scans_does_not_matter() {
        let mut scans = [
            ((0.51, 1.53), echo(1.52)),
            ((0.51, 1.23), echo(0.52)),
            ((0.31, 1.83), echo(2.61)),
        ];
        let standard = RangeInverseSensorParameters::standard(0.1);
        let forward = mapped(&cone(), standard, &scans).map();
        scans.reverse();
        let backward = mapped(&cone(), standard, &scans).map();
        for (cell, p) in forward.iter() {
            let other = backward.get(cell).copied().unwrap_or(0.5);
            assert!((p - other).abs() < 1e-6, "{cell:?}: {p} and {other}");
        }
    }

    #[test]
    fn a_beam_frees_its_cells_once_and_hits_one() {
        let scanner = rig(Sensor::Scanner(Scanner {
            beams: 1,
            first_rad: 0.0,
            step_rad: 0.01,
            range_m: [0.05, 80.0],
            sigma_m: 0.0,
        }));
        let standard = RangeInverseSensorParameters::standard(0.1);
        let map = mapped(&scanner, standard, &[((0.05, 0.05), echo(1.0))]).map();
        assert_eq!(count(&map, Occupancy::Occupied), 1);
        // From the sensor's own cell to the one at 0.95 m, whose beginning is 0.05 m
        // nearer than the tolerance allows at its end.
        assert_eq!(count(&map, Occupancy::Free), 10);
        let end = map.cell_at(1.05, 0.05).unwrap();
        assert_eq!(
            map.get(end).map(|p| Occupancy::of(*p)),
            Some(Occupancy::Occupied)
        );
    }

    #[test]
    fn returns_without_an_echo_count_only_where_that_is_wanted() {
        let standard = RangeInverseSensorParameters::standard(0.1);
        let nothing = [((0.0, 0.05), Return::NoEcho { limit_m: 3.0 })];
        let left_out = mapped(&cone(), standard, &nothing).map();
        assert_eq!(count(&left_out, Occupancy::Free), 0);
        let wanted = RangeInverseSensorParameters {
            no_echo_is_free: true,
            ..standard
        };
        let taken = mapped(&cone(), wanted, &nothing).map();
        assert!(count(&taken, Occupancy::Free) > 150);
        assert_eq!(count(&taken, Occupancy::Occupied), 0);
        for silent in [Return::TooClose, Return::Invalid] {
            let map = mapped(&cone(), wanted, &[((0.0, 0.0), silent)]).map();
            assert_eq!(map.iter().count(), 0, "{silent:?}");
        }
    }
}
