//! A fit of the photometric law: measured and expected counts, and the residuals.

use std::collections::BTreeMap;

use super::chart::{Axis, Chart, Mark};
use super::picture::{Colour, Picture, beside};
use crate::calibration::Fit;

const SIZE_PX: (usize, usize) = (520, 360);
const DOT_PX: f64 = 7.0;
const LINE_PX: f64 = 2.0;
/// Bearings get these colours in turn.
const COLOURS: [Colour; 5] = [
    [20, 110, 245],
    [235, 140, 30],
    [40, 150, 80],
    [190, 40, 140],
    [90, 90, 90],
];

/// Draws measured (dots) and expected counts (lines) over range, one colour per bearing,
/// and beside them the residuals.
///
/// Bearings are distinguished by whole degrees.
#[must_use]
pub fn fit_chart(fit: &Fit) -> Picture {
    let mut bearings: BTreeMap<i64, Vec<(f64, f64, f64)>> = BTreeMap::new();
    for (measured, expected) in fit.rows() {
        let degrees = measured.angle_rad.to_degrees().round() as i64;
        let range_mm = 1e3 * measured.range_m;
        let row = (range_mm, measured.counts, *expected);
        bearings.entry(degrees).or_default().push(row);
    }
    for rows in bearings.values_mut() {
        rows.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    }
    let all = || bearings.values().flatten().copied();
    let chart = |title: &str, label: &str, (low, high): (f64, f64)| {
        let (near, far) = bounds(all().map(|(range_mm, ..)| range_mm));
        let x = Axis::linear("range, mm", near, far);
        let level = Mark::Line(vec![(near, 0.0), (far, 0.0)], 1.0);
        (
            Chart::new(title, x, Axis::linear(label, low, high), SIZE_PX),
            level,
        )
    };
    let counts = bounds(all().flat_map(|(_, counts, fit)| [counts, fit]));
    let (mut counts, _) = chart("Measured, and the fitted law", "counts", counts);
    let residuals = bounds(all().map(|(_, counts, fit)| counts - fit).chain([0.0]));
    let label = "measured less fitted, counts";
    let (residuals, level) = chart("Residuals", label, residuals);
    let mut residuals = residuals.with("", [120, 120, 120], vec![level]);
    for ((degrees, rows), colour) in bearings.iter().zip(COLOURS.into_iter().cycle()) {
        let name = format!("{degrees} degrees");
        let points = |value: fn(f64, f64) -> f64| {
            let points = rows.iter().map(|&(x, counts, fit)| (x, value(counts, fit)));
            points.collect::<Vec<_>>()
        };
        let line = Mark::Line(points(|_, fit| fit), LINE_PX);
        let dots = |value| Mark::Dots(points(value), DOT_PX);
        counts = counts.with(&name, colour, vec![line, dots(|counts, _| counts)]);
        residuals = residuals.with(&name, colour, vec![dots(|counts, fit| counts - fit)]);
    }
    beside(&[counts.render(), residuals.render()])
}

/// The ends of an axis that includes all values, with a margin of a tenth on both sides.
fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low > high {
        return (0.0, 1.0);
    }
    let room = (0.1 * (high - low)).max(1e-3 * high.abs()).max(1e-3);
    (low - room, high + room)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{Fixed, Table, fit};

    #[test]
    fn a_fit_is_drawn_with_its_dots_and_the_same_twice() {
        let mut text = "range_mm,angle_deg,counts\n".to_owned();
        for (range, angle, counts) in [
            (50, 0, 361),
            (80, 0, 131),
            (120, 0, 49),
            (50, 30, 290),
            (80, 30, 104),
        ] {
            text += &format!("{range},{angle},{counts}\n");
        }
        let fixed = Fixed::parse(["delta=0"]).unwrap();
        let fit = fit(&Table::parse(&text).unwrap(), &fixed).unwrap();
        let bytes = |picture: &Picture| {
            let mut png = Vec::new();
            picture.write_png(&mut png).unwrap();
            png
        };
        let picture = fit_chart(&fit);
        assert_eq!(bytes(&picture), bytes(&fit_chart(&fit)));
        for colour in [COLOURS[0], COLOURS[1]] {
            let pixels = (0..picture.height())
                .flat_map(|y| (0..picture.width()).map(move |x| (x, y)))
                .filter(|&(x, y)| picture.pixel(x, y) == Some(colour));
            assert!(pixels.count() > 100, "{colour:?}");
        }
    }

    #[test]
    fn axes_hold_all_values_even_if_there_is_one_or_none() {
        assert_eq!(bounds([].into_iter()), (0.0, 1.0));
        let (low, high) = bounds([100.0].into_iter());
        assert!(low < 100.0 && high > 100.0);
    }
}
