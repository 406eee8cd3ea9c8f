//! Figure 4: two steps of the filter, every particle drawn.

use amiro_ipf::filter::Profile;

use super::one_sensor::{self, arc_mm};
use super::page_section::{PageSection, Panel};
use super::two_steps::{self, Cloud, OBJECT_M, PARTICLES, RecordedStep};
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::picture::Colour;

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
pub(super) fn draw(seed: u64) -> PageSection {
    let steps = two_steps::take(Profile::Paper, seed);
    let mut weighed = Vec::new();
    let mut redrawn = Vec::new();
    for (time, step) in steps.iter().enumerate() {
        if time == 0 {
            let note = format!("{} particles drawn", step.drawn.len());
            let drawn = [("drawn", DRAWN, &step.drawn)];
            weighed.push(panel(step, "t0-drawn", "t = 0: drawn", note, &drawn));
            continue;
        }
        let survived = ("survived", SURVIVED, &step.survived);
        let percent = 100.0 * step.survived.len() as f64 / PARTICLES as f64;
        let (part, title) = (format!("t{time}-weighed"), format!("t = {time}: weighed"));
        let note = format!("{percent:.0} % of {PARTICLES} particles survive");
        let clouds = [("rejected", REJECTED, &step.rejected), survived];
        weighed.push(panel(step, &part, &title, note, &clouds));
        let (part, title) = (format!("t{time}-drawn"), format!("t = {time}: drawn anew"));
        let note = format!("{} particles drawn anew", step.drawn.len());
        let clouds = [survived, ("drawn now", DRAWN, &step.drawn)];
        redrawn.push(panel(step, &part, &title, note, &clouds));
    }
    PageSection {
        name: NAME,
        title: "Figure 4: two steps of the filter",
        caption: CAPTION,
        rows: vec![weighed.into(), redrawn.into()],
        tables: Vec::new(),
        excerpt: None,
    }
}

fn panel(
    step: &RecordedStep,
    part: &str,
    title: &str,
    note: String,
    clouds: &[(&str, Colour, &Cloud)],
) -> Panel {
    let object_m = OBJECT_M - step.travelled_m;
    let counts = one_sensor::counts_at(object_m) as f32;
    let contour = [1.0, -1.0].map(|deviations| Mark::Line(arc_mm(counts, deviations), 1.0));
    let x = Axis::linear("ahead of the sensor, mm", 0.0, 120.0);
    let y = Axis::linear("to its left, mm", -80.0, 80.0);
    let mut chart = Chart::plane(title, x, y, PLOT_PX);
    for (name, colour, cloud) in clouds {
        chart = chart.with(name, *colour, vec![Mark::Dots(cloud.to_vec(), DOT_PX)]);
    }
    let object = Mark::Crosses(vec![(1e3 * f64::from(object_m), 0.0)]);
    let chart = chart
        .with("", CONTOUR, contour.into())
        .with("object", OBJECT, vec![object]);
    let alternative = format!("Particles in the sensor's frame, {title}");
    Panel {
        note,
        ..Panel::new(NAME, part, alternative, chart.render())
    }
}
