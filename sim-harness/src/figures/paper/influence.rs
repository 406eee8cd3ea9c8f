//! A figure of our own: what particles, gate and sensor noise do to the maps.

use core::ops::Range;

use crate::evaluation::{Scores, Truth};
use crate::figures::chart::{Axis, Chart, Layer, Mark};
use crate::figures::picture::Colour;
use crate::mapping::Method;
use crate::world::Options;

use super::FigureError;
use super::course::{Conditions, Course};
use super::moments::Moments;
use super::plate::{Panel, Plate, Row, Table};

/// Name of the figure and of its files.
const NAME: &str = "influence";

/// Most seeds: more would take minutes and show the same.
const MOST_SEEDS: usize = 4;

/// Size of a plot, pixels: three charts lie side by side on the page.
const PLOT_PX: (usize, usize) = (316, 260);

/// The scenarios that are driven.
const SCENARIOS: [&str; 2] = ["MSOD", "L maze"];

/// The curves: scenario, filter, name, colour.
const CURVES: [(&str, Method, &str, Colour); 4] = [
    ("MSOD", Method::PAPER, "paper, MSOD", [240, 170, 80]),
    ("MSOD", Method::PLUS, "plus, MSOD", [110, 170, 240]),
    ("L maze", Method::PAPER, "paper, L maze", [190, 90, 0]),
    ("L maze", Method::PLUS, "plus, L maze", [20, 70, 170]),
];

const CAPTION: &str = "Simulated; our own figure, the paper has none like it. Means over at \
most four seeds, whiskers one standard deviation. Values on the horizontal axes stand \
equally far apart, whatever lies between them. The overall error alone misleads here: with \
few particles it stays low, but less of the free space is classified at all; with a high \
gate or much noise it stays low, but less of the surface is found.";

/// What is varied.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    Particles(u16),
    Gate(u8),
    Noise(f64),
}

