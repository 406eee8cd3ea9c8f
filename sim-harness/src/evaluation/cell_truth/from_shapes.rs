//! The truth about cells from walls that are known exactly.

use std::collections::VecDeque;

use super::wall_cells::WallCells;
use super::{TrueCell, TrueCells};
use crate::geometry::{Rectangle, Vector};
use crate::lattice::{Cell, Lattice};
use crate::world::TrueWorld;

/// Rounding that is forgiven in distances, metres.
const ROUNDING_M: f64 = 1e-9;

/// The truth from known surfaces and the places of the robot.
///
/// A cell is occupied if a surface passes within half a cell of its centre. The cells that
/// are connected with the robot's places over cells without a surface, side by side, are
/// free. Of places on several sides of a wall the room with most of them counts: the others
/// are errors of the poses. The rest is outside: what lies behind the walls, and the inside
/// of closed blocks. Cells beyond `extent` are outside. `None` for a world that a scanner
/// has to measure.
///
/// Where the room is larger than a grid, the truth is cut, and its
/// [`Grid::refused`](crate::mapping::Grid::refused) is not 0.
///
/// Cost: the cells of each room that may have most of the places, and per tile of them the
/// number of walls; in a scenario, the cells times the number of shapes. Memory: two rooms.
#[must_use]
pub fn truth_of_shapes(
    world: &TrueWorld,
    lattice: Lattice,
    places: &[Vector],
    extent: &Rectangle,
) -> Option<TrueCells> {
    let half_m = 0.5 * lattice.cell_m() + ROUNDING_M;
    let mut is_surface: Box<dyn FnMut(Cell) -> bool> = match world {
        TrueWorld::Scanner => return None,
        TrueWorld::Walls(walls) => {
            let mut cells = WallCells::new(walls, lattice, half_m);
            Box::new(move |cell| cells.is_wall(cell))
        }
        TrueWorld::Scenario(scenario) => Box::new(move |cell| {
            let (x, y) = lattice.centre(cell);
            let mut shapes = scenario.shapes.iter();
            shapes.any(|shape| shape.distance_m(Vector::new(x, y)) <= half_m)
        }),
    };
    let starts = places.iter().filter_map(|it| lattice.cell_at(it.x, it.y));
    let mut starts: Vec<Cell> = starts.filter(|start| !is_surface(*start)).collect();
    let mut cells = TrueCells::new(lattice, TrueCell::Outside);
    let mut most = 0;
    while let Some(start) = starts.first().filter(|_| starts.len() > most) {
        let mut room = TrueCells::new(lattice, TrueCell::Outside);
        flood(&mut room, *start, extent, &mut *is_surface);
        let before = starts.len();
        // The first one too, which may lie beyond the extent.
        let first = *start;
        starts.retain(|start| *start != first && room.get(*start) != Some(&TrueCell::Free));
        let inside = before - starts.len();
        if inside > most && room.get(first) == Some(&TrueCell::Free) {
            (cells, most) = (room, inside);
        }
    }
    Some(cells)
}

/// Number of places in free cells.
pub(super) fn places_in(cells: &TrueCells, places: &[Vector]) -> usize {
    let is_free = |place: &&Vector| {
        let cell = cells.cell_at(place.x, place.y);
        cell.and_then(|cell| cells.get(cell)) == Some(&TrueCell::Free)
    };
    places.iter().filter(is_free).count()
}

/// Finds the free cells that are connected with a cell, and the surfaces around them.
fn flood(
    cells: &mut TrueCells,
    start: Cell,
    extent: &Rectangle,
    is_surface: &mut dyn FnMut(Cell) -> bool,
) {
    // First in, first out: it holds the edge of the room, where a stack holds all of it.
    let mut open = VecDeque::from([start]);
    let mut enter = |cell: Cell| {
        let (x, y) = cells.centre(cell);
        let is_near = extent.contains(Vector::new(x, y));
        let held = is_near.then(|| cells.reach(cell)).flatten();
        let Some(held) = held.filter(|held| **held == TrueCell::Outside) else {
            return false;
        };
        let is_free = !is_surface(cell);
        *held = if is_free {
            TrueCell::Free
        } else {
            TrueCell::Occupied
        };
        is_free
    };
    if !enter(start) {
        return;
    }
    while let Some(cell) = open.pop_front() {
        let neighbours = [(0, 1), (0, -1), (1, 0), (-1, 0)].map(|(row, column)| Cell {
            row: cell.row + row,
            column: cell.column + column,
        });
        open.extend(neighbours.into_iter().filter(|cell| enter(*cell)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_is_free_up_to_its_walls_and_the_inside_of_a_block_is_outside() {
        let corner = |x: f64, y: f64| Vector::new(x, y);
        let square = |low: f64, high: f64| {
            [
                [corner(low, low), corner(high, low)],
                [corner(high, low), corner(high, high)],
                [corner(high, high), corner(low, high)],
                [corner(low, high), corner(low, low)],
            ]
        };
        let walls: Vec<_> = [square(0.0, 2.0), square(1.0, 1.5)].concat();
        let world = TrueWorld::Walls(walls);
        assert!(world.lies_on_borders(0.1) && !world.lies_on_borders(0.07));
        let lattice = Lattice::new(0.1).moved_by_half_a_cell();
        let extent = Rectangle {
            min: corner(-5.0, -5.0),
            max: corner(5.0, 5.0),
        };
        let cells = truth_of_shapes(&world, lattice, &[corner(0.5, 0.5)], &extent).unwrap();
        // 19 x 19 cells within the room, 6 x 6 of the block, its outline 20. The corners of
        // the room are not reached side by side.
        assert_eq!(cells.number_of(TrueCell::Free), 19 * 19 - 36);
        assert_eq!(cells.number_of(TrueCell::Occupied), 4 * 19 + 20);
        let at = |x, y| cells.get(lattice.cell_at(x, y).unwrap()).copied();
        assert_eq!(at(1.25, 1.25), Some(TrueCell::Outside));
        assert_eq!(at(1.0, 1.2), Some(TrueCell::Occupied));
        // A place that is wrong, behind the wall, does not open the world outside.
        let places = [corner(2.1, 1.0), corner(0.5, 0.5), corner(0.6, 0.5)];
        let same = truth_of_shapes(&world, lattice, &places, &extent).unwrap();
        assert_eq!(same, cells);
        assert_eq!(places_in(&same, &places), 2);
    }
}
