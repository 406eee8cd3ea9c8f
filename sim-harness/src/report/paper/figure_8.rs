//! Figure 8: the overall error of every method in every scenario, beside other scores.

use core::ops::Range;

use super::FigureError;
use super::page_section::{PageSection, PageTable, Panel, PanelRow};
use super::scenario_maps::{Conditions, paper_name};
use super::scores::{COLUMNS, COVERAGE, OE, OE_PLAIN, RECALL, Score, TPR, judged, percent};
use crate::evaluation::Scores;
use crate::mapping::Method;
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::picture::{Colour, beside};
use crate::world::standard_scenarios;

/// Name of the figure and of its files.
const NAME: &str = "figure-8";

/// Name of the file with errors and recall alone.
const EXCERPT: &str = "overall_error.png";

/// Size of a plot, pixels: two charts lie side by side on the page.
const PLOT_PX: (usize, usize) = (510, 320);

/// Width of a bar; four of them stand at each scenario.
const BAR_WIDTH: f64 = 0.19;

const CAPTION: &str = "Simulated; the bars are means over the seeds, the whiskers one standard \
deviation of a single drive. Overall error is wrong cells over classified cells, at the \
best wall expansion of up to half the robot's radius, map by map, as in the paper; the plain \
one takes the walls as they are. It must not be read \
alone: a map that calls everything free has a low one. Beside it stand surface recall (the \
share of the visible surface that has an occupied cell nearby), the true positive rate (the \
share of the classified wall cells that are occupied) and coverage (the share of the visible \
free space that is classified). With the default seeds the paper's pattern holds in part: its \
filter has less error than the standard ISM everywhere, the mazes included; against a tuned ISM \
it wins with one sensor and in the drive-by and loses in the other three, and it finds fewer \
wall cells than either. The profile plus has the least error in all five and classifies less \
of the mazes' free space.";

/// Colour of the whiskers over the bars.
const WHISKER: Colour = [40, 40, 40];

/// The methods with their names and colours.
const METHODS: [(Method, &str, Colour); 4] = [
    (Method::ISM_STANDARD, "ISM standard", [170, 170, 170]),
    (Method::ISM_TUNED, "ISM tuned", [110, 110, 110]),
    (Method::PAPER, "paper", [230, 140, 30]),
    (Method::PLUS, "plus", [30, 110, 200]),
];

/// A scenario's name, and the scores of each method, one per seed.
type Judged = (&'static str, Vec<Vec<Scores>>);

/// Draws the figure.
pub(super) fn draw(seeds: &Range<u64>) -> Result<PageSection, FigureError> {
    let methods = METHODS.map(|(method, _, _)| method);
    let scenarios = standard_scenarios()?;
    let scores = scenarios.iter().map(|scenario| {
        let drives = seeds.clone().map(Conditions::seeded);
        Ok((paper_name(scenario), judged(scenario, &methods, drives)?))
    });
    let scores: Vec<Judged> = scores.collect::<Result<_, FigureError>>()?;
    let panels: Vec<_> = [
        ("oe", "Overall error, best wall expansion", 34.0, OE),
        ("oe-plain", "Overall error, plain", 34.0, OE_PLAIN),
        ("recall", "Surface recall", 110.0, RECALL),
        ("tpr", "True positive rate", 110.0, TPR),
        ("coverage", "Coverage", 110.0, COVERAGE),
    ]
    .map(|(part, title, high, score)| bars(&scores, part, title, high, score))
    .into();
    let pictures = panels.iter().map(|panel| panel.picture.clone());
    let pictures: Vec<_> = pictures.take(3).collect();
    let (first, last) = (seeds.start, seeds.end.saturating_sub(1));
    Ok(PageSection {
        name: NAME,
        title: "Figure 8: overall mapping errors",
        caption: CAPTION,
        rows: vec![PanelRow {
            heading: format!("Seeds {first} to {last}"),
            panels,
        }],
        tables: vec![table(&scores)],
        excerpt: Some((EXCERPT, beside(&pictures))),
    })
}

fn bars(scores: &[Judged], part: &str, title: &str, high: f64, score: Score) -> Panel {
    let names: Vec<_> = scores.iter().map(|(name, _)| *name).collect();
    let x = Axis::named("scenario", &names);
    let mut chart = Chart::new(title, x, Axis::linear("share, %", 0.0, high), PLOT_PX);
    for (index, (_, method, colour)) in METHODS.into_iter().enumerate() {
        let aside = (index as f64 - 1.5) * BAR_WIDTH;
        let of_method = scores.iter().filter_map(|(_, methods)| methods.get(index));
        let (mut tops, mut whiskers) = (Vec::new(), Vec::new());
        for (scenario, scores) in of_method.enumerate() {
            let at = scenario as f64 + aside;
            let (mean, std) = percent(scores, score);
            tops.push((at, mean));
            whiskers.push((at, mean - std, mean + std));
        }
        let bars = Mark::Bars(tops, 0.9 * BAR_WIDTH);
        chart = chart.with(method, colour, vec![bars]).with(
            "",
            WHISKER,
            vec![Mark::Whiskers(whiskers)],
        );
    }
    let alternative = format!("Bars: {title}, by scenario and method");
    Panel::new(NAME, part, alternative, chart.render())
}

fn table(scores: &[Judged]) -> PageTable {
    let mut head = vec!["scenario", "method"];
    head.extend(COLUMNS.map(|(column, _)| column));
    // The deviation stands behind the mean of the first score.
    head.insert(3, "+-");
    let mut rows = Vec::new();
    for (scenario, methods) in scores {
        for ((_, method, _), scores) in METHODS.iter().zip(methods) {
            let mut row = vec![(*scenario).to_owned(), (*method).to_owned()];
            row.extend(COLUMNS.map(|score| format!("{:.1}", percent(scores, score).0)));
            row.insert(3, format!("{:.1}", percent(scores, OE).1));
            rows.push(row);
        }
    }
    PageTable {
        caption: "Means over the seeds. OE: at the best wall expansion of each map; plain OE: \
                  with the walls as they are; TPR: classified wall cells that are occupied; \
                  FPR: classified free cells that are occupied; coverage: visible free space \
                  that is classified.",
        head,
        rows,
    }
}
