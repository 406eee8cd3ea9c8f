//! Figure 9: maps of the five scenarios, and of the T junction half way.

use crate::evaluation::{Scores, Truth};
use crate::figures::map_picture::MapPicture;
use crate::figures::picture::{Picture, beside};
use crate::figures::window::Window;
use crate::geometry::Pose2;
use crate::mapping::{Map, Method, Occupancy};
use crate::world::{Scenario, Vector};

use super::FigureError;
use super::course::{Conditions, Course};
use super::percent::{percent, share};
use super::plate::{Panel, Plate, Row};

/// Name of the figure and of its files.
const NAME: &str = "figure-9";

/// Name of the file with the T junction alone.
const EXCERPT: &str = "t_junction.png";

/// Longer side of a map, pixels: three lie side by side on the page.
const SIDE_PX: usize = 370;

/// Distance between points on an outline, metres.
const OUTLINE_M: f64 = 0.002;

/// A map that is asked for: its letter, what stands above it, and how it is made.
type Wanted = (&'static str, &'static str, Method);

const OBJECT: Method = Method::ISM_STANDARD_OBJECT;
const DROPPED: Method = Method::ISM_STANDARD_DROPPED;

const SINGLE: &[Wanted] = &[
    ("a", "(a) ISM standard", Method::ISM_STANDARD),
    ("b", "(b) paper", Method::PAPER),
    ("b-plus", "plus", Method::PLUS),
];
const RING: &[Wanted] = &[
    ("c", "(c) ISM, limit as object", OBJECT),
    ("c-dropped", "ISM, limit dropped", DROPPED),
    ("d", "(d) ISM, limit drawn free", Method::ISM_STANDARD),
    ("e", "(e) paper", Method::PAPER),
    ("e-plus", "plus", Method::PLUS),
];
const DRIVE_BY: &[Wanted] = &[
    ("f", "(f) ISM standard", Method::ISM_STANDARD),
    ("g", "(g) paper", Method::PAPER),
    ("g-plus", "plus", Method::PLUS),
];
const L_MAZE: &[Wanted] = &[
    ("h", "(h) ISM standard", Method::ISM_STANDARD),
    ("i", "(i) paper", Method::PAPER),
    ("i-plus", "plus", Method::PLUS),
];
const T_MAZE: &[Wanted] = &[
    ("j", "(j) ISM standard", Method::ISM_STANDARD),
    ("k", "(k) paper", Method::PAPER),
    ("k-plus", "plus", Method::PLUS),
];
const HALF_WAY: &[Wanted] = &[
    ("l", "(l) ISM standard", Method::ISM_STANDARD),
    ("m", "(m) paper", Method::PAPER),
    ("m-plus", "plus", Method::PLUS),
    ("l-tuned", "ISM tuned", Method::ISM_TUNED),
];

const CAPTION: &str = "Simulated, one seed. Maps of the paper's five scenarios with its ten \
millimetre cells and 1000 particles a sensor; the letters are the paper's, maps without a \
letter are additions. The ISM has its standard parameters unless it says tuned. A sensor \
with nothing in range reads its limit; (c) and (d) differ in what the ISM makes of that. \
In the paper as here, \
the particle filter needs no such rule, and its block in (b), (e) and (g) is less smeared. \
The profile paper counts every rejected particle as free, as the paper prints it, which frees \
the inside of walls; plus leaves it unknown. At the T junction half way the ISM, tuned or not, \
closes the openings to both sides with an arc where the filter leaves them open. The numbers \
below a map: overall error (wrong cells over classified cells, at the best wall expansion; plain: with the \
walls as they are), true and false positive \
rate, share of the visible surface that was found, share of the visible free space that was classified.";

/// Draws the figure.
pub(super) fn draw(seed: u64) -> Result<Plate, FigureError> {
    let mut rows = Vec::new();
    let mut excerpt = None;
    let wanted = [SINGLE, RING, DRIVE_BY, L_MAZE, T_MAZE];
    for (course, wanted) in Course::all()?.iter().zip(wanted) {
        let heading = format!("{}. {}", course.title(), course.scenario.about);
        rows.push(draw_row(
            course,
            heading,
            wanted,
            &Conditions::seeded(seed),
        )?);
        // The T maze, which is the last one, has openings to judge half way.
        if course.title() == "T maze" {
            let row = draw_half_way(course, seed)?;
            let pictures = row.panels.iter().map(|panel| panel.picture.clone());
            // ISM standard, paper and plus.
            let pictures: Vec<_> = pictures.take(3).collect();
            excerpt = Some((EXCERPT.to_owned(), beside(&pictures)));
            rows.push(row);
        }
    }
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Figure 9: maps".to_owned(),
        caption: CAPTION.to_owned(),
        rows,
        tables: Vec::new(),
        excerpt,
    })
}

