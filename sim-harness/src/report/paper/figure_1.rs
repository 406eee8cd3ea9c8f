//! Figure 1: the possible places of the object of a reading.

use amiro_ipf::model::Photometry;

use super::one_sensor::arc_mm;
use super::page_section::{PageSection, PageTable, Panel};
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::picture::Colour;

/// Name of the figure and of its files.
const NAME: &str = "figure-1";

/// Width of a plot, pixels: two charts lie side by side on the page.
const PLOT_PX: usize = 480;

/// Counts of an object 100 mm ahead.
const COUNTS: f32 = 78.0;

const ARC: Colour = [20, 110, 245];
const CONTOUR: Colour = [240, 150, 40];
const OBJECT: Colour = [225, 30, 30];
const SENSOR: Colour = [40, 40, 40];

const CAPTION: &str = "From the sensor model, nothing random in it. A reading says how much \
light comes back, not from where: the object may lie anywhere on the arc x(s, theta). The \
standard error contour is the arc and one standard deviation of the sensor's noise to both \
sides; it is narrow near the sensor and wide at its range limit of 200 mm, where the paper \
draws it. The paper's formula for the deviation is misprinted in two places; this is the \
corrected one.";

/// Draws the figure.
pub(super) fn draw() -> PageSection {
    let law = Photometry::VCNL4020;
    let limit = law.threshold_counts();
    let near = format!("{COUNTS:.0} counts: an object at 100 mm");
    let far = format!("{limit:.1} counts: full range, 200 mm");
    let panels = vec![
        panel(COUNTS, "78-counts", &near, 100.0),
        panel(limit, "full-range", &far, 200.0),
    ];
    PageSection {
        name: NAME,
        title: "Figure 1: standard error contour of a reading",
        caption: CAPTION,
        rows: vec![panels.into()],
        tables: vec![table(&law)],
        excerpt: None,
    }
}

fn table(law: &Photometry) -> PageTable {
    let ranges_mm = [20_u8, 50, 80, 100, 120, 150, 200].into_iter();
    let rows = ranges_mm.filter_map(|range_mm| {
        let counts = law.counts(1e-3 * f32::from(range_mm), 0.0)?;
        let echo = law.range_estimate(counts)?;
        Some(vec![
            format!("{range_mm}"),
            format!("{counts:.1}"),
            format!("{:.2}", 1e3 * echo.sigma_m),
            format!("{:.1}", 100.0 * echo.sigma_m / echo.range_m),
        ])
    });
    PageTable {
        caption: "On the sensor's axis.",
        head: vec![
            "range, mm",
            "counts",
            "deviation, mm",
            "deviation, % of range",
        ],
        rows: rows.collect(),
    }
}

fn panel(counts: f32, part: &str, title: &str, object_mm: f64) -> Panel {
    let arc = |deviations| Mark::Line(arc_mm(counts, deviations), 2.0);
    let x = Axis::linear("ahead of the sensor, mm", -0.1 * object_mm, 1.2 * object_mm);
    let y = Axis::linear("to its left, mm", -0.65 * object_mm, 0.65 * object_mm);
    let sensor = Mark::Dots(vec![(0.0, 0.0)], 10.0);
    let object = Mark::Crosses(vec![(object_mm, 0.0)]);
    let chart = Chart::plane(title, x, y, PLOT_PX)
        .with("x + sigma, x - sigma", CONTOUR, vec![arc(1.0), arc(-1.0)])
        .with("arc x", ARC, vec![arc(0.0)])
        .with("sensor", SENSOR, vec![sensor])
        .with("object", OBJECT, vec![object]);
    let alternative = format!("Error contour in the sensor's frame, {title}");
    Panel::new(NAME, part, alternative, chart.render())
}
