//! The marks of a chart: lines, dots, crosses, bars and whiskers.

use crate::report::line_drawing::{LineDrawing, PixelPosition};
use crate::report::picture::{Colour, Picture};

/// Arm of a cross and half of a whisker's end, pixels.
const ARM_PX: f64 = 5.0;

/// Width of thin lines, pixels.
const THIN_PX: f64 = 2.0;

/// A point in the units of the axes: x and y.
type ChartPoint = (f64, f64);

/// Marks of one colour.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Name in the legend; an empty name has no entry there.
    pub(super) name: String,
    /// Colour of all marks.
    pub(super) colour: Colour,
    /// The marks, drawn in this order.
    pub(super) marks: Vec<Mark>,
}

/// Something drawn, in the units of the axes.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// A line through points, of a width in pixels.
    Line(Vec<ChartPoint>, f64),
    /// Round dots of a diameter in pixels.
    Dots(Vec<ChartPoint>, f64),
    /// Diagonal crosses.
    Crosses(Vec<ChartPoint>),
    /// Bars from the low end of the axis up to a point in the middle of their top, of a
    /// width in units of the horizontal axis.
    Bars(Vec<ChartPoint>, f64),
    /// Vertical lines with ends: position on the horizontal axis, lower and upper end.
    Whiskers(Vec<(f64, f64, f64)>),
}

impl Layer {
    /// Draws all marks into a plot; parts outside the plot are cut.
    pub(super) fn draw(&self, plot: &mut Picture, place: impl Fn(ChartPoint) -> PixelPosition) {
        let mut lines = LineDrawing::new(plot.width(), plot.height());
        for mark in &self.marks {
            match mark {
                Mark::Line(points, pen_px) => {
                    lines.line(points.iter().map(|point| place(*point)), *pen_px);
                }
                Mark::Dots(points, size_px) => {
                    for point in points {
                        lines.line([place(*point)], *size_px);
                    }
                }
                Mark::Crosses(points) => {
                    for (x, y) in points.iter().map(|point| place(*point)) {
                        for down in [ARM_PX, -ARM_PX] {
                            lines.line([(x - ARM_PX, y - down), (x + ARM_PX, y + down)], THIN_PX);
                        }
                    }
                }
                Mark::Bars(tops, width) => {
                    for &(at, height) in tops {
                        let (left, top) = place((at - 0.5 * width, height));
                        let (right, _) = place((at + 0.5 * width, height));
                        self.fill_bar(plot, left, right, top);
                    }
                }
                Mark::Whiskers(whiskers) => {
                    for &(at, low, high) in whiskers {
                        let ends = [place((at, low)), place((at, high))];
                        lines.line(ends, THIN_PX);
                        for (x, y) in ends {
                            lines.line([(x - ARM_PX, y), (x + ARM_PX, y)], THIN_PX);
                        }
                    }
                }
            }
        }
        lines.blend(plot, self.colour);
    }

    fn fill_bar(&self, plot: &mut Picture, left: f64, right: f64, top: f64) {
        // The casts saturate: parts outside the plot are cut.
        let (left, top) = (left.round() as usize, top.round() as usize);
        let width = (right.round() as usize).saturating_sub(left);
        let height = plot.height().saturating_sub(top);
        plot.fill(left, top, (width, height), self.colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_and_whiskers_are_as_high_as_their_values() {
        let mut plot = Picture::new(100, 100, [255; 3]);
        let (blue, grey) = ([0, 0, 255], [40; 3]);
        let bars = Mark::Bars(vec![(50.0, 40.0)], 20.0);
        let whiskers = Mark::Whiskers(vec![(50.0, 30.0, 50.0)]);
        for (colour, mark) in [(blue, bars), (grey, whiskers)] {
            let layer = Layer {
                name: String::new(),
                colour,
                marks: vec![mark],
            };
            layer.draw(&mut plot, |(x, y)| (x, 100.0 - y));
        }
        for (x, y, colour) in [
            (42, 60, blue),
            (42, 99, blue),
            (42, 58, [255; 3]),
            (38, 80, [255; 3]),
            (50, 55, grey),
            (50, 47, [255; 3]),
        ] {
            assert_eq!(plot.pixel(x, y), Some(colour), "{x}, {y}");
        }
    }
}
