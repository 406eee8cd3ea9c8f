//! The legend: a coloured square and a name for each layer that has a name.

use crate::report::picture::Picture;
use crate::report::text::{Font, INK};

use super::layer::Layer;

/// Side of a coloured square, pixels.
const SQUARE_PX: usize = 12;

/// Space between a square and its name, pixels.
const GAP_PX: usize = 6;

/// Space between two entries, pixels.
const BETWEEN_PX: usize = 18;

/// Space between two lines, pixels.
const LEADING_PX: usize = 4;

/// The entries in as many lines as the width needs.
pub(super) struct Legend<'l> {
    /// Left edge, line number and layer of each entry.
    entries: Vec<(usize, usize, &'l Layer)>,
}

impl<'l> Legend<'l> {
    /// Lays out the names of the layers in lines no wider than given.
    pub(super) fn new(layers: &'l [Layer], width: usize) -> Self {
        let (mut x, mut line) = (0, 0);
        let mut entries = Vec::new();
        for layer in layers.iter().filter(|layer| !layer.name.is_empty()) {
            let room = SQUARE_PX + GAP_PX + Font::SMALL.width(&layer.name);
            if x > 0 && x + room > width {
                (x, line) = (0, line + 1);
            }
            entries.push((x, line, layer));
            x += room + BETWEEN_PX;
        }
        Self { entries }
    }

    /// Height of all lines, pixels.
    pub(super) fn height(&self) -> usize {
        let lines = self.entries.last().map_or(0, |(_, line, _)| line + 1);
        lines * (Font::SMALL.height() + LEADING_PX)
    }

    /// Draws the legend with its upper left corner at (x, y).
    pub(super) fn draw(&self, picture: &mut Picture, x: usize, y: usize) {
        for (along, line, layer) in &self.entries {
            let (x, y) = (x + along, y + line * (Font::SMALL.height() + LEADING_PX));
            let square_y = y + (Font::SMALL.height() - SQUARE_PX) / 2;
            picture.fill(x, square_y, (SQUARE_PX, SQUARE_PX), layer.colour);
            Font::SMALL.draw(picture, x + SQUARE_PX + GAP_PX, y, &layer.name, INK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_do_not_fit_go_to_the_next_line() {
        let layers = ["paper", "plus", ""].map(|name| Layer {
            name: name.to_owned(),
            colour: [0; 3],
            marks: Vec::new(),
        });
        let line = Font::SMALL.height() + LEADING_PX;
        assert_eq!(Legend::new(&layers, 1000).height(), line);
        assert_eq!(Legend::new(&layers, 100).height(), 2 * line);
        assert_eq!(Legend::new(&layers[2..], 100).height(), 0);
    }
}
