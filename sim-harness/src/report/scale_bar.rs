//! A scale bar of a round length.

use super::picture::Picture;
use super::text::{Font, INK};

/// Least length of the bar, pixels.
const SHORTEST_PX: f64 = 60.0;

/// Height of the end marks, pixels.
const MARK_PX: usize = 11;

/// Draws a bar of a round length with end marks, and its length beside it.
///
/// (x, y) is the upper left corner of a line of small text that holds both.
pub(crate) fn draw_scale_bar(picture: &mut Picture, (x, y): (usize, usize), pixel_m: f64) {
    let (length_m, label) = scale(SHORTEST_PX * pixel_m);
    let length = (length_m / pixel_m).round() as usize;
    let middle = y + Font::SMALL.height() / 2;
    let marks_y = middle - MARK_PX / 2;
    picture.fill(x, middle - 1, (length, 3), INK);
    picture.fill(x, marks_y, (2, MARK_PX), INK);
    picture.fill(x + length - 2, marks_y, (2, MARK_PX), INK);
    Font::SMALL.draw(picture, x + length + 8, y, &label, INK);
}

/// The first of 1, 2, 5, 10, ... that is not shorter than the given length, in metres and
/// in words.
fn scale(shortest_m: f64) -> (f64, String) {
    const UNITS: [(f64, &str); 4] = [(1e-6, "um"), (1e-3, "mm"), (1.0, "m"), (1e3, "km")];
    for (unit_m, unit) in UNITS {
        for count in [1, 2, 5, 10, 20, 50, 100, 200, 500] {
            let length_m = f64::from(count) * unit_m;
            // A millionth shorter is as long: 100 mm asked for as 0.1 m times a rounding.
            if length_m >= shortest_m * (1.0 - 1e-6) {
                return (length_m, format!("{count} {unit}"));
            }
        }
    }
    (shortest_m, format!("{:.0} km", shortest_m * 1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_have_round_lengths() {
        for (shortest_m, length_m, label) in [
            (0.06 * 100.0 / 90.0, 0.1, "100 mm"),
            (0.1 + 1e-12, 0.1, "100 mm"),
            (0.12, 0.2, "200 mm"),
            (0.03, 0.05, "50 mm"),
            (0.7, 1.0, "1 m"),
            (900.0, 1000.0, "1 km"),
            (0.000_3, 0.000_5, "500 um"),
        ] {
            let (drawn_m, words) = scale(shortest_m);
            assert!((drawn_m - length_m).abs() < 1e-9, "{shortest_m}");
            assert_eq!(words, label);
        }
    }
}
