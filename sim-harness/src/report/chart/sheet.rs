//! A chart with its title, legend, axes and plot.

use crate::report::picture::{Colour, PAPER, Picture};
use crate::report::text::{Font, INK};

use super::layer::Layer;
use super::legend::Legend;
use super::{Axis, Mark};

/// White border around everything, pixels.
const BORDER: usize = 10;

/// Length of a tick, pixels.
const TICK_PX: usize = 6;

/// Space between parts of the sheet, pixels.
const GAP_PX: usize = 6;

/// Greatest number of lines of a title.
const TITLE_LINES: usize = 2;

/// Colour of the lines across the plot at the ticks.
const RULES: Colour = [228, 228, 228];

/// A chart.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    title: String,
    x: Axis,
    y: Axis,
    plot: Picture,
    is_shaded: bool,
    layers: Vec<Layer>,
}

impl Chart {
    /// An empty chart whose plot has the given width and height, pixels.
    pub(crate) fn new(title: &str, x: Axis, y: Axis, size: (usize, usize)) -> Self {
        Self {
            title: title.to_owned(),
            x,
            y,
            plot: Picture::new(size.0, size.1, PAPER),
            is_shaded: false,
            layers: Vec::new(),
        }
    }

    /// An empty chart of a plane: both axes have the same scale.
    pub(crate) fn plane(title: &str, x: Axis, y: Axis, width: usize) -> Self {
        let height = (width as f64 * y.span() / x.span()).round() as usize;
        Self::new(title, x, y, (width, height))
    }

    /// The chart with a colour behind each pixel, by its position on the axes.
    #[must_use]
    pub(crate) fn shaded(mut self, colour: impl Fn(f64, f64) -> Colour) -> Self {
        let (width, height) = (self.plot.width(), self.plot.height());
        for row in 0..height {
            let y = self.y.value(height - 1 - row, height);
            for (column, pixel) in self.plot.row_mut(row).iter_mut().enumerate() {
                *pixel = colour(self.x.value(column, width), y);
            }
        }
        self.is_shaded = true;
        self
    }

    /// The chart with more marks of one colour, above the marks that it has.
    ///
    /// The name goes into the legend unless it is empty.
    #[must_use]
    pub(crate) fn with(mut self, name: &str, colour: Colour, marks: Vec<Mark>) -> Self {
        self.layers.push(Layer {
            name: name.to_owned(),
            colour,
            marks,
        });
        self
    }

    /// Draws the chart.
    pub(crate) fn render(&self) -> Picture {
        let font = Font::SMALL;
        let (width, height) = (self.plot.width(), self.plot.height());
        let widest = |axis: &Axis| {
            let widths = axis.ticks().iter().map(|(_, text)| font.width(text));
            widths.max().unwrap_or(0)
        };
        let left = BORDER + widest(&self.y) + TICK_PX + GAP_PX;
        let right = BORDER + widest(&self.x) / 2;
        let across = left + width + right;
        let room = across - 2 * BORDER;
        let title = Font::LARGE.wrapped(&self.title, room, TITLE_LINES);
        let legend = Legend::new(&self.layers, room);
        let legend_y = BORDER + title.len() * Font::LARGE.height() + GAP_PX;
        let label_y = legend_y + legend.height() + GAP_PX;
        let top = label_y + font.height() + GAP_PX;
        let foot = TICK_PX + GAP_PX + 2 * font.height() + GAP_PX + BORDER;
        let mut sheet = Picture::new(across, top + height + foot, PAPER);

        for (index, line) in title.iter().enumerate() {
            let y = BORDER + index * Font::LARGE.height();
            Font::LARGE.draw(&mut sheet, BORDER, y, line, INK);
        }
        legend.draw(&mut sheet, BORDER, legend_y);
        font.draw(&mut sheet, BORDER, label_y, self.y.label(), INK);
        sheet.fill(left - 1, top - 1, (width + 2, height + 2), INK);
        sheet.paste(left, top, &self.plotted());
        self.write_ticks(&mut sheet, left, top);
        let label_x = (left + width).saturating_sub(font.width(self.x.label()));
        let label_y = top + height + TICK_PX + 2 * GAP_PX + font.height();
        let label_x = label_x.max(BORDER);
        font.draw(&mut sheet, label_x, label_y, self.x.label(), INK);
        sheet
    }

    /// The plot with all layers.
    fn plotted(&self) -> Picture {
        let mut plot = self.plot.clone();
        let (width, height) = (plot.width(), plot.height());
        let place = |(x, y): (f64, f64)| {
            let up = self.y.place(y, height);
            (self.x.place(x, width), height as f64 - up)
        };
        if !self.is_shaded {
            for (value, _) in self.y.ticks() {
                let (_, y) = place((0.0, *value));
                plot.fill(0, y.round() as usize, (width, 1), RULES);
            }
        }
        for layer in &self.layers {
            layer.draw(&mut plot, place);
        }
        plot
    }

    fn write_ticks(&self, sheet: &mut Picture, left: usize, top: usize) {
        let font = Font::SMALL;
        let (width, height) = (self.plot.width(), self.plot.height());
        for (value, text) in self.x.ticks() {
            let x = left + self.x.place(*value, width).round() as usize;
            let y = top + height;
            sheet.fill(x, y, (1, TICK_PX), INK);
            let text_x = x.saturating_sub(font.width(text) / 2);
            font.draw(sheet, text_x, y + TICK_PX + GAP_PX, text, INK);
        }
        for (value, text) in self.y.ticks() {
            let y = top + height - self.y.place(*value, height).round() as usize;
            sheet.fill(left - TICK_PX, y, (TICK_PX, 1), INK);
            let text_x = left - TICK_PX - GAP_PX / 2 - font.width(text);
            font.draw(sheet, text_x, y - font.height() / 2, text, INK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_have_one_scale_and_shades_lie_the_right_way_up() {
        let axis = |high| Axis::linear("mm", 0.0, high);
        let chart = Chart::plane("plane", axis(200.0), axis(100.0), 400);
        assert_eq!(chart.plot.height(), 200);
        let chart = chart.shaded(|x, y| [if x > 150.0 && y > 90.0 { 1 } else { 2 }; 3]);
        assert_eq!(chart.plot.pixel(399, 0), Some([1; 3]));
        assert_eq!(chart.plot.pixel(399, 199), Some([2; 3]));
        assert_eq!(chart.plot.pixel(0, 0), Some([2; 3]));
    }

    #[test]
    fn a_chart_has_the_same_pixels_on_every_machine() {
        let line = vec![(0.0, 0.0), (3.0, 20.0), (10.0, 5.0)];
        let x = Axis::linear("range, mm", 0.0, 10.0);
        let y = Axis::linear("error, %", 0.0, 25.0);
        let chart = Chart::new("a chart", x, y, (300, 200)).with(
            "line",
            [200, 30, 30],
            vec![Mark::Line(line, 2.0)],
        );
        assert_eq!(chart.render(), chart.render());
        // Pinned: another checksum is another drawing; look at the figures then.
        assert_eq!(chart.render().checksum(), 2_357_117_633);
    }
}