/// The three variations: file, heading, label and values.
fn variations() -> [(&'static str, &'static str, &'static str, Vec<Quantity>); 3] {
    let particles = [25, 50, 100, 200, 400, 1000].map(Quantity::Particles);
    let gates = [1, 2, 3, 4, 5, 6, 7, 8].map(Quantity::Gate);
    let noises = [0.5, 1.0, 2.0, 4.0].map(Quantity::Noise);
    [
        (
            "particles",
            "Particles: the paper and both profiles have 1000 a sensor",
            "particles a sensor",
            particles.into(),
        ),
        (
            "gate",
            "Gate: steps that a particle must survive; paper has 4, plus has 5",
            "gate g, steps",
            gates.into(),
        ),
        (
            "noise",
            "Sensor noise: the filter keeps the model's, the world has so many times of it",
            "sensor noise, times the model's",
            noises.into(),
        ),
    ]
}

impl Quantity {
    fn written(self) -> String {
        match self {
            Self::Particles(count) => count.to_string(),
            Self::Gate(gate) => gate.to_string(),
            Self::Noise(factor) => factor.to_string(),
        }
    }

    fn conditions(self, seed: u64) -> Conditions {
        let usual = Conditions::seeded(seed);
        match self {
            Self::Particles(count) => Conditions {
                particles: Some(count),
                ..usual
            },
            Self::Gate(gate) => Conditions {
                gate: Some(gate),
                ..usual
            },
            Self::Noise(noise_factor) => Conditions {
                options: Options {
                    noise_factor,
                    ..usual.options
                },
                ..usual
            },
        }
    }
}

/// The scores of one curve at one value, a seed each.
type Point = Vec<Scores>;

/// Draws the figure.
pub(super) fn draw(seeds: &Range<u64>) -> Result<Plate, FigureError> {
    let seeds: Vec<u64> = seeds.clone().take(MOST_SEEDS).collect();
    let mut courses = Course::all()?;
    courses.retain(|course| SCENARIOS.contains(&course.title()));
    let (mut rows, mut tables) = (Vec::new(), Vec::new());
    for (file, heading, label, values) in variations() {
        let mut curves = CURVES.map(|_| Vec::new());
        for course in &courses {
            vary(course, &values, &seeds, &mut curves)?;
        }
        let names: Vec<_> = values.iter().map(|value| value.written()).collect();
        let axis = || Axis::named(label, &names);
        let panels = vec![
            panel(
                file,
                ("oe", "Overall error, best wall expansion"),
                axis(),
                &curves,
                |scores| scores.oe,
            ),
            panel(
                file,
                ("recall", "Surface recall"),
                axis(),
                &curves,
                |scores| scores.surface_recall,
            ),
            panel(file, ("coverage", "Coverage"), axis(), &curves, |scores| {
                scores.coverage
            }),
        ];
        rows.push(Row {
            heading: heading.to_owned(),
            panels,
        });
        tables.push(table(label, &names, &curves));
    }
    Ok(Plate {
        name: NAME.to_owned(),
        title: "Ours: what particles, gate and noise do".to_owned(),
        caption: CAPTION.to_owned(),
        rows,
        tables,
        excerpt: None,
    })
}

/// Drives one course at all values and seeds, and adds to the curves of that course.
fn vary(
    course: &Course,
    values: &[Quantity],
    seeds: &[u64],
    curves: &mut [Vec<Point>; CURVES.len()],
) -> Result<(), FigureError> {
    let mut truth: Option<Truth> = None;
    for value in values {
        let mut points = [Vec::new(), Vec::new()];
        for seed in seeds {
            let methods = [Method::PAPER, Method::PLUS];
            let mapped = course.map(&methods, &value.conditions(*seed))?;
            // The way is the same for every seed.
            let truth = truth.get_or_insert_with(|| course.truth(&mapped.poses));
            for (point, map) in points.iter_mut().zip(&mapped.maps) {
                point.push(Scores::of(map, truth));
            }
        }
        let of_course = CURVES.iter().zip(curves.iter_mut());
        let of_course = of_course.filter(|(curve, _)| curve.0 == course.title());
        for ((_, curve), point) in of_course.zip(points) {
            curve.push(point);
        }
    }
    Ok(())
}

fn panel(
    file: &str,
    (score, title): (&str, &str),
    axis: Axis,
    curves: &[Vec<Point>],
    value: impl Fn(&Scores) -> Option<f64>,
) -> Panel {
    let alternative = format!("{title} against {}", axis.label());
    let moments = |curve: &Vec<Point>| -> Vec<(f64, Moments)> {
        let percent = |point: &Point| Moments::of(point.iter().map(&value)).times(100.0);
        let places = (0_u32..).map(f64::from);
        places.zip(curve.iter().map(percent)).collect()
    };
    let curves: Vec<_> = curves.iter().map(moments).collect();
    let tops = curves.iter().flatten().map(|(_, m)| m.mean + m.deviation);
    let high = 1.05 * tops.fold(1.0, f64::max);
    let vertical = Axis::linear("share, %", 0.0, high);
    let mut chart = Chart::new(title, axis, vertical, PLOT_PX);
    for ((_, _, name, colour), moments) in CURVES.iter().zip(&curves) {
        let means: Vec<_> = moments.iter().map(|(at, m)| (*at, m.mean)).collect();
        let spread = |(at, m): &(f64, Moments)| (*at, m.mean - m.deviation, m.mean + m.deviation);
        let marks = vec![
            Mark::Line(means.clone(), 2.0),
            Mark::Dots(means, 8.0),
            Mark::Whiskers(moments.iter().map(spread).collect()),
        ];
        chart = chart.with(Layer::new(name, *colour, marks));
    }
    Panel {
        file: format!("{NAME}-{file}-{score}.png"),
        alternative,
        note: String::new(),
        picture: chart.render(),
    }
}

fn table(label: &str, names: &[String], curves: &[Vec<Point>]) -> Table {
    let mut head = vec!["filter and scenario", label];
    head.extend([
        "OE, %",
        "plain OE, %",
        "TPR, %",
        "FPR, %",
        "surface recall, %",
        "coverage, %",
    ]);
    let mut table = Table::new(
        "Means over the seeds. OE: at the best wall expansion of each map; plain OE: with the \
         walls as they are.",
        &head,
    );
    for ((_, _, curve_name, _), curve) in CURVES.iter().zip(curves) {
        for (name, point) in names.iter().zip(curve) {
            let mean = |value: fn(&Scores) -> Option<f64>| {
                let percent = Moments::of(point.iter().map(value)).times(100.0);
                format!("{:.1}", percent.mean)
            };
            table.rows.push(vec![
                (*curve_name).to_owned(),
                name.clone(),
                mean(|scores| scores.oe),
                mean(|scores| scores.oe_unexpanded),
                mean(|scores| scores.tpr),
                mean(|scores| scores.fpr),
                mean(|scores| scores.surface_recall),
                mean(|scores| scores.coverage),
            ]);
        }
    }
    table
}
