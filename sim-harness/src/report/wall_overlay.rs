//! Wall segments over a map, with their uncertainty.

use super::line_drawing::LineDrawing;
use super::picture::{Colour, Picture};
use super::pixel_grid::PixelGrid;
use crate::drive::WallState;
use crate::geometry::Vector;

/// Colour of the wall segments.
pub const WALL: Colour = [230, 130, 0];

/// Width of a segment and of the edge of its band, pixels.
const PEN_PX: f64 = 2.0;
const EDGE_PX: f64 = 1.0;

/// Standard deviations from a segment to the edge of its band.
const SIGMAS: f64 = 2.0;

/// Most that a band exceeds an end, metres: an end may be open.
const MOST_M: f64 = 0.05;

/// Draws each segment as a line, and the band of two standard deviations as its outline.
pub(super) fn draw_walls(walls: &[WallState], drawing: &mut Picture, grid: &PixelGrid) {
    let mut lines = LineDrawing::new(drawing.width(), drawing.height());
    let place = |at: Vector| grid.place((at.x, at.y));
    for wall in walls {
        lines.line(wall.ends.map(place), PEN_PX);
        let corners = band(wall);
        let first = corners.first().copied();
        lines.line(corners.into_iter().chain(first).map(place), EDGE_PX);
    }
    lines.blend(drawing, WALL);
}

/// The corners of the band of two standard deviations.
fn band(wall: &WallState) -> [Vector; 4] {
    let [from, to] = wall.ends;
    let [along_0, along_1] = wall.along_m.map(margin_m);
    let [across_0, across_1] = wall.across_m.map(margin_m);
    let way = to - from;
    let along = way.scaled(1.0 / way.norm().max(1e-9));
    let left = Vector::new(-along.y, along.x);
    let (from, to) = (from - along.scaled(along_0), to + along.scaled(along_1));
    [
        from - left.scaled(across_0),
        to - left.scaled(across_1),
        to + left.scaled(across_1),
        from + left.scaled(across_0),
    ]
}

fn margin_m(sigma_m: Option<f64>) -> f64 {
    sigma_m.map_or(MOST_M, |sigma_m| (SIGMAS * sigma_m).min(MOST_M))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_two_deviations_wide_and_an_open_end_has_a_bound() {
        let wall = WallState {
            ends: [Vector::new(1.0, 0.0), Vector::new(1.0, 0.2)],
            along_m: [Some(0.01), None],
            across_m: [Some(0.002), Some(0.003)],
            evidence: 40.0,
        };
        // The wall goes up: left of it is -x.
        let expected = [(1.004, -0.02), (1.006, 0.25), (0.994, 0.25), (0.996, -0.02)];
        for (corner, (x, y)) in band(&wall).into_iter().zip(expected) {
            assert!((corner - Vector::new(x, y)).norm() < 1e-9, "{corner:?}");
        }
    }
}
