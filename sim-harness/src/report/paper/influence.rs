//! A figure in addition to the paper's: the influence of particles, gate and sensor noise.

use core::ops::Range;

use super::FigureError;
use super::page_section::{PageSection, PageTable, Panel, PanelRow};
use super::scenario_maps::Conditions;
use super::scores::{COLUMNS, COVERAGE, OE, RECALL, Score, judged, percent};
use crate::evaluation::Scores;
use crate::mapping::Method;
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::picture::Colour;
use crate::world::{Options, standard_scenarios};

/// Name of the figure and of its files.
const NAME: &str = "influence";

/// Greatest number of seeds: more would take minutes and show the same.
const MOST_SEEDS: usize = 4;

/// Size of a plot, pixels: three charts lie side by side on the page.
const PLOT_PX: (usize, usize) = (316, 260);

/// The scenarios that are driven, each mapped by both filters.
const SCENARIOS: [&str; 2] = ["msod", "msm_l"];
const FILTERS: [Method; 2] = [Method::PAPER, Method::PLUS];

/// Names and colours of the curves: filters within scenarios.
const CURVES: [(&str, Colour); SCENARIOS.len() * FILTERS.len()] = [
    ("paper, MSOD", [240, 170, 80]),
    ("plus, MSOD", [110, 170, 240]),
    ("paper, L maze", [190, 90, 0]),
    ("plus, L maze", [20, 70, 170]),
];

const CAPTION: &str = "Simulated; our own figure, the paper has none like it. Means over at \
most four seeds, whiskers one standard deviation. Values on the horizontal axes stand \
equally far apart, whatever lies between them. The overall error alone misleads here: with \
few particles it stays low, but less of the free space is classified at all; with a high \
gate or much noise it stays low, but less of the surface is found.";

/// One quantity and its values.
struct Variation {
    file: &'static str,
    heading: &'static str,
    label: &'static str,
    /// Each value as it is written, and the conditions that it makes for any seed.
    values: Vec<(String, Conditions)>,
}

fn variations() -> [Variation; 3] {
    let usual = Conditions::seeded(0);
    let particles = [25_u16, 50, 100, 200, 400, 1000].map(|count| {
        let particles = Some(count);
        (count.to_string(), Conditions { particles, ..usual })
    });
    let gates = [1_u8, 2, 3, 4, 5, 6, 7, 8].map(|steps| {
        let gate = Some(steps);
        (steps.to_string(), Conditions { gate, ..usual })
    });
    let noises = [0.5, 1.0, 2.0, 4.0].map(|noise_factor: f64| {
        let options = Options {
            noise_factor,
            ..usual.options
        };
        (noise_factor.to_string(), Conditions { options, ..usual })
    });
    [
        Variation {
            file: "particles",
            heading: "Particles: the paper and both profiles have 1000 a sensor",
            label: "particles a sensor",
            values: particles.into(),
        },
        Variation {
            file: "gate",
            heading: "Gate: steps that a particle must survive; paper has 4, plus has 5",
            label: "gate g, steps",
            values: gates.into(),
        },
        Variation {
            file: "noise",
            heading: "Sensor noise: the filter keeps the model's, the world has so many times of it",
            label: "sensor noise, times the model's",
            values: noises.into(),
        },
    ]
}

/// The scores of one curve: value by value, one per seed.
type Curve = Vec<Vec<Scores>>;

/// Draws the figure.
pub(super) fn draw(seeds: &Range<u64>) -> Result<PageSection, FigureError> {
    let seeds: Vec<u64> = seeds.clone().take(MOST_SEEDS).collect();
    let (mut rows, mut tables) = (Vec::new(), Vec::new());
    for variation in variations() {
        let curves = variation.curves(&seeds)?;
        let panels = vec![
            variation.panel("oe", "Overall error, best wall expansion", &curves, OE),
            variation.panel("recall", "Surface recall", &curves, RECALL),
            variation.panel("coverage", "Coverage", &curves, COVERAGE),
        ];
        rows.push(PanelRow {
            heading: variation.heading.to_owned(),
            panels,
        });
        tables.push(variation.table(&curves));
    }
    Ok(PageSection {
        name: NAME,
        title: "Ours: what particles, gate and noise do",
        caption: CAPTION,
        rows,
        tables,
        excerpt: None,
    })
}

impl Variation {
    /// The curves in the order of [`CURVES`].
    fn curves(&self, seeds: &[u64]) -> Result<Vec<Curve>, FigureError> {
        let mut curves = vec![Vec::new(); CURVES.len()];
        let scenarios = standard_scenarios()?.into_iter();
        let scenarios = scenarios.filter(|it| SCENARIOS.contains(&it.name.as_str()));
        for (scenario, curves) in scenarios.zip(curves.chunks_mut(FILTERS.len())) {
            for (_, conditions) in &self.values {
                let drives = seeds.iter().map(|&seed| Conditions {
                    seed,
                    ..*conditions
                });
                let scores = judged(&scenario, &FILTERS, drives)?;
                for (curve, scores) in curves.iter_mut().zip(scores) {
                    curve.push(scores);
                }
            }
        }
        Ok(curves)
    }

    fn panel(&self, part: &str, title: &str, curves: &[Curve], score: Score) -> Panel {
        let means = |curve: &Curve| -> Vec<(f64, f64)> {
            curve.iter().map(|scores| percent(scores, score)).collect()
        };
        let curves: Vec<_> = curves.iter().map(means).collect();
        let tops = curves.iter().flatten().map(|(mean, std)| mean + std);
        let high = 1.05 * tops.fold(1.0, f64::max);
        let names: Vec<_> = self.values.iter().map(|(name, _)| name).collect();
        let x = Axis::named(self.label, &names);
        let mut chart = Chart::new(title, x, Axis::linear("share, %", 0.0, high), PLOT_PX);
        for ((name, colour), means) in CURVES.into_iter().zip(&curves) {
            let points = (0_u32..).map(f64::from).zip(means);
            let (line, whiskers): (Vec<_>, Vec<_>) = points
                .map(|(at, (mean, std))| ((at, *mean), (at, mean - std, mean + std)))
                .unzip();
            let marks = vec![
                Mark::Line(line.clone(), 2.0),
                Mark::Dots(line, 8.0),
                Mark::Whiskers(whiskers),
            ];
            chart = chart.with(name, colour, marks);
        }
        let part = format!("{}-{part}", self.file);
        let alternative = format!("{title} against {}", self.label);
        Panel::new(NAME, &part, alternative, chart.render())
    }

    fn table(&self, curves: &[Curve]) -> PageTable {
        let mut head = vec!["filter and scenario", self.label];
        head.extend(COLUMNS.map(|(column, _)| column));
        let mut rows = Vec::new();
        for ((curve_name, _), curve) in CURVES.into_iter().zip(curves) {
            for ((name, _), scores) in self.values.iter().zip(curve) {
                let mut row = vec![curve_name.to_owned(), name.clone()];
                row.extend(COLUMNS.map(|score| format!("{:.1}", percent(scores, score).0)));
                rows.push(row);
            }
        }
        PageTable {
            caption: "Means over the seeds. OE: at the best wall expansion of each map; plain \
                      OE: with the walls as they are.",
            head,
            rows,
        }
    }
}
