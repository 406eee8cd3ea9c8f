//! The particles of a servo scan about the sensor.

use super::chart::{Axis, Chart, Mark};
use super::picture::{Colour, Picture};

/// Width of the plot, pixels.
const WIDTH_PX: usize = 560;

const DOT_PX: f64 = 3.0;
const LOW: Colour = [40, 90, 220];
const UNDETERMINED: Colour = [200, 200, 200];
const HIGH: Colour = [210, 30, 30];
const END: Colour = [20, 20, 20];

/// Places in metres from the sensor.
type Places = Vec<(f64, f64)>;

/// Draws particles by the class of their weight, and the end points of the beams.
///
/// `particles` are those of low, undetermined and high weight; `radius_m` is that of the
/// disc.
#[must_use]
pub fn servo_scan_picture(
    title: &str,
    radius_m: f64,
    particles: [Places; 3],
    ends: Places,
) -> Picture {
    let axis = |label| Axis::linear(label, -radius_m, radius_m);
    let [low, undetermined, high] = particles;
    let dots = |places, size_px| vec![Mark::Dots(places, size_px)];
    Chart::plane(title, axis("x, m"), axis("y, m"), WIDTH_PX)
        .with("undetermined", UNDETERMINED, dots(undetermined, DOT_PX))
        .with("free", LOW, dots(low, DOT_PX))
        .with("obstacle", HIGH, dots(high, DOT_PX + 1.0))
        .with("end of a beam", END, dots(ends, DOT_PX - 1.0))
        .render()
}
