//! Not in the paper: maps of extended surfaces.

use super::FigureError;
use super::map_row::{Wanted, draw_row};
use super::page_section::PageSection;
use super::scenario_maps::{Conditions, paper_name};
use super::tracked_steps;
use crate::mapping::Method;
use crate::report::picture::beside;
use crate::world::{Options, Physics, standard_scenarios};

/// Name of the figure and of its files.
const NAME: &str = "walls";

/// Name of the file with the T maze alone.
const EXCERPT: &str = "walls_t_maze.png";

const L_MAZE: &[Wanted] = &maps("l-ism", "l-plus", "l-wall", "l-segments", "l-wall-map");
const T_MAZE: &[Wanted] = &maps("t-ism", "t-plus", "t-wall", "t-segments", "t-wall-map");
const DRIVE_BY: &[Wanted] = &maps("b-ism", "b-plus", "b-wall", "b-segments", "b-wall-map");

const fn maps(
    ism: &'static str,
    plus: &'static str,
    wall: &'static str,
    segments: &'static str,
    wall_map: &'static str,
) -> [Wanted; 5] {
    [
        (ism, "ISM tuned", Method::ISM_TUNED),
        (plus, "plus", Method::PLUS),
        (wall, "wall", Method::WALL),
        (segments, "segments", Method::SEGMENTS),
        (wall_map, "wall-map", Method::WALL_MAP),
    ]
}

const CAPTION: &str = "Simulated, one seed, in the physics patch: the returns of all that a \
sensor sees add up, as those of real walls do. The ISM and the profile plus take a wall for a \
point, and place it behind its face or lose it. The profile wall weighs its particles against \
wall segments that it tracks; segments is the map of these segments alone; wall-map fits \
straight walls to all signals after the drive. Walls that no reading shows stay unknown. \
World and filter share the law here; the recorded series in docs/evaluation.md are the check. \
The numbers below a map are those of figure 9.";

/// Draws the figure.
pub(super) fn draw(seed: u64) -> Result<PageSection, FigureError> {
    let conditions = Conditions {
        options: Options {
            physics: Physics::Patch,
            ..Options::default()
        },
        ..Conditions::seeded(seed)
    };
    let mut rows = Vec::new();
    let mut excerpt = None;
    for scenario in &standard_scenarios()? {
        let name = paper_name(scenario);
        let wanted = match name {
            "MSOD" => DRIVE_BY,
            "L maze" => L_MAZE,
            "T maze" => T_MAZE,
            _ => continue,
        };
        let row = draw_row(NAME, scenario, name.to_owned(), wanted, &conditions)?;
        if name == "L maze" {
            rows.push(tracked_steps::draw_row(NAME, scenario, &conditions));
        }
        if name == "T maze" {
            let pictures = row.panels.iter().map(|panel| panel.picture.clone());
            excerpt = Some((EXCERPT, beside(&pictures.collect::<Vec<_>>())));
        }
        rows.push(row);
    }
    Ok(PageSection {
        name: NAME,
        title: "Extended surfaces: maps of real walls",
        caption: CAPTION,
        rows,
        tables: Vec::new(),
        excerpt,
    })
}
