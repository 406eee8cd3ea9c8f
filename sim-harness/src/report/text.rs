//! Lines of text, in a font that is part of the program.

use noto_sans_mono_bitmap::{
    FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width,
};

use super::picture::{Colour, Picture};

/// Colour of text and scale.
pub(crate) const INK: Colour = [40, 40, 40];

/// Drawn in place of a letter that the font lacks.
const MISSING: char = '?';

/// The font in one size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Font {
    height: RasterHeight,
}

impl Font {
    /// For titles.
    pub(crate) const LARGE: Self = Self {
        height: RasterHeight::Size20,
    };
    /// For labels.
    pub(crate) const SMALL: Self = Self {
        height: RasterHeight::Size16,
    };

    /// Height of a line, pixels.
    pub(crate) fn height(self) -> usize {
        self.height.val()
    }

    /// Width of a text on one line, pixels.
    pub(crate) fn width(self, text: &str) -> usize {
        text.chars().count() * self.advance()
    }

    fn advance(self) -> usize {
        get_raster_width(FontWeight::Regular, self.height)
    }

    /// The text in lines no wider than given, broken at spaces where there are some.
    ///
    /// At most `lines`; a longer text ends in "...".
    pub(crate) fn wrapped(self, text: &str, width: usize, lines: usize) -> Vec<String> {
        let room = (width / self.advance()).max(4);
        let mut wrapped = vec![String::new()];
        for word in text.split_whitespace() {
            for piece in pieces(word, room) {
                let used = wrapped.last().map_or(0, |line| line.chars().count());
                if used > 0 && used + 1 + piece.chars().count() > room {
                    wrapped.push(String::new());
                }
                if let Some(line) = wrapped.last_mut() {
                    let space = if line.is_empty() { "" } else { " " };
                    *line = format!("{line}{space}{piece}");
                }
            }
        }
        if wrapped.len() > lines {
            wrapped.truncate(lines);
            if let Some(line) = wrapped.last_mut() {
                *line = line.chars().take(room - 3).chain("...".chars()).collect();
            }
        }
        wrapped
    }

    /// Draws one line of text with its upper left corner at (x, y).
    pub(crate) fn draw(self, picture: &mut Picture, x: usize, y: usize, text: &str, ink: Colour) {
        for (index, letter) in text.chars().enumerate() {
            let Some(glyph) = self.glyph(letter).or_else(|| self.glyph(MISSING)) else {
                continue;
            };
            let left = x + index * self.advance();
            for (down, row) in glyph.rows().enumerate() {
                for (along, covered) in row.iter().enumerate() {
                    picture.blend(left + along, y + down, ink, *covered);
                }
            }
        }
    }

    fn glyph(self, letter: char) -> Option<RasterizedChar> {
        get_raster(letter, FontWeight::Regular, self.height)
    }
}

/// A word in pieces of at most `room` letters.
fn pieces(word: &str, room: usize) -> Vec<String> {
    let letters: Vec<char> = word.chars().collect();
    letters.chunks(room).map(String::from_iter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_breaks_at_spaces_and_ends_in_dots() {
        let letters = Font::LARGE;
        let width = letters.width("0123456789");
        assert_eq!(
            letters.wrapped("paper and plus", width, 3),
            ["paper and", "plus"]
        );
        assert_eq!(
            letters.wrapped("incomprehensibilities", width, 3),
            ["incomprehe", "nsibilitie", "s"]
        );
        assert_eq!(
            letters.wrapped("one two three four five six", width, 2),
            ["one two", "three f..."]
        );
        assert_eq!(letters.wrapped(" \n ", width, 3), [""]);
    }

    #[test]
    fn letters_leave_ink_within_their_line() {
        let mut picture = Picture::new(200, 40, [255; 3]);
        Font::SMALL.draw(&mut picture, 10, 10, "100 mm, 3\u{b0} \u{4e2d}", [0; 3]);
        let inked: Vec<usize> = (0..40)
            .filter(|y| (0..200).any(|x| picture.pixel(x, *y) != Some([255; 3])))
            .collect();
        assert!(inked.len() >= 10, "{inked:?}");
        assert!(inked.iter().all(|y| (10..26).contains(y)), "{inked:?}");
        let end = 10 + Font::SMALL.width("100 mm, 3d x");
        assert!((0..40).all(|y| picture.pixel(end, y) == Some([255; 3])));
    }
}
