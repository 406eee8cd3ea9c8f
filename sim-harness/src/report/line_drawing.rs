//! Smooth lines: the share of each pixel that a round pen covers.

use super::picture::{Colour, Picture};

/// A point of the picture, pixels from its left and top edge.
pub(crate) type PixelPosition = (f64, f64);

/// Positions beyond this are left out, pixels: no drawing is that large.
const FARTHEST: f64 = 1e7;

/// Positions closer than this are drawn as one, pixels.
const FINEST: f64 = 0.1;

/// The covered share of every pixel of an area; 255 is a whole pixel.
///
/// Lines of one drawing that meet or cross leave no darker dots: the share of a pixel
/// is the largest that any of them covers.
pub(crate) struct LineDrawing {
    width: usize,
    height: usize,
    coverage: Vec<u8>,
}

impl LineDrawing {
    /// An area without lines.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            coverage: vec![0; width * height],
        }
    }

    /// Draws through positions with a round pen; one position alone gives a dot.
    ///
    /// NaN, infinite and far positions are left out.
    pub(crate) fn line(&mut self, places: impl IntoIterator<Item = PixelPosition>, pen_px: f64) {
        let near = |place: &PixelPosition| place.0.abs() < FARTHEST && place.1.abs() < FARTHEST;
        let mut places = places.into_iter().filter(near);
        let Some(mut from) = places.next() else {
            return;
        };
        self.segment(from, from, 0.5 * pen_px);
        for to in places {
            let (along, down) = (to.0 - from.0, to.1 - from.1);
            if along * along + down * down >= FINEST * FINEST {
                self.segment(from, to, 0.5 * pen_px);
                from = to;
            }
        }
    }

    /// Covers what lies within `radius` of a segment; half a pixel further it fades to nothing.
    fn segment(&mut self, from: PixelPosition, to: PixelPosition, radius: f64) {
        let reach = radius + 0.5;
        let (along, down) = (to.0 - from.0, to.1 - from.1);
        let length_squared = along * along + down * down;
        let (top, bottom) = (from.1.min(to.1) - reach, from.1.max(to.1) + reach);
        for y in clamped(top, self.height)..clamped(bottom + 1.0, self.height) {
            let middle = y as f64 + 0.5;
            // The piece of the segment that is near this row bounds the columns.
            let (start, end) = if down.abs() < FINEST {
                (0.0, 1.0)
            } else {
                let one = ((middle - reach - from.1) / down).clamp(0.0, 1.0);
                let other = ((middle + reach - from.1) / down).clamp(0.0, 1.0);
                (one, other)
            };
            let (one, other) = (from.0 + start * along, from.0 + end * along);
            let left = clamped(one.min(other) - reach, self.width);
            let right = clamped(one.max(other) + reach + 1.0, self.width);
            let row = self.coverage.iter_mut().skip(y * self.width);
            for (x, covered) in row.enumerate().take(right).skip(left) {
                let (dx, dy) = (x as f64 + 0.5 - from.0, middle - from.1);
                let foot = if length_squared > 0.0 {
                    ((dx * along + dy * down) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let (dx, dy) = (dx - foot * along, dy - foot * down);
                let share = (reach - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0);
                *covered = (*covered).max((share * 255.0 + 0.5) as u8);
            }
        }
    }

    /// Mixes the colour into a picture of the same size, pixel by pixel as far as covered.
    pub(crate) fn blend(&self, picture: &mut Picture, colour: Colour) {
        for (y, row) in self.coverage.chunks(self.width.max(1)).enumerate() {
            for (x, covered) in row.iter().enumerate() {
                if *covered > 0 {
                    picture.blend(x, y, colour, *covered);
                }
            }
        }
    }
}

/// The pixel that holds a coordinate, at least 0 and at most `end`.
fn clamped(coordinate: f64, end: usize) -> usize {
    // The cast saturates: below zero gives 0.
    (coordinate.floor() as usize).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(drawing: &LineDrawing, x: usize, y: usize) -> u8 {
        drawing.coverage[y * drawing.width + x]
    }

    #[test]
    fn a_line_covers_its_width_and_no_more() {
        let mut drawing = LineDrawing::new(20, 10);
        drawing.line([(4.0, 5.0), (15.0, 5.0)], 2.0);
        for x in 4..15 {
            let column: Vec<_> = (0..10).map(|y| covered(&drawing, x, y)).collect();
            assert_eq!(column, [0, 0, 0, 0, 255, 255, 0, 0, 0, 0], "column {x}");
        }
        assert_eq!(covered(&drawing, 1, 5), 0);
        assert_eq!(covered(&drawing, 18, 5), 0);
    }

    #[test]
    fn slanted_lines_cover_length_times_width() {
        // A 3-4-5 triangle's long side.
        let (from, to, length) = ((30.3, 20.7), (110.3, 80.7), 100.0);
        let mut drawing = LineDrawing::new(200, 100);
        drawing.line([from, to], 3.0);
        let area = drawing.coverage.iter().map(|c| f64::from(*c)).sum::<f64>() / 255.0;
        let expected = 3.0 * length + core::f64::consts::PI * 1.5 * 1.5;
        // Coverage by distance differs from true coverage by some hundredths a pixel of edge.
        assert!(
            (area / expected - 1.0).abs() < 0.01,
            "{area}, not {expected}"
        );
    }

    #[test]
    fn passing_twice_covers_no_more_than_once() {
        let places = [(3.2, 4.1), (17.5, 8.3)];
        let (mut once, mut twice) = (LineDrawing::new(20, 10), LineDrawing::new(20, 10));
        once.line(places, 1.5);
        twice.line([places[0], places[1], places[0], places[1]], 1.5);
        assert_eq!(once.coverage, twice.coverage);
    }

    #[test]
    fn places_outside_and_places_that_are_none_do_no_harm() {
        let mut drawing = LineDrawing::new(20, 10);
        drawing.line([(f64::NAN, 5.0), (1e300, 5.0), (f64::INFINITY, 0.0)], 2.0);
        assert!(drawing.coverage.iter().all(|c| *c == 0));
        drawing.line([(-1e6, 5.0), (1e6, 5.0)], 2.0);
        assert!((0..20).all(|x| covered(&drawing, x, 4) == 255));
        LineDrawing::new(0, 0).line([(0.0, 0.0), (5.0, 5.0)], 2.0);
    }
}
