//! Figure 4: two steps of the filter, every particle drawn.

use amiro_ipf::filter::Profile;
use amiro_ipf::model::Photometry;

use crate::figures::chart::{Axis, Chart, Layer, Mark};
use crate::figures::picture::Colour;

use super::FigureError;
use super::arc::arc_mm;
use super::one_sensor;
use super::plate::{Panel, Plate, Row};
use super::two_steps::{self, Cloud, OBJECT_M, PARTICLES, Step};

/// Name of the figure and of its files.
const NAME: &str = "figure-4";

/// Width of a plot, pixels: three charts lie side by side on the page.
const PLOT_PX: usize = 320;

/// Diameter of a particle, pixels.
const DOT_PX: f64 = 3.0;

/// Particles that the step drew.
const DRAWN: Colour = [20, 110, 245];
/// Particles that survived.
pub(super) const SURVIVED: Colour = [20, 20, 20];
/// Particles that were rejected.
pub(super) const REJECTED: Colour = [245, 150, 40];
const CONTOUR: Colour = [150, 150, 150];
const OBJECT: Colour = [225, 30, 30];

const CAPTION: &str = "Simulated, one seed, profile paper, no noise on the readings. A single \
sensor at the origin sees an object 100 mm ahead (red cross) and drives towards it, 10 mm a \
step. At t = 0 all particles are drawn along the arc of the reading. After a step of the \
robot all particles have moved towards it; those that no longer fit the new reading are \
rejected and drawn anew along its arc, and the others survive. The paper reports that 80 % \
survive the first step. The grey lines are the \
reading's standard error contour; particles survive beyond it too, since the weight allows \
for 8 mm of model error.";

/// Draws the figure.
pub(super) fn draw(seed: u64) -> Result<Plate, FigureError> {
    let steps = two_steps::take(Profile::Paper, seed);
    let mut weighed = Vec::new();
    let mut redrawn = Vec::new();
    for (time, step) in steps.iter().enumerate() {
        let drawn = [
            ("survived", SURVIVED, &step.survived),
            ("drawn now", DRAWN, &step.drawn),
        ];
        if time == 0 {
            let note = format!("{} particles drawn", step.drawn.len());
            let drawn = [("drawn", DRAWN, &step.drawn)];
            weighed.push(panel(step, "t0-drawn", "t = 0: drawn", note, &drawn));
            continue;
        }
        let outcomes = [
            ("rejected", REJECTED, &step.rejected),
            ("survived", SURVIVED, &step.survived),
        ];
        let percent = 100.0 * step.survived.len() as f64 / PARTICLES as f64;
        let note = format!("{percent:.0} % of {PARTICLES} particles survive");
        let (file, title) = (format!("t{time}-weighed"), format!("t = {time}: weighed"));
        weighed.push(panel(step, &file, &title, note, &outcomes));
        let (file, title) = (format!("t{time}-drawn"), format!("t = {time}: drawn anew"));
        let note = format!("{} particles drawn anew", step.drawn.len());
        redrawn.push(panel(step, &file, &title, note, &drawn));
    }
    let row = |panels| Row {
        heading: String::new(),
        panels,
    };
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Figure 4: two steps of the filter".to_owned(),
        caption: CAPTION.to_owned(),
        rows: vec![row(weighed), row(redrawn)],
        tables: Vec::new(),
        excerpt: None,
    })
}

fn panel(
    step: &Step,
    file: &str,
    title: &str,
    note: String,
    clouds: &[(&str, Colour, &Cloud)],
) -> Panel {
    let object_m = OBJECT_M - step.travelled_m;
    let law = Photometry::VCNL4020;
    let counts = one_sensor::counts_at(object_m) as f32;
    let contour = |deviations| Mark::Line(arc_mm(&law, counts, deviations), 1.0);
    let mut chart = Chart::plane(
        title,
        Axis::linear("ahead of the sensor, mm", 0.0, 120.0),
        Axis::linear("to its left, mm", -80.0, 80.0),
        PLOT_PX,
    );
    for (name, colour, cloud) in clouds {
        let dots = vec![Mark::Dots(cloud.to_vec(), DOT_PX)];
        chart = chart.with(Layer::new(name, *colour, dots));
    }
    let object = vec![Mark::Crosses(vec![(1e3 * f64::from(object_m), 0.0)])];
    let chart = chart
        .with(Layer {
            name: None,
            colour: CONTOUR,
            marks: vec![contour(1.0), contour(-1.0)],
        })
        .with(Layer::new("object", OBJECT, object));
    Panel {
        file: format!("{NAME}-{file}.png"),
        alternative: format!("Particles in the sensor's frame, {title}"),
        note,
        picture: chart.render(),
    }
}
