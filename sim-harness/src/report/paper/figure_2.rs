//! Figure 2: the inverse sensor model of one reading.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Event;

use super::one_sensor;
use super::page_section::{PageSection, Panel};
use crate::drive::FilterRecords;
use crate::mapping::{Belief, InverseSensorMapper, InverseSensorParameters, Map, Mapper};
use crate::report::chart::{Axis, Chart, Mark};
use crate::rig::Rig;

/// Name of the figure and of its files.
const NAME: &str = "figure-2";

/// Distance of the object, metres.
const OBJECT_M: f32 = 0.05;

/// Cells of the cone and of the line along its axis, metres.
const FINE_M: f64 = 0.002;
const COARSE_M: f64 = 0.01;

/// Probabilities that are drawn white and black.
const WHITE_AT: f64 = 0.3;
const BLACK_AT: f64 = 0.7;

const CAPTION: &str = "From the inverse sensor model, one reading of an object at 50 mm, \
nothing random in it. Left the occupancy probability over the sensor's plane, from white \
(0.3) over grey (0.5, unknown) to black (0.7): the whole arc is called occupied, though \
the object fills only some of it. Right the probability along the sensor's axis with the \
map's 10 mm cells, where the arc is two cells thick. Before the arc free, behind it unknown.";

/// Draws the figure.
pub(super) fn draw() -> PageSection {
    let panel = |part: &str, alternative: &str, chart: &Chart| {
        Panel::new(NAME, part, alternative.to_owned(), chart.render())
    };
    let panels = vec![
        panel("a", "Occupancy in the sensor's plane", &plane()),
        panel("b", "Occupancy along the sensor's axis", &axis()),
    ];
    PageSection {
        name: NAME,
        title: "Figure 2: the inverse sensor model",
        caption: CAPTION,
        rows: vec![panels.into()],
        tables: Vec::new(),
        excerpt: None,
    }
}

fn plane() -> Chart {
    let cone = map(InverseSensorParameters::STANDARD, FINE_M);
    let x = Axis::linear("ahead of the sensor, mm", 0.0, 80.0);
    let y = Axis::linear("to its left, mm", -45.0, 45.0);
    Chart::plane("(a) Occupancy in the plane, ISM standard", x, y, 420).shaded(|x, y| {
        let darkness = (at(&cone, x, y) - WHITE_AT) / (BLACK_AT - WHITE_AT);
        [(255.0 * (1.0 - darkness.clamp(0.0, 1.0))).round() as u8; 3]
    })
}

fn axis() -> Chart {
    let line = |parameters| {
        let coarse = map(parameters, COARSE_M);
        let points = (0_u16..1200).map(|tenths| {
            let x = 0.1 * f64::from(tenths) + 0.05;
            (x, at(&coarse, x, 0.5))
        });
        vec![Mark::Line(points.collect(), 3.0)]
    };
    let standard = line(InverseSensorParameters::STANDARD);
    let tuned = line(InverseSensorParameters::TUNED);
    let x = Axis::linear("ahead of the sensor, mm", 0.0, 120.0);
    let y = Axis::linear("probability of occupied", 0.0, 1.0);
    Chart::new("(b) Occupancy along the axis", x, y, (480, 340))
        .with("ISM standard", [150, 150, 150], standard)
        .with("ISM tuned", [30, 30, 30], tuned)
}

fn map(parameters: InverseSensorParameters, cell_m: f64) -> Map {
    let config = one_sensor::config(Profile::Paper);
    let mut mapper = InverseSensorMapper::new(cell_m, &Rig::from(&config), parameters);
    let step = one_sensor::step(0, 0.0, one_sensor::counts_at(OBJECT_M));
    let mut records = FilterRecords::new(&config);
    records.translate(&Event::StepBegun(step), &mut |record| mapper.take(record));
    mapper.map()
}

/// The probability at a point in millimetres.
fn at(map: &Map, x_mm: f64, y_mm: f64) -> f64 {
    let cell = map.cell_at(1e-3 * x_mm, 1e-3 * y_mm);
    let belief = cell.and_then(|cell| map.get(cell));
    f64::from(belief.unwrap_or(&Belief::UNKNOWN).p_occ())
}
