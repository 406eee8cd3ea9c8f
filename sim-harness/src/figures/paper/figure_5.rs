//! Figure 5: the particles of two steps sorted into a map, and the usual map beside it.

use amiro_ipf::filter::Profile;

use crate::drive::FilterRecords;
use crate::figures::chart::{Axis, Chart, Layer, Mark};
use crate::figures::map_picture::MapPicture;
use crate::figures::window::Window;
use crate::lattice::Cell;
use crate::mapping::{CountingMapper, InverseSensorMapper, InverseSensorParameters, Map, Mapper};
use crate::rig::Rig;

use super::FigureError;
use super::figure_4::{REJECTED, SURVIVED};
use super::one_sensor;
use super::plate::{Panel, Plate, Row};
use super::two_steps::{self, Step};

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
pub(super) fn draw(seed: u64) -> Result<Plate, FigureError> {
    let paper = two_steps::take(Profile::Paper, seed);
    let plus = two_steps::take(Profile::Plus, seed);
    let ism = inverse_sensor_map(&paper);
    let maps = [
        ("b", "(b) paper, g = 2", counted(&paper)),
        ("b-plus", "plus, g = 2", counted(&plus)),
        ("c", "(c) ISM standard", ism),
    ];
    let scatters = vec![
        scatter(&paper, "a", "(a) paper: particles"),
        scatter(&plus, "a-plus", "plus: particles"),
    ];
    let maps = maps.map(|(letter, title, map)| Panel {
        file: format!("{NAME}-{letter}.png"),
        alternative: format!("Map after two steps: {title}"),
        note: String::new(),
        picture: picture(title, &map, &paper),
    });
    let row = |panels| Row {
        heading: String::new(),
        panels,
    };
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Figure 5: from particles to a map".to_owned(),
        caption: CAPTION.to_owned(),
        rows: vec![row(scatters), row(maps.into())],
        tables: Vec::new(),
        excerpt: None,
    })
}

/// Both steps' particles where they were in the world.
fn scatter(steps: &[Step], letter: &str, title: &str) -> Panel {
    let in_world = |of: fn(&Step) -> &two_steps::Cloud| {
        let moved = |step: &Step| {
            let travelled_mm = 1e3 * f64::from(step.travelled_m);
            let places = of(step).iter();
            places
                .map(|(x, y)| (x + travelled_mm, *y))
                .collect::<Vec<_>>()
        };
        vec![Mark::Dots(steps.iter().flat_map(moved).collect(), 3.0)]
    };
    let survived = in_world(|step| &step.survived);
    let rejected = in_world(|step| &step.rejected);
    let chart = Chart::plane(
        title,
        Axis::linear("ahead of the first place, mm", 0.0, 140.0),
        Axis::linear("to its left, mm", -100.0, 100.0),
        320,
    )
    .with(Layer::new("survived", SURVIVED, survived))
    .with(Layer::new("rejected", REJECTED, rejected));
    Panel {
        file: format!("{NAME}-{letter}.png"),
        alternative: format!("Survived and rejected particles of two steps, {title}"),
        note: String::new(),
        picture: chart.render(),
    }
}

fn counted(steps: &[Step]) -> Map {
    mapped(CountingMapper::new(CELL_M), steps)
}

fn mapped(mut mapper: impl Mapper, steps: &[Step]) -> Map {
    let config = one_sensor::config(Profile::Paper);
    let mut records = FilterRecords::new(config.photometry);
    for event in steps.iter().flat_map(Step::events) {
        records.translate(&event, &mut |record| mapper.take(record));
    }
    mapper.map()
}

fn inverse_sensor_map(steps: &[Step]) -> Map {
    let config = one_sensor::config(Profile::Paper);
    let parameters = InverseSensorParameters::STANDARD;
    let mapper = InverseSensorMapper::new(CELL_M, &Rig::from(&config), parameters);
    mapped(mapper, steps)
}

fn picture(title: &str, map: &Map, steps: &[Step]) -> crate::figures::Picture {
    let place = |step: &Step| {
        let position = step.begun.pose.position;
        (f64::from(position.x), f64::from(position.y))
    };
    let path: Vec<_> = steps.iter().map(place).collect();
    // The same for all maps: -110 to 140 mm ahead, 110 mm to both sides.
    let corner = |column, row| Window::of(Cell { row, column });
    let window = corner(-6, -10).joined(corner(13, 9));
    MapPicture {
        robot_radius_m: None,
        title: Some(title),
        path: &path,
        jumps: &[],
        final_heading_rad: Some(0.0),
        outlines: &[BLOCK_M.to_vec()],
        window: Some(window),
    }
    .render_sized(map, SIDE_PX)
}
