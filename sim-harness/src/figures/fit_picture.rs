//! A fit of the photometric law: measured and expected counts, and what is left.

use std::collections::BTreeMap;

use super::chart::{Axis, Chart, Layer, Mark};
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

/// Draws measured (dots) and expected counts (lines) over range, a colour a bearing,
/// and beside them the residuals.
///
/// Bearings are told apart by whole degrees.
#[must_use]
pub fn fit_picture(fit: &Fit) -> Picture {
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
    let range = |low: f64, high: f64| Axis::linear("range, mm", low, high);
    let (near, far) = bounds(all().map(|(range_mm, ..)| range_mm));
    let (least, most) = bounds(all().flat_map(|(_, counts, fit)| [counts, fit]));
    let (below, above) = bounds(all().map(|(_, counts, fit)| counts - fit).chain([0.0]));
    let counts_axis = Axis::linear("counts", least, most);
    let residual_axis = Axis::linear("measured less fitted, counts", below, above);
    let mut counts = Chart::new(
        "Measured, and the fitted law",
        range(near, far),
        counts_axis,
        SIZE_PX,
    );
    let mut residuals = Chart::new("Residuals", range(near, far), residual_axis, SIZE_PX);
    let level = vec![(near, 0.0), (far, 0.0)];
    residuals = residuals.with(Layer {
        name: None,
        colour: [120, 120, 120],
        marks: vec![Mark::Line(level, 1.0)],
    });
    for ((degrees, rows), colour) in bearings.iter().zip(COLOURS.into_iter().cycle()) {
        let name = format!("{degrees} degrees");
        let dots = rows.iter().map(|&(x, counts, _)| (x, counts)).collect();
        let line = rows.iter().map(|&(x, _, fit)| (x, fit)).collect();
        let left = rows
            .iter()
            .map(|&(x, counts, fit)| (x, counts - fit))
            .collect();
        let marks = vec![Mark::Line(line, LINE_PX), Mark::Dots(dots, DOT_PX)];
        counts = counts.with(Layer::new(&name, colour, marks));
        residuals = residuals.with(Layer::new(&name, colour, vec![Mark::Dots(left, DOT_PX)]));
    }
    beside(&[counts.render(), residuals.render()])
}

/// The ends of an axis that holds all values, with a tenth of room on both sides.
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
        let picture = fit_picture(&fit);
        assert_eq!(bytes(&picture), bytes(&fit_picture(&fit)));
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
