//! Figure 5: the particles of two steps counted into a map, and the map of the inverse
//! sensor model.

use amiro_ipf::filter::Profile;

use super::figure_4::{REJECTED, SURVIVED};
use super::one_sensor;
use super::page_section::{PageSection, Panel};
use super::two_steps::{self, Cloud, RecordedStep};
use crate::drive::FilterRecords;
use crate::lattice::Cell;
use crate::mapping::{CountingMapper, InverseSensorMapper, InverseSensorParameters, Map, Mapper};
use crate::report::cell_window::CellWindow;
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::map_picture::MapPicture;
use crate::report::picture::Picture;
use crate::rig::Rig;

/// Name of the figure and of its files.
const NAME: &str = "figure-5";

/// Side of a cell, metres.
const CELL_M: f64 = 0.01;

/// Longer side of a map, pixels.
const SIDE_PX: usize = 330;

/// The object: a block whose front is 100 mm ahead of the sensor at the start.
const BLOCK_M: [(f64, f64); 4] = [(0.1, -0.025), (0.13, -0.025), (0.13, 0.025), (0.1, 0.025)];

const CAPTION: &str = "Simulated, one seed; the two steps of figure 4, in the frame of the \
sensor at t = 0. (a) Where particles survived and were rejected. (b) The map that counts \
them: a particle that has survived both steps (gate g = 2) counts as occupied, a rejected \
one as free. (c) The map of the inverse sensor model from the same three readings. In (b) \
two steps are enough to free the arc's ends, which the inverse sensor model still calls \
occupied; it in turn frees the space before the arc, of which no particle has told yet. The red block is drawn for its place; the readings are those of the sensor model \
for an object of that distance. plus (our addition) counts a rejected particle only where \
a sensor sees past it, and has not freed the ends yet.";

/// Draws the figure.
pub(super) fn draw(seed: u64) -> PageSection {
    let paper = two_steps::take(Profile::Paper, seed);
    let plus = two_steps::take(Profile::Plus, seed);
    let particles = vec![
        scatter(&paper, "a", "(a) paper: particles"),
        scatter(&plus, "a-plus", "plus: particles"),
    ];
    let ism = inverse_sensor_map(&paper);
    let maps = [
        ("b", "(b) paper, g = 2", counted(&paper)),
        ("b-plus", "plus, g = 2", counted(&plus)),
        ("c", "(c) ISM standard", ism),
    ];
    let maps = maps.map(|(part, title, map)| {
        let alternative = format!("Map after two steps: {title}");
        Panel::new(NAME, part, alternative, picture(title, &map, &paper))
    });
    PageSection {
        name: NAME,
        title: "Figure 5: from particles to a map",
        caption: CAPTION,
        rows: vec![particles.into(), Vec::from(maps).into()],
        tables: Vec::new(),
        excerpt: None,
    }
}

/// Both steps' particles at their positions in the world.
fn scatter(steps: &[RecordedStep], part: &str, title: &str) -> Panel {
    let in_world = |of: fn(&RecordedStep) -> &Cloud| {
        let moved = |step: &RecordedStep| {
            let travelled_mm = 1e3 * f64::from(step.travelled_m);
            let points = of(step).iter();
            points
                .map(|(x, y)| (x + travelled_mm, *y))
                .collect::<Vec<_>>()
        };
        vec![Mark::Dots(steps.iter().flat_map(moved).collect(), 3.0)]
    };
    let x = Axis::linear("ahead of the first place, mm", 0.0, 140.0);
    let y = Axis::linear("to its left, mm", -100.0, 100.0);
    let chart = Chart::plane(title, x, y, 320)
        .with("survived", SURVIVED, in_world(|step| &step.survived))
        .with("rejected", REJECTED, in_world(|step| &step.rejected));
    let alternative = format!("Survived and rejected particles of two steps, {title}");
    Panel::new(NAME, part, alternative, chart.render())
}

fn counted(steps: &[RecordedStep]) -> Map {
    mapped(CountingMapper::new(CELL_M), steps)
}

fn mapped(mut mapper: impl Mapper, steps: &[RecordedStep]) -> Map {
    let config = one_sensor::config(Profile::Paper);
    let mut records = FilterRecords::new(&config);
    for event in steps.iter().flat_map(RecordedStep::events) {
        records.translate(&event, &mut |record| mapper.take(record));
    }
    mapper.map()
}

fn inverse_sensor_map(steps: &[RecordedStep]) -> Map {
    let config = one_sensor::config(Profile::Paper);
    let parameters = InverseSensorParameters::STANDARD;
    let mapper = InverseSensorMapper::new(CELL_M, &Rig::from(&config), parameters);
    mapped(mapper, steps)
}

fn picture(title: &str, map: &Map, steps: &[RecordedStep]) -> Picture {
    let positions = steps.iter().map(|step| step.begun.pose.position);
    let path: Vec<_> = positions
        .map(|at| (f64::from(at.x), f64::from(at.y)))
        .collect();
    // The same for all maps: -110 to 140 mm ahead, 110 mm to both sides.
    let corner = |column, row| CellWindow::of(Cell { row, column });
    MapPicture {
        title: Some(title),
        path: &path,
        final_heading_rad: Some(0.0),
        outlines: &[BLOCK_M.to_vec()],
        window: Some(corner(-6, -10).joined(corner(13, 9))),
        ..MapPicture::default()
    }
    .render_sized(map, SIDE_PX)
}
