//! The legend: a square of colour and a name for each layer that has one.

use crate::figures::lettering::{INK, Lettering};
use crate::figures::picture::{Colour, Picture};

/// Side of a square of colour, pixels.
const SQUARE_PX: usize = 12;

/// Space between a square and its name, pixels.
const GAP_PX: usize = 6;

/// Space between two entries, pixels.
const BETWEEN_PX: usize = 18;

/// Names with their places, in as many lines as the width needs.
pub(super) struct Legend<'a> {
    entries: Vec<(usize, usize, &'a str, Colour)>,
    lines: usize,
}

impl<'a> Legend<'a> {
    /// Lays out the names in lines no wider than given.
    pub(super) fn new(names: impl Iterator<Item = (&'a str, Colour)>, width: usize) -> Self {
        let (mut x, mut line) = (0, 0);
        let mut entries = Vec::new();
        for (name, colour) in names {
            let room = SQUARE_PX + GAP_PX + Lettering::SMALL.width(name);
            if x > 0 && x + room > width {
                (x, line) = (0, line + 1);
            }
            entries.push((x, line, name, colour));
            x += room + BETWEEN_PX;
        }
        Self {
            lines: if entries.is_empty() { 0 } else { line + 1 },
            entries,
        }
    }

    /// Height of all lines, pixels.
    pub(super) fn height(&self) -> usize {
        self.lines * line_height()
    }

    /// Draws the legend with its upper left corner at (x, y).
    pub(super) fn draw(&self, picture: &mut Picture, x: usize, y: usize) {
        for (along, line, name, colour) in &self.entries {
            let (x, y) = (x + along, y + line * line_height());
            let middle = (Lettering::SMALL.height() - SQUARE_PX) / 2;
            picture.fill(x, y + middle, (SQUARE_PX, SQUARE_PX), *colour);
            let text_x = x + SQUARE_PX + GAP_PX;
            Lettering::SMALL.draw(picture, text_x, y, name, INK);
        }
    }
}

fn line_height() -> usize {
    Lettering::SMALL.height() + 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_do_not_fit_go_to_the_next_line() {
        let names = || [("paper", [0; 3]), ("plus", [1; 3])].into_iter();
        assert_eq!(Legend::new(names(), 1000).lines, 1);
        assert_eq!(Legend::new(names(), 100).lines, 2);
        assert_eq!(Legend::new(names().take(0), 100).height(), 0);
    }
}
