//! Smooth lines: how much of each pixel a stroke of the pen covers.

use super::picture::{Colour, Picture};

/// A point of the picture, pixels from its left and top edge.
pub(crate) type Place = (f64, f64);

/// Beyond this a place is an error of its maker, not a place, pixels.
const FARTHEST: f64 = 1e7;

/// Places closer than this draw as one, pixels.
const FINEST: f64 = 0.1;

/// The covered share of every pixel of an area, 255 for all of it.
///
/// A stroke covers a pixel once, however often it passes: lines of one stroke that
/// meet or cross leave no darker dots.
pub(crate) struct Stroke {
    width: usize,
    height: usize,
    coverage: Vec<u8>,
}

impl Stroke {
    /// An area without a stroke.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            coverage: vec![0; width * height],
        }
    }

    /// Draws through places with a round pen; one place alone gives a dot.
    ///
    /// NaN, infinite and absurdly far places are left out.
    pub(crate) fn line(&mut self, places: impl IntoIterator<Item = Place>, pen_px: f64) {
        let near = |place: &Place| place.0.abs() < FARTHEST && place.1.abs() < FARTHEST;
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
    fn segment(&mut self, from: Place, to: Place, radius: f64) {
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

    /// Mixes the colour into the picture as far as it is covered; the area begins at (x, y).
    pub(crate) fn blend(&self, picture: &mut Picture, x: usize, y: usize, colour: Colour) {
        for (down, row) in self.coverage.chunks(self.width.max(1)).enumerate() {
            for (along, covered) in row.iter().enumerate() {
                if *covered > 0 {
                    picture.blend(x + along, y + down, colour, *covered);
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

    fn covered(stroke: &Stroke, x: usize, y: usize) -> u8 {
        stroke.coverage[y * stroke.width + x]
    }

    #[test]
    fn a_line_covers_its_width_and_no_more() {
        let mut stroke = Stroke::new(20, 10);
        stroke.line([(4.0, 5.0), (15.0, 5.0)], 2.0);
        for x in 4..15 {
            let column: Vec<_> = (0..10).map(|y| covered(&stroke, x, y)).collect();
            assert_eq!(column, [0, 0, 0, 0, 255, 255, 0, 0, 0, 0], "column {x}");
        }
        assert_eq!(covered(&stroke, 1, 5), 0);
        assert_eq!(covered(&stroke, 18, 5), 0);
    }

    #[test]
    fn slanted_lines_cover_length_times_width() {
        // A 3-4-5 triangle's long side.
        let (from, to, length) = ((30.3, 20.7), (110.3, 80.7), 100.0);
        let mut stroke = Stroke::new(200, 100);
        stroke.line([from, to], 3.0);
        let area = stroke.coverage.iter().map(|c| f64::from(*c)).sum::<f64>() / 255.0;
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
        let (mut once, mut twice) = (Stroke::new(20, 10), Stroke::new(20, 10));
        once.line(places, 1.5);
        twice.line([places[0], places[1], places[0], places[1]], 1.5);
        assert_eq!(once.coverage, twice.coverage);
    }

    #[test]
    fn places_outside_and_places_that_are_none_do_no_harm() {
        let mut stroke = Stroke::new(20, 10);
        stroke.line([(f64::NAN, 5.0), (1e300, 5.0), (f64::INFINITY, 0.0)], 2.0);
        assert!(stroke.coverage.iter().all(|c| *c == 0));
        stroke.line([(-1e6, 5.0), (1e6, 5.0)], 2.0);
        assert!((0..20).all(|x| covered(&stroke, x, 4) == 255));
        Stroke::new(0, 0).line([(0.0, 0.0), (5.0, 5.0)], 2.0);
    }
}
