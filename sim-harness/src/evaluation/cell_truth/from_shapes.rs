//! The truth about cells from walls that are known exactly.

use super::{TrueCell, TrueCells};
use crate::drive::TrueWorld;
use crate::geometry::{Rectangle, Vector};
use crate::lattice::{Cell, Lattice};

/// Rounding that is forgiven in distances, metres.
const ROUNDING_M: f64 = 1e-9;

/// The truth from known surfaces and the places of the robot.
///
/// A cell is occupied if a surface passes within half a cell of its centre. The cells that
/// are connected with the robot's places over cells without a surface, side by side, are
/// free; the rest is outside: what lies behind the walls, and the inside of closed blocks.
/// Cells beyond `extent` are outside. `None` for a world that a scanner has to measure.
///
/// Cost: the cells within the walls, times the number of surfaces.
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
    let mut open: Vec<Cell> = places
        .iter()
        .filter_map(|place| lattice.cell_at(place.x, place.y))
        .collect();
    while let Some(cell) = open.pop() {
        let (x, y) = lattice.centre(cell);
        let centre = Vector::new(x, y);
        if !extent.contains(centre) {
            continue;
        }
        let Some(held) = cells.reach(cell) else {
            continue;
        };
        if *held != TrueCell::Outside {
            continue;
        }
        let is_surface = is_surface(centre);
        *held = if is_surface {
            TrueCell::Occupied
        } else {
            TrueCell::Free
        };
        if !is_surface {
            open.extend(
                [(0, 1), (0, -1), (1, 0), (-1, 0)].map(|(row, column)| Cell {
                    row: cell.row + row,
                    column: cell.column + column,
                }),
            );
        }
    }
    Some(cells)
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
    }
}
