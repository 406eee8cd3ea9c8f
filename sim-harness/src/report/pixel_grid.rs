//! The cells of a map as pixels.

use crate::lattice::Lattice;
use crate::mapping::{Map, Occupancy};

use super::cell_window::CellWindow;
use super::line_drawing::PixelPosition;
use super::picture::{Colour, Picture};

/// Free cells.
pub const FREE: Colour = [255, 255, 255];

/// Occupied cells.
pub const OCCUPIED: Colour = [0, 0, 0];

/// Unknown cells.
pub const UNKNOWN: Colour = [160, 160, 160];

/// Greatest side of the map alone, pixels: the rest is for title, scale and border.
const MAX_MAP_PX: usize = 3840;

/// Wanted length of the map's longer side, pixels.
pub(crate) const WANTED_PX: usize = 900;

/// Least side of a cell, pixels: smaller cells are hard to see.
const SMALLEST_CELL_PX: usize = 3;

/// Greatest side of a cell, pixels.
pub(crate) const LARGEST_CELL_PX: usize = 24;

/// The mapping from cells to pixels.
pub(crate) struct PixelGrid {
    columns: usize,
    rows: usize,
    /// Cells along a side of the square that is drawn as one.
    block_cells: usize,
    /// Pixels along a side of that square.
    block_px: usize,
    pixel_m: f64,
    /// Left and upper edge of the drawing in the world, metres.
    corner_m: (f64, f64),
}

impl PixelGrid {
    /// The grid for a window, whose longer side has about `wanted_px`.
    pub(crate) fn new(window: &CellWindow, lattice: Lattice, wanted_px: usize) -> Self {
        Self::of(window, lattice, wanted_px, SMALLEST_CELL_PX, MAX_MAP_PX)
    }

    /// The grid for a window, whose longer side has at most `side_px`: a cell may be a part
    /// of a pixel.
    pub(crate) fn small(window: &CellWindow, lattice: Lattice, side_px: usize) -> Self {
        Self::of(window, lattice, side_px, 1, side_px)
    }

    fn of(
        window: &CellWindow,
        lattice: Lattice,
        wanted_px: usize,
        least_px: usize,
        most_px: usize,
    ) -> Self {
        let cells = window.columns().max(window.rows());
        let fitting = (most_px / cells).max(1);
        let block_px = (wanted_px / cells)
            .clamp(least_px, LARGEST_CELL_PX)
            .min(fitting);
        let block_cells = cells.div_ceil(most_px);
        let (columns, rows) = (
            window.columns().div_ceil(block_cells),
            window.rows().div_ceil(block_cells),
        );
        let cell_m = lattice.cell_m();
        let (left_m, bottom_m) = lattice.corner(window.low());
        Self {
            columns,
            rows,
            block_cells,
            block_px,
            pixel_m: cell_m * block_cells as f64 / block_px as f64,
            corner_m: (left_m, bottom_m + (rows * block_cells) as f64 * cell_m),
        }
    }

    /// Size of a pixel, metres.
    pub(crate) fn pixel_m(&self) -> f64 {
        self.pixel_m
    }

    /// Where a point of the world is drawn.
    pub(crate) fn place(&self, (x, y): (f64, f64)) -> PixelPosition {
        (
            (x - self.corner_m.0) / self.pixel_m,
            (self.corner_m.1 - y) / self.pixel_m,
        )
    }

    /// The cells alone.
    pub(crate) fn cells(&self, map: &Map, window: &CellWindow) -> Picture {
        let mut blocks = vec![UNKNOWN; self.columns * self.rows];
        for (cell, belief) in map.iter() {
            let colour = match belief.occupancy() {
                Occupancy::Unknown => continue,
                Occupancy::Free => FREE,
                Occupancy::Occupied => OCCUPIED,
            };
            let Some((column, row)) = window.offset(cell) else {
                continue;
            };
            let from_above = self.rows - 1 - row / self.block_cells;
            let index = from_above * self.columns + column / self.block_cells;
            if let Some(block) = blocks.get_mut(index).filter(|block| **block != OCCUPIED) {
                *block = colour;
            }
        }
        let (width, height) = (self.columns * self.block_px, self.rows * self.block_px);
        let mut picture = Picture::new(width, height, UNKNOWN);
        for (row, colours) in blocks.chunks(self.columns).enumerate() {
            for y in row * self.block_px..(row + 1) * self.block_px {
                let squares = picture.row_mut(y).chunks_mut(self.block_px);
                squares
                    .zip(colours)
                    .for_each(|(square, colour)| square.fill(*colour));
            }
        }
        picture
    }
}
