//! What is drawn into a chart: lines, dots, crosses, bars and their spread.

use crate::figures::picture::{Colour, Picture};
use crate::figures::stroke::{Place, Stroke};

/// Arm of a cross and half of a whisker's end, pixels.
const ARM_PX: f64 = 5.0;

/// Width of thin lines, pixels.
const THIN_PX: f64 = 2.0;

/// Colour of whiskers over bars.
const WHISKER: Colour = [40, 40, 40];

/// Everything of one colour and one name in the legend.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    /// What the legend says; none leaves it out of the legend.
    pub(crate) name: Option<String>,
    /// The colour of all marks.
    pub(crate) colour: Colour,
    /// What is drawn, in this order.
    pub(crate) marks: Vec<Mark>,
}

/// Something drawn, in the units of the axes.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// A line through points, of a width in pixels.
    Line(Vec<(f64, f64)>, f64),
    /// Round dots of a diameter in pixels.
    Dots(Vec<(f64, f64)>, f64),
    /// Diagonal crosses.
    Crosses(Vec<(f64, f64)>),
    /// Bars from the low end upward.
    Bars(Vec<Bar>),
    /// Vertical lines from one value to another, with ends: (at, from, to).
    Whiskers(Vec<(f64, f64, f64)>),
}

/// A bar with its spread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bar {
    /// Its middle on the horizontal axis.
    pub(crate) at: f64,
    /// Its width on the horizontal axis.
    pub(crate) width: f64,
    /// How high it is.
    pub(crate) height: f64,
    /// What the whisker adds above and takes away below.
    pub(crate) spread: f64,
}

impl Layer {
    /// A layer with a name in the legend.
    pub(crate) fn new(name: &str, colour: Colour, marks: Vec<Mark>) -> Self {
        Self {
            name: Some(name.to_owned()),
            colour,
            marks,
        }
    }

    /// Draws everything into a plot; what lies outside is cut.
    pub(crate) fn draw(&self, plot: &mut Picture, place: impl Fn((f64, f64)) -> Place) {
        let (width, height) = (plot.width(), plot.height());
        let mut stroke = Stroke::new(width, height);
        let mut whiskers = Stroke::new(width, height);
        for mark in &self.marks {
            match mark {
                Mark::Line(points, pen_px) => {
                    stroke.line(points.iter().map(|point| place(*point)), *pen_px);
                }
                Mark::Dots(points, size_px) => {
                    for point in points {
                        stroke.line([place(*point)], *size_px);
                    }
                }
                Mark::Crosses(points) => {
                    for (x, y) in points.iter().map(|point| place(*point)) {
                        let arms = [(ARM_PX, ARM_PX), (ARM_PX, -ARM_PX)];
                        for (along, down) in arms {
                            stroke.line([(x - along, y - down), (x + along, y + down)], THIN_PX);
                        }
                    }
                }
                Mark::Bars(bars) => {
                    for bar in bars {
                        self.fill(plot, bar, &place);
                        let (from, to) = (bar.height - bar.spread, bar.height + bar.spread);
                        whisker(&mut whiskers, place((bar.at, from)), place((bar.at, to)));
                    }
                }
                Mark::Whiskers(spreads) => {
                    for &(at, from, to) in spreads {
                        whisker(&mut stroke, place((at, from)), place((at, to)));
                    }
                }
            }
        }
        stroke.blend(plot, 0, 0, self.colour);
        whiskers.blend(plot, 0, 0, WHISKER);
    }

    fn fill(&self, plot: &mut Picture, bar: &Bar, place: &impl Fn((f64, f64)) -> Place) {
        let (left, top) = place((bar.at - 0.5 * bar.width, bar.height));
        let (right, _) = place((bar.at + 0.5 * bar.width, bar.height));
        // The casts saturate: what lies outside is cut.
        let (left, top) = (left.round() as usize, top.round() as usize);
        let width = (right.round() as usize).saturating_sub(left);
        let height = plot.height().saturating_sub(top);
        plot.fill(left, top, (width, height), self.colour);
    }
}

/// A line with a short bar at both ends.
fn whisker(stroke: &mut Stroke, from: Place, to: Place) {
    stroke.line([from, to], THIN_PX);
    for (x, y) in [from, to] {
        stroke.line([(x - ARM_PX, y), (x + ARM_PX, y)], THIN_PX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_high_as_its_value_and_its_whisker_higher() {
        let mut plot = Picture::new(100, 100, [255; 3]);
        let bar = Bar {
            at: 50.0,
            width: 20.0,
            height: 40.0,
            spread: 10.0,
        };
        let layer = Layer::new("bar", [0, 0, 255], vec![Mark::Bars(vec![bar])]);
        layer.draw(&mut plot, |(x, y)| (x, 100.0 - y));
        assert_eq!(plot.pixel(42, 60), Some([0, 0, 255]));
        assert_eq!(plot.pixel(42, 99), Some([0, 0, 255]));
        assert_eq!(plot.pixel(42, 58), Some([255; 3]));
        assert_eq!(plot.pixel(38, 80), Some([255; 3]));
        assert_eq!(plot.pixel(50, 55), Some(WHISKER));
        assert_eq!(plot.pixel(50, 47), Some([255; 3]));
    }
}
