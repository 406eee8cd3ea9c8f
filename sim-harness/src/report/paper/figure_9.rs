//! Figure 9: maps of the five scenarios, and of the T junction at half of the drive.

use super::FigureError;
use super::page_section::{PageSection, Panel, PanelRow};
use super::scenario_maps::{Conditions, ScenarioMaps, paper_name};
use crate::evaluation::{Scores, Truth};
use crate::geometry::Pose2;
use crate::mapping::{Map, Method, Occupancy};
use crate::report::cell_window::CellWindow;
use crate::report::map_picture::{MapPicture, outlines};
use crate::report::picture::{Picture, beside};
use crate::world::{Scenario, Vector, standard_scenarios};

/// Name of the figure and of its files.
const NAME: &str = "figure-9";

/// Name of the file with the T junction alone.
const EXCERPT: &str = "t_junction.png";

/// Longer side of a map, pixels: three lie side by side on the page.
const SIDE_PX: usize = 370;

/// A map of the figure: the paper's letter or an addition to it, title, method.
type Wanted = (&'static str, &'static str, Method);

const SINGLE: &[Wanted] = &maps("a", "b", "b-plus");
const RING: &[Wanted] = &[
    ("c", "ISM, limit as object", Method::ISM_STANDARD_OBJECT),
    (
        "c-dropped",
        "ISM, limit dropped",
        Method::ISM_STANDARD_DROPPED,
    ),
    ("d", "ISM, limit drawn free", Method::ISM_STANDARD),
    ("e", "paper", Method::PAPER),
    ("e-plus", "plus", Method::PLUS),
];
const DRIVE_BY: &[Wanted] = &maps("f", "g", "g-plus");
const L_MAZE: &[Wanted] = &maps("h", "i", "i-plus");
const T_MAZE: &[Wanted] = &maps("j", "k", "k-plus");
const HALF_WAY: &[Wanted] = &[
    ("l", "ISM standard", Method::ISM_STANDARD),
    ("m", "paper", Method::PAPER),
    ("m-plus", "plus", Method::PLUS),
    ("l-tuned", "ISM tuned", Method::ISM_TUNED),
];

const fn maps(ism: &'static str, paper: &'static str, plus: &'static str) -> [Wanted; 3] {
    [
        (ism, "ISM standard", Method::ISM_STANDARD),
        (paper, "paper", Method::PAPER),
        (plus, "plus", Method::PLUS),
    ]
}

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
pub(super) fn draw(seed: u64) -> Result<PageSection, FigureError> {
    let mut rows = Vec::new();
    let mut excerpt = None;
    let wanted = [SINGLE, RING, DRIVE_BY, L_MAZE, T_MAZE];
    for (scenario, wanted) in standard_scenarios()?.iter().zip(wanted) {
        let name = paper_name(scenario);
        let heading = format!("{name}. {}", scenario.about);
        let conditions = Conditions::seeded(seed);
        rows.push(draw_row(scenario, heading, wanted, &conditions)?);
        // The T maze, which is the last one, has openings to judge half way.
        if name == "T maze" {
            let row = draw_half_way(scenario, seed)?;
            let pictures = row.panels.iter().map(|panel| panel.picture.clone());
            // ISM standard, paper and plus.
            let pictures: Vec<_> = pictures.take(3).collect();
            excerpt = Some((EXCERPT, beside(&pictures)));
            rows.push(row);
        }
    }
    Ok(PageSection {
        name: NAME,
        title: "Figure 9: maps",
        caption: CAPTION,
        rows,
        tables: Vec::new(),
        excerpt,
    })
}

/// The T junction when the robot is at the openings and has turned into neither.
fn draw_half_way(scenario: &Scenario, seed: u64) -> Result<PanelRow, FigureError> {
    let openings = scenario.openings.iter();
    let until_m = openings.map(|opening| opening.judged_at_m);
    let conditions = Conditions {
        until_m: until_m.fold(f64::INFINITY, f64::min),
        ..Conditions::seeded(seed)
    };
    let heading = format!(
        "T junction half way: the maps when the robot has driven {:.0} mm and not yet turned",
        1e3 * conditions.until_m
    );
    draw_row(scenario, heading, HALF_WAY, &conditions)
}

fn draw_row(
    scenario: &Scenario,
    heading: String,
    wanted: &[Wanted],
    conditions: &Conditions,
) -> Result<PanelRow, FigureError> {
    let methods: Vec<_> = wanted.iter().map(|(_, _, method)| *method).collect();
    let ScenarioMaps { maps, poses } = ScenarioMaps::new(scenario, &methods, conditions)?;
    let truth = Truth::of(scenario, &poses);
    let outlines = outlines(scenario);
    // One window for all, so that the pictures lie side by side at one scale.
    let known = maps.iter().filter_map(CellWindow::known);
    let corners = outlines.iter().flatten();
    let shapes = maps.iter().flat_map(|map| {
        let cells = corners.clone().filter_map(|(x, y)| map.cell_at(*x, *y));
        cells.map(CellWindow::of)
    });
    let window = known.chain(shapes).reduce(CellWindow::joined);
    let panels = wanted.iter().zip(&maps).map(|((part, title, _), map)| {
        // The paper's own maps have one letter.
        let title = match part.len() {
            1 => format!("({part}) {title}"),
            _ => (*title).to_owned(),
        };
        let mut note = scored(map, &truth);
        if conditions.until_m.is_finite() {
            let closed = closed_cells(scenario, map);
            note = format!("{note}; falsely occupied cells in the openings: {closed}");
        }
        let picture = picture(&title, map, &poses, &outlines, window);
        let alternative = format!("Map: {}, {title}", paper_name(scenario));
        Panel {
            note,
            ..Panel::new(NAME, part, alternative, picture)
        }
    });
    Ok(PanelRow {
        heading,
        panels: panels.collect(),
    })
}

/// A map's numbers in a line; a share of nothing is a dash.
fn scored(map: &Map, truth: &Truth) -> String {
    let scores = Scores::of(map, truth);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let percent = |share: Option<f64>| or_dash(share.map(|it| format!("{:.1} %", 100.0 * it)));
    let share = |share: Option<f64>| or_dash(share.map(|it| format!("{it:.2}")));
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
    map.iter()
        .filter(|(_, p_occ)| p_occ.occupancy() == Occupancy::Occupied)
        .filter(|(cell, _)| is_closed(map.centre(*cell)))
        .count()
}

fn picture(
    title: &str,
    map: &Map,
    poses: &[Pose2],
    outlines: &[Vec<(f64, f64)>],
    window: Option<CellWindow>,
) -> Picture {
    let positions = poses.iter().map(|pose| pose.position);
    let path: Vec<_> = positions.map(|at| (at.x, at.y)).collect();
    let heading = poses.last().map(Pose2::heading_rad);
    MapPicture {
        title: Some(title),
        path: &path,
        final_heading_rad: heading,
        outlines,
        window,
        ..MapPicture::default()
    }
    .render_sized(map, SIDE_PX)
}
