//! The map that is free everywhere: what a score is worth shows beside it.

use amiro_ipf::node::Event;

use super::{Grid, Map, Mapper};
use crate::world::Rectangle;

/// Maps every cell of a rectangle as free, whatever is sensed.
#[derive(Clone, Debug)]
pub struct AllFreeMapper {
    map: Map,
}

impl AllFreeMapper {
    /// A mapper of all cells, square and of the given size, metres, that meet a rectangle.
    #[must_use]
    pub fn new(cell_m: f64, extent: &Rectangle) -> Self {
        let mut map = Grid::new(cell_m, 0.5);
        let low = map.cell_at(extent.min.x, extent.min.y);
        let high = map.cell_at(extent.max.x, extent.max.y);
        if let (Some(low), Some(high)) = (low, high) {
            for row in low.row..=high.row {
                for column in low.column..=high.column {
                    if let Some(p_occ) = map.reach(super::Cell { row, column }) {
                        *p_occ = 0.0;
                    }
                }
            }
        }
        Self { map }
    }
}

impl Mapper for AllFreeMapper {
    fn take(&mut self, _: &Event) {}

    fn map(&self) -> Map {
        self.map.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::{Scores, standard};

    #[test]
    fn the_map_that_is_free_everywhere_has_less_error_than_walls_and_finds_none() {
        let scenario = standard("msod").unwrap().unwrap();
        let map = AllFreeMapper::new(scenario.cell_m, &scenario.extent).map();
        let truth = crate::evaluation::Truth::of(&scenario, &[]);
        let scores = Scores::of(&map, &truth);
        // 20 x 5 of 112 x 72 cells are the block.
        assert_eq!(scores.oe, Some(100.0 / 8064.0));
        assert_eq!(scores.oe_unexpanded, scores.oe);
        assert_eq!((scores.tpr, scores.fpr), (Some(0.0), Some(0.0)));
        assert_eq!((scores.cells, scores.unknown), (8064, 0));
    }
}
