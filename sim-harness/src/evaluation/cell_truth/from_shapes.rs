//! The truth about cells from walls that are known exactly.

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
/// are errors of the poses. The rest is outside: what lies behind the walls, and the inside of closed blocks.
/// Cells beyond `extent` are outside. `None` for a world that a scanner has to measure.
///
/// Cost: the cells within the walls, times the number of surfaces, for each room that a
/// place lies in.
#[must_use]
pub fn truth_of_shapes(
    world: &TrueWorld,
    lattice: Lattice,
    places: &[Vector],
    extent: &Rectangle,
) -> Option<TrueCells> {
    let half_m = 0.5 * lattice.cell_m() + ROUNDING_M;
    let is_surface: Box<dyn Fn(Vector) -> bool> = match world {
        TrueWorld::Scanner => return None,
        TrueWorld::Walls(walls) => Box::new(move |place: Vector| {
            let distances = walls.iter();
            distances
                .map(|[from, to]| place.distance_from_segment(*from, *to))
                .any(|distance_m| distance_m <= half_m)
        }),
        TrueWorld::Scenario(scenario) => Box::new(move |place: Vector| {
            let mut shapes = scenario.shapes.iter();
            shapes.any(|shape| shape.distance_m(place) <= half_m)
        }),
    };
    let mut cells = TrueCells::new(lattice, TrueCell::Outside);
    let mut most = 0;
    for start in places.iter().filter_map(|it| lattice.cell_at(it.x, it.y)) {
        if cells
            .get(start)
            .is_some_and(|held| *held != TrueCell::Outside)
        {
            continue;
        }
        let mut room = TrueCells::new(lattice, TrueCell::Outside);
        flood(&mut room, start, extent, &is_surface);
        let inside = places_in(&room, places);
        if inside > most {
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
    is_surface: &dyn Fn(Vector) -> bool,
) {
    let mut open = vec![start];
    while let Some(cell) = open.pop() {
        let (x, y) = cells.centre(cell);
        let centre = Vector::new(x, y);
        let Some(held) = extent.contains(centre).then(|| cells.reach(cell)).flatten() else {
            continue;
        };
        if *held != TrueCell::Outside {
            continue;
        }
        if is_surface(centre) {
            *held = TrueCell::Occupied;
            continue;
        }
        *held = TrueCell::Free;
        let neighbours = [(0, 1), (0, -1), (1, 0), (-1, 0)];
        open.extend(neighbours.map(|(row, column)| Cell {
            row: cell.row + row,
            column: cell.column + column,
        }));
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
