//! The paper's map: survivors and rejects of the particle filter per cell.

use super::{Calculus, Counts, Evidence, Grid, Map, Mapper};
use crate::drive::Record;
use crate::lattice::Lattice;

/// Counts the outcomes of a particle filter in a grid that is fixed in the world.
///
/// Korthals et al. 2016, equations 3 and 4. Records other than outcomes are passed over.
#[derive(Clone, Debug)]
pub struct CountingMapper {
    counts: Grid<[u16; 2]>,
}

impl CountingMapper {
    /// A mapper with square cells of the given size, metres.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>) -> Self {
        Self {
            counts: Grid::new(lattice, Counts.blank()),
        }
    }
}

impl Mapper for CountingMapper {
    fn take(&mut self, record: &Record) {
        let Record::Outcomes(outcomes) = record else {
            return;
        };
        for outcome in outcomes {
            if let Some(held) = self.counts.reach_at(outcome.place.x, outcome.place.y) {
                let evidence = Evidence {
                    is_occupied: outcome.is_occupied,
                    weight: 1.0,
                };
                Counts.update(held, evidence);
            }
        }
    }

    fn map(&self) -> Map {
        self.counts
            .map(super::Belief::UNKNOWN, |held| Counts.belief(held))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::PointOutcome;
    use crate::geometry::Vector;
    use crate::mapping::Occupancy;

    #[test]
    fn the_majority_of_a_cells_outcomes_decides() {
        let mut mapper = CountingMapper::new(0.01);
        let outcome = |is_occupied| PointOutcome {
            place: Vector::new(1.005, 2.105),
            is_occupied,
        };
        mapper.take(&Record::Outcomes(vec![outcome(true)]));
        let cell = mapper.map().cell_at(1.005, 2.105).unwrap();
        assert_eq!(mapper.map().occupancy(cell), Occupancy::Occupied);
        mapper.take(&Record::Outcomes(vec![outcome(false); 2]));
        assert_eq!(mapper.map().occupancy(cell), Occupancy::Free);
    }
}
