//! The map that is free everywhere, as a baseline of the scores.

use super::{Belief, Map, Mapper};
use crate::drive::Record;
use crate::geometry::Rectangle;
use crate::lattice::Cell;
use crate::lattice::Lattice;

/// Maps every cell of a rectangle as free, without regard to the readings.
#[derive(Clone, Debug)]
pub struct AllFreeMapper {
    map: Map,
}

impl AllFreeMapper {
    /// A mapper of all cells, square and of the given size, metres, that meet a rectangle;
    /// without one the map is empty.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, extent: Option<&Rectangle>) -> Self {
        let mut map = Map::unknown(lattice);
        let Some(extent) = extent else {
            return Self { map };
        };
        let low = map.cell_at(extent.min.x, extent.min.y);
        let high = map.cell_at(extent.max.x, extent.max.y);
        if let (Some(low), Some(high)) = (low, high) {
            for row in low.row..=high.row {
                for column in low.column..=high.column {
                    if let Some(belief) = map.reach(Cell { row, column }) {
                        *belief = Belief::of_probability(0.0);
                    }
                }
            }
        }
        Self { map }
    }
}

impl Mapper for AllFreeMapper {
    fn take(&mut self, _: &Record) {}

    fn map(&self) -> Map {
        self.map.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::Scores;
    use crate::world::standard;

    #[test]
    fn the_map_that_is_free_everywhere_has_less_error_than_walls_and_finds_none() {
        let scenario = standard("msod").unwrap().unwrap();
        let map = AllFreeMapper::new(scenario.cell_m, Some(&scenario.extent)).map();
        let truth = crate::evaluation::Truth::of(&scenario, &[]);
        let scores = Scores::of(&map, &truth);
        // 20 x 5 of 112 x 72 cells are the block.
        assert_eq!(scores.oe, Some(100.0 / 8064.0));
        assert_eq!(scores.oe_unexpanded, scores.oe);
        assert_eq!((scores.tpr, scores.fpr), (Some(0.0), Some(0.0)));
        assert_eq!((scores.cells, scores.unknown), (8064, 0));
    }
}
