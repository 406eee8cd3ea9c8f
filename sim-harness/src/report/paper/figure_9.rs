//! Figure 9: maps of the five scenarios, and of the T junction at half of the drive.

use super::FigureError;
use super::map_row::{Wanted, draw_row};
use super::page_section::{PageSection, PanelRow};
use super::scenario_maps::{Conditions, paper_name};
use crate::mapping::Method;
use crate::report::picture::beside;
use crate::world::{Scenario, standard_scenarios};

/// Name of the figure and of its files.
const NAME: &str = "figure-9";

/// Name of the file with the T junction alone.
const EXCERPT: &str = "t_junction.png";

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
        rows.push(draw_row(NAME, scenario, heading, wanted, &conditions)?);
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
    draw_row(NAME, scenario, heading, HALF_WAY, &conditions)
}
