//! Whether a map leaves a passage open: its falsely occupied cells and its frontier.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::lattice::Cell;
use crate::mapping::{Map, Occupancy};
use crate::world::{Rectangle, Vector};

/// The robot's footprint about its centre, metres: hull and a cell. The space is free, so
/// it counts as free in every map.
const FOOTPRINT_M: f64 = 0.060;
/// Rounding that is forgiven at edges.
const ROUNDING_M: f64 = 1e-9;

/// How open a map shows a passage.
///
/// A cell is within a passage if all of it is. An edge through the centres of cells
/// would otherwise be decided by rounding, and such cells lie half in the wall beside
/// the passage: at the end of `msm_l.toml` they are twenty, all of them wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct OpeningScores {
    /// Occupied cells within the passage, where nothing stands.
    pub false_occupied: u64,
    /// Frontier cells within the passage (Yamauchi 1997): free, beside an unknown
    /// cell, and to be reached over free cells. A robot that explores goes to these;
    /// without any the passage does not exist for it.
    pub frontier: u64,
}

impl OpeningScores {
    /// Judges a passage in the map of a robot that stands at a place.
    #[must_use]
    pub fn of(map: &Map, passage: &Rectangle, robot: Vector) -> Self {
        let surroundings = RobotInMap { map, robot };
        let half_m = 0.5 * map.cell_m() - ROUNDING_M;
        let corner = Vector::new(half_m, half_m);
        let is_inside = |cell: &Cell| {
            let centre = surroundings.centre(*cell);
            passage.contains(centre - corner) && passage.contains(centre + corner)
        };
        let occupied = map.cells_of(Occupancy::Occupied);
        let is_frontier = |cell: &&Cell| {
            is_inside(cell)
                && neighbours(**cell)
                    .iter()
                    .any(|cell| surroundings.is_unknown(*cell))
        };
        let reachable = surroundings.reachable();
        Self {
            false_occupied: occupied.filter(is_inside).count() as u64,
            frontier: reachable.iter().filter(is_frontier).count() as u64,
        }
    }
}

/// The four cells that share a side with a cell.
fn neighbours(cell: Cell) -> [Cell; 4] {
    let Cell { row, column } = cell;
    [
        (row - 1, column),
        (row + 1, column),
        (row, column - 1),
        (row, column + 1),
    ]
    .map(|(row, column)| Cell { row, column })
}

/// A map with a robot in it.
struct RobotInMap<'m> {
    map: &'m Map,
    robot: Vector,
}

impl RobotInMap<'_> {
    fn centre(&self, cell: Cell) -> Vector {
        let (x, y) = self.map.centre(cell);
        Vector::new(x, y)
    }

    fn is_underfoot(&self, cell: Cell) -> bool {
        (self.centre(cell) - self.robot).norm() <= FOOTPRINT_M
    }

    fn is_free(&self, cell: Cell) -> bool {
        self.map.occupancy(cell) == Occupancy::Free || self.is_underfoot(cell)
    }

    fn is_unknown(&self, cell: Cell) -> bool {
        self.map.occupancy(cell) == Occupancy::Unknown && !self.is_underfoot(cell)
    }

    /// The free cells that are 4-connected with the one under the robot's centre.
    ///
    /// It ends: free cells are in the map's store or underfoot.
    fn reachable(&self) -> BTreeSet<Cell> {
        let start = self.map.cell_at(self.robot.x, self.robot.y);
        let mut reached: BTreeSet<Cell> = start.into_iter().collect();
        let mut rest: Vec<Cell> = start.into_iter().collect();
        while let Some(cell) = rest.pop() {
            for next in neighbours(cell) {
                if self.is_free(next) && reached.insert(next) {
                    rest.push(next);
                }
            }
        }
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Belief;

    /// A map from its picture, the highest row first: `.` free, `#` occupied, ` ` unknown.
    fn map(picture: &[&str]) -> Map {
        let mut map = Map::unknown(0.01);
        for (row, line) in (0..).zip(picture.iter().rev()) {
            for (column, sign) in (0..).zip(line.chars()) {
                *map.reach(Cell { row, column }).unwrap() = Belief::of_probability(match sign {
                    '.' => 0.1,
                    '#' => 0.9,
                    _ => 0.5,
                });
            }
        }
        map
    }

    /// The whole picture to the right of the tenth column, the robot in the tenth.
    fn scores(picture: &[&str]) -> OpeningScores {
        let passage = Rectangle {
            min: Vector::new(0.16, 0.0),
            max: Vector::new(0.40, 0.20),
        };
        OpeningScores::of(&map(picture), &passage, Vector::new(0.095, 0.025))
    }

    #[test]
    fn frontier_cells_are_free_reachable_and_beside_the_unknown() {
        // The passage begins at column 16. Row 2 is open to the unknown at its end and
        // below its two last cells; row 4 is free as well, but cut off.
        let scores = scores(&[
            "................##..  ",
            "..................##",
            "....................",
            "................### ",
            "................    ",
        ]);
        assert_eq!(scores.false_occupied, 7);
        // Column 19 of row 2 touches the unknown to the right and below it.
        assert_eq!(scores.frontier, 1);
    }

    #[test]
    fn corners_do_not_connect() {
        let through_a_corner = [
            "                 ",
            "                 .. ",
            "................#.. ",
            ".................#  ",
            "                    ",
        ];
        // Column 16 of row 1 is reached and lies above the unknown; the cells behind
        // it only touch by corners.
        assert_eq!(scores(&through_a_corner).frontier, 1);
        let mut opened = through_a_corner;
        opened[3] = ".................   ";
        opened[2] = "................... ";
        // Column 16 of row 1; 16 to 18 of row 2, the first by the unknown above it; and
        // 17 and 18 of row 3.
        assert_eq!(scores(&opened).frontier, 6);
    }

    #[test]
    fn a_closed_passage_has_no_frontier() {
        let scores = scores(&[
            "#######################",
            ".................#     ",
            ".................#     ",
            ".................#     ",
            "#######################",
        ]);
        assert_eq!(scores.frontier, 0);
        assert_eq!(scores.false_occupied, 17);
    }

    #[test]
    fn cells_that_lie_half_outside_are_not_in_the_passage() {
        let walls = map(&["###", "#.#", "###"]);
        let passage = |margin: f64| Rectangle {
            min: Vector::new(margin, margin),
            max: Vector::new(0.03 - margin, 0.03 - margin),
        };
        let robot = Vector::new(1.0, 1.0);
        for (margin, cells) in [(0.0, 8), (0.005, 0), (0.002, 0)] {
            let scores = OpeningScores::of(&walls, &passage(margin), robot);
            assert_eq!(scores.false_occupied, cells, "{margin} m");
        }
    }

    #[test]
    fn the_footprint_is_free_whatever_the_map_contains() {
        let passage = Rectangle {
            min: Vector::new(0.04, 0.04),
            max: Vector::new(0.14, 0.14),
        };
        // Nothing is known; the outermost cells underfoot touch the unknown.
        let empty = Map::unknown(0.01);
        let robot = Vector::new(0.095, 0.095);
        let scores = OpeningScores::of(&empty, &passage, robot);
        assert_eq!(scores.false_occupied, 0);
        assert!(scores.frontier > 0, "{scores:?}");
        let elsewhere = OpeningScores::of(&empty, &passage, Vector::new(1.0, 1.0));
        assert_eq!(elsewhere.frontier, 0);
    }
}