/// The T junction, when the robot has come to the openings and turned into none.
fn draw_half_way(course: &Course, seed: u64) -> Result<Row, FigureError> {
    let openings = course.scenario.openings.iter();
    let until_m = openings.map(|opening| opening.judged_at_m);
    let conditions = Conditions {
        until_m: until_m.fold(f64::INFINITY, f64::min),
        ..Conditions::seeded(seed)
    };
    let heading = format!(
        "T junction half way: the maps when the robot has driven {:.0} mm and not yet turned",
        1e3 * conditions.until_m
    );
    draw_row(course, heading, HALF_WAY, &conditions)
}

fn draw_row(
    course: &Course,
    heading: String,
    wanted: &[Wanted],
    conditions: &Conditions,
) -> Result<Row, FigureError> {
    let methods: Vec<_> = wanted.iter().map(|(_, _, method)| *method).collect();
    let mapped = course.map(&methods, conditions)?;
    let truth = course.truth(&mapped.poses);
    // One window for all, so that the pictures lie side by side at one scale.
    let known = mapped.maps.iter().filter_map(Window::known);
    let shapes = mapped
        .maps
        .iter()
        .filter_map(|map| window_of_shapes(&course.scenario, map));
    let window = known.chain(shapes).reduce(Window::joined);
    let is_half_way = conditions.until_m.is_finite();
    let panels = wanted
        .iter()
        .zip(&mapped.maps)
        .map(|((letter, title, _), map)| {
            let mut note = scored(map, &truth);
            if is_half_way {
                let closed = closed_cells(&course.scenario, map);
                note = format!("{note}; falsely occupied cells in the openings: {closed}");
            }
            Panel {
                file: format!("{NAME}-{letter}.png"),
                alternative: format!("Map: {}, {title}", course.title()),
                note,
                picture: picture(&course.scenario, title, map, &mapped.poses, window),
            }
        });
    Ok(Row {
        heading,
        panels: panels.collect(),
    })
}

/// The cells that hold all that stands in the world.
fn window_of_shapes(scenario: &Scenario, map: &Map) -> Option<Window> {
    let outlines = scenario.shapes.iter().map(|shape| shape.outline(OUTLINE_M));
    let cells = outlines.flatten().filter_map(|at| map.cell_at(at.x, at.y));
    cells.map(Window::of).reduce(Window::joined)
}

/// A map's numbers in a line.
fn scored(map: &Map, truth: &Truth) -> String {
    let scores = Scores::of(map, truth);
    format!(
        "OE {} (plain {}), TPR {}, FPR {}, surface found {}, coverage {}",
        percent(scores.oe),
        percent(scores.oe_unexpanded),
        share(scores.tpr),
        share(scores.fpr),
        share(scores.surface_recall),
        share(scores.coverage)
    )
}

/// Occupied cells within the openings, where nothing stands.
fn closed_cells(scenario: &Scenario, map: &Map) -> usize {
    let is_closed = |(x, y): (f64, f64)| {
        let mut openings = scenario.openings.iter();
        openings.any(|opening| opening.rectangle.contains(Vector::new(x, y)))
    };
    map.cells_of(Occupancy::Occupied)
        .filter(|cell| is_closed(map.centre(*cell)))
        .count()
}

fn picture(
    scenario: &Scenario,
    title: &str,
    map: &Map,
    poses: &[Pose2],
    window: Option<Window>,
) -> Picture {
    let place = |pose: &Pose2| (pose.position.x, pose.position.y);
    let path: Vec<_> = poses.iter().map(place).collect();
    let outlines: Vec<Vec<_>> = scenario
        .shapes
        .iter()
        .map(|shape| {
            let points = shape.outline(OUTLINE_M);
            points.iter().map(|point| (point.x, point.y)).collect()
        })
        .collect();
    let heading = poses.last().map(Pose2::heading_rad);
    MapPicture {
        robot_radius_m: None,
        title: Some(title),
        path: &path,
        jumps: &[],
        final_heading_rad: heading,
        outlines: &outlines,
        window,
    }
    .render_sized(map, SIDE_PX)
}
