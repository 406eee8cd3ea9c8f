//! A row of maps of one drive, by several methods and at one scale.

use super::FigureError;
use super::page_section::{Panel, PanelRow};
use super::scenario_maps::{Conditions, ScenarioMaps, paper_name};
use crate::evaluation::{Scores, Truth};
use crate::geometry::Pose2;
use crate::mapping::{Map, Method, Occupancy};
use crate::report::cell_window::CellWindow;
use crate::report::map_picture::{MapPicture, outlines};
use crate::report::picture::Picture;
use crate::world::{Scenario, Vector};

/// Longer side of a map, pixels: three lie side by side on the page.
const SIDE_PX: usize = 370;

/// A map of a figure: the paper's letter or another part of a file's name, title, method.
pub(super) type Wanted = (&'static str, &'static str, Method);

/// Maps one drive by several methods, and draws the maps at one scale.
pub(super) fn draw_row(
    figure: &'static str,
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
            ..Panel::new(figure, part, alternative, picture)
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
