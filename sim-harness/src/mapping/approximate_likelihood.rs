//! Free before occupied: the map that is free where any echo found nothing.
//!
//! Carvalho and Ventura 2013, section III: MAL, and CEMAL behind the filter
//! [`consistent_echoes`](super::consistent_echoes).

use super::cone_readings::{ConeReadings, ReadingSelection};
use super::consistent_echoes::{EchoJudgement, judge};
use super::{FinishProgress, Map, Mapper};
use crate::drive::Record;
use crate::lattice::Lattice;
use crate::rig::Rig;

/// What is done about echoes that contradict each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EchoFilter {
    /// All echoes are used.
    None,
    /// Those of [`ConsistentEchoMapper`](super::ConsistentEchoMapper) are used.
    Consistent,
}

impl EchoFilter {
    /// What is kept of the readings.
    pub(super) fn judge(self, readings: &ConeReadings) -> EchoJudgement {
        match self {
            Self::None => {
                let echoes = readings.readings().iter();
                EchoJudgement {
                    is_kept: vec![true; readings.readings().len()],
                    kept: echoes.filter(|reading| reading.is_echo).count(),
                    ..EchoJudgement::default()
                }
            }
            Self::Consistent => judge(readings),
        }
    }
}

/// Maps as free what lies before any echo, and as occupied what lies at an echo and before
/// none (maximum approximate likelihood, MAL).
///
/// The map has no degrees of belief: p_occ is 0, 1, or 0.5 where no echo is. Without the
/// filter the order of the scans does not matter, with it that within one stamp. There is
/// no map before [`finish`](Mapper::finish).
#[derive(Clone, Debug)]
pub struct ApproximateLikelihoodMapper {
    readings: ConeReadings,
    filter: EchoFilter,
    judgement: EchoJudgement,
    map: Option<Map>,
}

impl ApproximateLikelihoodMapper {
    /// A mapper for the sensors of a rig. An echo lies within `tolerance_m` of its range
    /// (beta); with `takes_no_echo` a return without an echo is free up to its limit.
    #[must_use]
    pub fn new(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        filter: EchoFilter,
        tolerance_m: f64,
        takes_no_echo: bool,
    ) -> Self {
        let selection = ReadingSelection {
            tolerance_m,
            reach_m: 0.0,
            takes_no_echo,
        };
        Self {
            readings: ConeReadings::new(lattice.into(), rig, selection),
            filter,
            judgement: EchoJudgement::default(),
            map: None,
        }
    }

    /// What was kept and removed at the end of the drive; nothing before it.
    #[must_use]
    pub fn judgement(&self) -> &EchoJudgement {
        &self.judgement
    }

    fn draw(&self) -> Map {
        let readings = self.readings.readings().iter();
        let kept = readings.zip(&self.judgement.is_kept);
        let kept = kept.filter_map(|(reading, is_kept)| is_kept.then_some(reading));
        let mut p_occ = vec![None; self.readings.cells().len()];
        for reading in kept {
            for pair in reading.at_echo() {
                let _ = p_occ[self.readings.cell(pair)].get_or_insert(1.0);
            }
            for pair in reading.before() {
                p_occ[self.readings.cell(pair)] = Some(0.0);
            }
        }
        self.readings.map(&p_occ)
    }
}

impl Mapper for ApproximateLikelihoodMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.readings.add(scan);
        }
    }

    fn finish(&mut self, _: &mut dyn FnMut(FinishProgress)) {
        self.judgement = self.filter.judge(&self.readings);
        self.map = Some(self.draw());
    }

    fn map(&self) -> Map {
        let blank = || self.readings.blank_map();
        self.map.clone().unwrap_or_else(blank)
    }

    fn is_online(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;
    use crate::mapping::toy_scene::{self, CELL_M};
    use crate::sensors::Directivity;

    fn mapper(filter: EchoFilter, records: &[Record]) -> ApproximateLikelihoodMapper {
        let rig = toy_scene::rig(Directivity::Piston);
        let mut mapper = ApproximateLikelihoodMapper::new(CELL_M, &rig, filter, CELL_M, false);
        records.iter().for_each(|record| mapper.take(record));
        mapper.finish(&mut |_| {});
        mapper
    }

    fn counts(map: &Map) -> (usize, usize) {
        (map.count(Occupancy::Occupied), map.count(Occupancy::Free))
    }

    #[test]
    fn g15_maps_with_and_without_the_filter_have_the_tabulated_cells() {
        for (filter, expected, kept) in [
            (EchoFilter::None, (35, 198), 4),
            (EchoFilter::Consistent, (25, 104), 3),
        ] {
            let mut mapper = mapper(filter, &toy_scene::records());
            let map = mapper.map();
            assert_eq!(counts(&map), expected, "{filter:?}");
            assert_eq!(mapper.judgement().kept, kept);
            assert!(
                map.iter()
                    .all(|(_, it)| [0.0, 0.5, 1.0].contains(&it.p_occ()))
            );
            mapper.finish(&mut |_| {});
            assert_eq!(mapper.map(), map, "{filter:?} twice");
        }
    }

    #[test]
    fn the_order_of_the_scans_does_not_matter() {
        let mut records = toy_scene::records();
        for filter in [EchoFilter::None, EchoFilter::Consistent] {
            let map = mapper(filter, &records).map();
            for _ in 0..records.len() {
                records.rotate_left(1);
                records.swap(0, 2);
                let other = mapper(filter, &records).map();
                let cells = |map: &Map, class| map.cells_of(class).collect::<Vec<_>>();
                for class in [Occupancy::Free, Occupancy::Occupied] {
                    assert_eq!(cells(&map, class), cells(&other, class), "{filter:?}");
                }
            }
        }
    }

    #[test]
    fn a_return_without_an_echo_is_free_up_to_its_limit_where_that_is_wanted() {
        let silent = crate::drive::Return::NoEcho {
            limit_m: 3.0,
            sigma_m: 0.0,
        };
        let rig = toy_scene::rig(Directivity::Piston);
        let map = |takes_no_echo| {
            let mut mapper = ApproximateLikelihoodMapper::new(
                CELL_M,
                &rig,
                EchoFilter::Consistent,
                CELL_M,
                takes_no_echo,
            );
            mapper.take(&toy_scene::scan(0, [0.5, 1.5], silent));
            mapper.finish(&mut |_| {});
            mapper.map()
        };
        assert_eq!(counts(&map(false)), (0, 0));
        let (occupied, free) = counts(&map(true));
        assert!(occupied == 0 && free > 150, "{free}");
    }
}
