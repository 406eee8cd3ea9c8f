//! Receiver operating characteristics of several maps in one chart.

use super::chart::{Axis, Chart, Mark};
use super::picture::{Colour, Picture};

const SIZE_PX: usize = 460;
const LINE_PX: f64 = 2.0;

/// Told apart by people who see few colours, and by their lightness; curves get them in turn.
const COLOURS: [Colour; 8] = [
    [0, 0, 0],
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [150, 150, 150],
];

/// A name and its points: false positive rate, true positive rate.
pub type RocCurve = (String, Vec<(f64, f64)>);

/// Draws the curves; the thin diagonal is chance.
#[must_use]
pub fn roc_chart(title: &str, curves: &[RocCurve]) -> Picture {
    let x = Axis::linear("false positive rate", 0.0, 1.0);
    let y = Axis::linear("true positive rate", 0.0, 1.0);
    let chance = Mark::Line(vec![(0.0, 0.0), (1.0, 1.0)], 1.0);
    let chart = Chart::plane(title, x, y, SIZE_PX).with("", [120, 120, 120], vec![chance]);
    let curves = curves.iter().zip(COLOURS.into_iter().cycle());
    let chart = curves.fold(chart, |chart, ((name, points), colour)| {
        chart.with(name, colour, vec![Mark::Line(points.clone(), LINE_PX)])
    });
    chart.render()
}
