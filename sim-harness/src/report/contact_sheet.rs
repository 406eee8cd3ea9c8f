//! Small maps of one drive on one sheet.

use super::cell_window::CellWindow;
use super::map_overlay::MapOverlay;
use super::map_picture::MapPicture;
use super::picture::{PAPER, Picture};
use super::pixel_grid::PixelGrid;
use super::text::{Font, INK};
use crate::mapping::Map;

/// Longer side of a small map, pixels.
const SIDE_PX: usize = 300;

/// Maps in a row.
const COLUMNS: usize = 6;

/// Pixels between the maps, and lines of a label.
const GAP: usize = 14;
const LABEL_LINES: usize = 3;

/// Small maps of one drive, all of one part of the world, with labels.
#[derive(Debug)]
pub struct ContactSheet<'a> {
    window: CellWindow,
    path: &'a [(f64, f64)],
    jumps: &'a [usize],
    panels: Vec<(String, Picture)>,
}

impl<'a> ContactSheet<'a> {
    /// An empty sheet of maps that show a window, with the robot's path and the indices of its
    /// places that are not joined to the one before.
    #[must_use]
    pub fn new(window: CellWindow, path: &'a [(f64, f64)], jumps: &'a [usize]) -> Self {
        Self {
            window,
            path,
            jumps,
            panels: Vec::new(),
        }
    }

    /// Adds a map under a label. A square of cells is one pixel where a cell would be less:
    /// occupied if one of them is, else free if one of them is.
    pub fn add(&mut self, label: String, map: &Map) {
        let grid = PixelGrid::small(&self.window, map.lattice(), SIDE_PX);
        let mut drawing = grid.cells(map, &self.window);
        let overlay = MapPicture {
            path: self.path,
            jumps: self.jumps,
            ..MapPicture::default()
        };
        MapOverlay::new(&overlay).draw(&mut drawing, &grid);
        self.panels.push((label, drawing));
    }

    /// The sheet, row by row; no map at all gives one white pixel.
    #[must_use]
    pub fn render(&self) -> Picture {
        let font = Font::SMALL;
        let sizes = self
            .panels
            .iter()
            .map(|(_, map)| (map.width(), map.height()));
        let (width, height) = sizes.fold((0, 0), |(width, height), (w, h)| {
            (w.max(width), h.max(height))
        });
        if self.panels.is_empty() {
            return Picture::new(1, 1, PAPER);
        }
        let room = LABEL_LINES * font.height() + 4;
        let (columns, rows) = (
            self.panels.len().min(COLUMNS),
            self.panels.len().div_ceil(COLUMNS),
        );
        let (step_x, step_y) = (width + GAP, height + room + GAP);
        let mut sheet = Picture::new(columns * step_x + GAP, rows * step_y + GAP, PAPER);
        for (number, (label, map)) in self.panels.iter().enumerate() {
            let x = GAP + number % COLUMNS * step_x;
            let y = GAP + number / COLUMNS * step_y;
            for (line, text) in label.lines().take(LABEL_LINES).enumerate() {
                font.draw(&mut sheet, x, y + line * font.height(), text, INK);
            }
            sheet.paste(x, y + room, map);
        }
        sheet
    }
}
