//! Figure 8: the overall error of every method in every scenario, never alone.

use core::ops::Range;

use crate::evaluation::Scores;
use crate::figures::chart::{Axis, Bar, Chart, Layer, Mark};
use crate::figures::picture::{Colour, beside};
use crate::mapping::Method;

use super::FigureError;
use super::course::{Conditions, Course};
use super::moments::Moments;
use super::plate::{Panel, Plate, Row, Table};

/// Name of the figure and of its files.
const NAME: &str = "figure-8";

/// Name of the file with errors and recall alone.
const EXCERPT: &str = "overall_error.png";

/// Size of a plot, pixels: two charts lie side by side on the page.
const PLOT_PX: (usize, usize) = (510, 320);

/// Width of a bar; four of them stand at each scenario.
const BAR_WIDTH: f64 = 0.19;

/// The four methods that are compared by numbers, with names and colours.
const COMPARED: [(Method, &str, Colour); 4] = [
    (Method::ISM_STANDARD, "ISM standard", [170, 170, 170]),
    (Method::ISM_TUNED, "ISM tuned", [110, 110, 110]),
    (Method::PAPER, "paper", [230, 140, 30]),
    (Method::PLUS, "plus", [30, 110, 200]),
];

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

/// All scores of one method in one scenario, a seed each.
struct Group {
    scenario: &'static str,
    method: &'static str,
    scores: Vec<Scores>,
}

/// Draws the figure.
pub(super) fn draw(seeds: &Range<u64>) -> Result<Plate, FigureError> {
    let courses = Course::all()?;
    let mut groups = Vec::new();
    for course in &courses {
        groups.extend(judge(course, seeds)?);
    }
    let names: Vec<_> = courses.iter().map(Course::title).collect();
    let panels = vec![
        bars(
            &names,
            &groups,
            ("oe", "Overall error, best wall expansion", 34.0),
            |scores| scores.oe,
        ),
        bars(
            &names,
            &groups,
            ("oe-plain", "Overall error, plain", 34.0),
            |scores| scores.oe_unexpanded,
        ),
        bars(
            &names,
            &groups,
            ("recall", "Surface recall", 110.0),
            |scores| scores.surface_recall,
        ),
        bars(
            &names,
            &groups,
            ("tpr", "True positive rate", 110.0),
            |scores| scores.tpr,
        ),
        bars(&names, &groups, ("coverage", "Coverage", 110.0), |scores| {
            scores.coverage
        }),
    ];
    let pictures = panels.iter().map(|panel| panel.picture.clone());
    let pictures: Vec<_> = pictures.take(3).collect();
    let first = seeds.start;
    let last = seeds.end.saturating_sub(1);
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Figure 8: overall mapping errors".to_owned(),
        caption: CAPTION.to_owned(),
        rows: vec![Row {
            heading: format!("Seeds {first} to {last}"),
            panels,
        }],
        tables: vec![table(&groups)],
        excerpt: Some((EXCERPT.to_owned(), beside(&pictures))),
    })
}

fn judge(course: &Course, seeds: &Range<u64>) -> Result<Vec<Group>, FigureError> {
    let methods = COMPARED.map(|(method, _, _)| method);
    let mut groups = COMPARED.map(|(_, method, _)| Group {
        scenario: course.title(),
        method,
        scores: Vec::new(),
    });
    let mut truth = None;
    for seed in seeds.clone() {
        let mapped = course.map(&methods, &Conditions::seeded(seed))?;
        // The way is the same for every seed.
        let truth = truth.get_or_insert_with(|| course.truth(&mapped.poses));
        for (group, map) in groups.iter_mut().zip(&mapped.maps) {
            group.scores.push(Scores::of(map, truth));
        }
    }
    Ok(groups.into())
}

fn bars(
    names: &[&str],
    groups: &[Group],
    (file, title, high): (&str, &str, f64),
    value: impl Fn(&Scores) -> Option<f64>,
) -> Panel {
    let mut chart = Chart::new(
        title,
        Axis::named("scenario", names),
        Axis::linear("share, %", 0.0, high),
        PLOT_PX,
    );
    for (place, (_, method, colour)) in (0_u8..).zip(COMPARED) {
        let aside = (f64::from(place) - 1.5) * BAR_WIDTH;
        let of_method = groups.iter().filter(|group| group.method == method);
        let bars = (0_u32..).zip(of_method).map(|(scenario, group)| {
            let percent = Moments::of(group.scores.iter().map(&value)).times(100.0);
            Bar {
                at: f64::from(scenario) + aside,
                width: 0.9 * BAR_WIDTH,
                height: percent.mean,
                spread: percent.deviation,
            }
        });
        let marks = vec![Mark::Bars(bars.collect())];
        chart = chart.with(Layer::new(method, colour, marks));
    }
    Panel {
        file: format!("{NAME}-{file}.png"),
        alternative: format!("Bars: {title}, by scenario and method"),
        note: String::new(),
        picture: chart.render(),
    }
}

fn table(groups: &[Group]) -> Table {
    let head = [
        "scenario",
        "method",
        "OE, %",
        "+-",
        "plain OE, %",
        "TPR, %",
        "FPR, %",
        "surface recall, %",
        "coverage, %",
    ];
    let mut table = Table::new(
        "Means over the seeds. OE: at the best wall expansion of each map; plain OE: with the \
         walls as they are; TPR: classified wall cells that are occupied; FPR: \
         classified free cells that are occupied; coverage: visible free space that is \
         classified.",
        &head,
    );
    for group in groups {
        let percent = |value: fn(&Scores) -> Option<f64>| {
            Moments::of(group.scores.iter().map(value)).times(100.0)
        };
        let oe = percent(|scores| scores.oe);
        let means = [
            percent(|scores| scores.oe_unexpanded),
            percent(|scores| scores.tpr),
            percent(|scores| scores.fpr),
            percent(|scores| scores.surface_recall),
            percent(|scores| scores.coverage),
        ];
        let mut row = vec![
            group.scenario.to_owned(),
            group.method.to_owned(),
            format!("{:.1}", oe.mean),
            format!("{:.1}", oe.deviation),
        ];
        row.extend(means.map(|moments| format!("{:.1}", moments.mean)));
        table.rows.push(row);
    }
    table
}
