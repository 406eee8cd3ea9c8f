//! Figure 1: where the object may be that a reading tells of.

use amiro_ipf::model::Photometry;

use crate::figures::chart::{Axis, Chart, Layer, Mark};
use crate::figures::picture::Colour;

use super::FigureError;
use super::arc::arc_mm;
use super::plate::{Panel, Plate, Row, Table};

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
pub(super) fn draw() -> Result<Plate, FigureError> {
    let law = Photometry::VCNL4020;
    let limit = law.threshold_counts();
    let near = format!("{COUNTS:.0} counts: an object at 100 mm");
    let far = format!("{limit:.1} counts: full range, 200 mm");
    let mut table = Table::new(
        "On the sensor's axis.",
        &[
            "range, mm",
            "counts",
            "deviation, mm",
            "deviation, % of range",
        ],
    );
    for range_mm in [20_u8, 50, 80, 100, 120, 150, 200] {
        let counts = law.counts(1e-3 * f32::from(range_mm), 0.0);
        let echo = counts.and_then(|counts| Some((counts, law.range_estimate(counts)?)));
        table.rows.extend(echo.map(|(counts, echo)| {
            vec![
                format!("{range_mm}"),
                format!("{counts:.1}"),
                format!("{:.2}", 1e3 * echo.sigma_m),
                format!("{:.1}", 100.0 * echo.sigma_m / echo.range_m),
            ]
        }));
    }
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Figure 1: standard error contour of a reading".to_owned(),
        caption: CAPTION.to_owned(),
        rows: vec![Row {
            heading: String::new(),
            panels: vec![
                panel(&law, COUNTS, "78-counts", &near, 100.0),
                panel(&law, limit, "full-range", &far, 200.0),
            ],
        }],
        tables: vec![table],
        excerpt: None,
    })
}

fn panel(law: &Photometry, counts: f32, file: &str, title: &str, object_mm: f64) -> Panel {
    let arc = |deviations| Mark::Line(arc_mm(law, counts, deviations), 2.0);
    let reach_mm = 1.2 * object_mm;
    let chart = Chart::plane(
        title,
        Axis::linear("ahead of the sensor, mm", -0.1 * object_mm, reach_mm),
        Axis::linear("to its left, mm", -0.65 * object_mm, 0.65 * object_mm),
        PLOT_PX,
    )
    .with(Layer::new(
        "x + sigma, x - sigma",
        CONTOUR,
        vec![arc(1.0), arc(-1.0)],
    ))
    .with(Layer::new("arc x", ARC, vec![arc(0.0)]))
    .with(Layer::new(
        "sensor",
        SENSOR,
        vec![Mark::Dots(vec![(0.0, 0.0)], 10.0)],
    ))
    .with(Layer::new(
        "object",
        OBJECT,
        vec![Mark::Crosses(vec![(object_mm, 0.0)])],
    ));
    Panel {
        file: format!("{NAME}-{file}.png"),
        alternative: format!("Error contour in the sensor's frame, {title}"),
        note: String::new(),
        picture: chart.render(),
    }
}
