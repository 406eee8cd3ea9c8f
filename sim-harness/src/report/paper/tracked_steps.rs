//! The tracked wall segments at three steps of a drive.

use amiro_ipf::filter::{Profile, SegmentModel, SegmentParameters, SegmentTracker};
use amiro_ipf::geometry::Pose;
use amiro_ipf::node::{Scheduled, StepInput, StepScheduler};

use super::page_section::{Panel, PanelRow};
use super::scenario_maps::Conditions;
use crate::drive::WallState;
use crate::geometry::{Pose2, Vector};
use crate::report::chart::{Axis, Chart, Mark};
use crate::report::map_picture::{OUTLINE, PATH, outlines};
use crate::report::picture::Colour;
use crate::world::{Scenario, simulate_with};

/// Width of a plot, pixels: three charts lie side by side on the page.
const PLOT_PX: usize = 320;
/// Half the side of the square that is shown around the robot, millimetres.
const AROUND_MM: f64 = 400.0;
/// Share of the drive at which the segments are shown.
const SHARES: [f64; 3] = [0.15, 0.5, 0.95];
/// Standard deviations that the thin lines lie from a segment.
const BAND_SIGMAS: f64 = 2.0;

const FOLLOWED: Colour = [20, 20, 20];
const FROZEN: Colour = [150, 150, 150];

/// The segments after a step, and whether each is out of reach.
struct TrackedStep {
    pose: Pose,
    segments: Vec<(WallState, bool)>,
}

/// Draws the segments of a drive at three of its steps.
pub(super) fn draw_row(
    figure: &'static str,
    scenario: &Scenario,
    conditions: &Conditions,
) -> PanelRow {
    let steps = track(scenario, conditions);
    let last = steps.len().saturating_sub(1) as f64;
    let panels = SHARES.iter().enumerate().filter_map(|(number, share)| {
        let index = (share * last) as usize;
        let path: Vec<_> = steps.iter().take(index + 1).map(|step| step.pose).collect();
        let title = format!("step {index}");
        let chart = chart(&title, scenario, &path, steps.get(index)?);
        let count = steps.get(index)?.segments.len();
        Some(Panel {
            note: format!("{count} segments"),
            ..Panel::new(
                figure,
                &format!("tracked-{number}"),
                format!("Tracked segments, {title}"),
                chart.render(),
            )
        })
    });
    PanelRow {
        heading: "The tracked segments of the L maze at three steps. Black: followed; grey: out \
                  of reach and kept; thin: two standard deviations across the segment, all other \
                  segments held; red: the true walls; blue: path and robot"
            .to_owned(),
        panels: panels.collect(),
    }
}

fn track(scenario: &Scenario, conditions: &Conditions) -> Vec<TrackedStep> {
    let config = scenario.config(Profile::Wall);
    let segments = SegmentParameters::STEPS;
    let model = SegmentModel::new(segments, &config.photometry, &config.ring);
    let simulation = simulate_with(scenario, conditions.seed, &conditions.options);
    let mut scheduler = StepScheduler::default();
    let mut tracker = SegmentTracker::new();
    let mut steps = Vec::new();
    for input in &simulation.inputs {
        if let Ok(Scheduled::Step(step)) = scheduler.take(&config, input) {
            let StepInput {
                motion,
                samples,
                pose,
                ..
            } = step;
            tracker.step(&model, &motion, &samples, &mut |_| {});
            let state = |segment| (WallState::of(&tracker, segment, &pose), segment.is_frozen());
            let segments = tracker.segments().iter().map(state).collect();
            steps.push(TrackedStep { pose, segments });
        }
    }
    steps
}

fn chart(title: &str, scenario: &Scenario, path: &[Pose], step: &TrackedStep) -> Chart {
    let robot = Pose2::from(step.pose);
    let (x, y) = (1e3 * robot.position.x, 1e3 * robot.position.y);
    let mut chart = Chart::plane(
        title,
        Axis::linear("x, mm", x - AROUND_MM, x + AROUND_MM),
        Axis::linear("y, mm", y - AROUND_MM, y + AROUND_MM),
        PLOT_PX,
    );
    let walls = outlines(scenario).into_iter().map(|polygon| {
        let closed = polygon.iter().chain(polygon.first());
        Mark::Line(closed.map(|(x, y)| (1e3 * x, 1e3 * y)).collect(), 1.0)
    });
    chart = chart.with("", OUTLINE, walls.collect());
    let driven = path.iter().map(|pose| in_mm(Pose2::from(*pose).position));
    let around = (0..=72).map(|corner| {
        let heading = f64::from(corner) * core::f64::consts::TAU / 72.0;
        let turned = crate::geometry::Turn::by_radians_f64(heading);
        in_mm(robot.position + Vector::new(0.05, 0.0).turned(turned))
    });
    let robot = vec![
        Mark::Line(driven.collect(), 1.5),
        Mark::Line(around.collect(), 1.5),
    ];
    chart = chart.with("", PATH, robot);
    for (colour, is_frozen) in [(FROZEN, true), (FOLLOWED, false)] {
        let segments = step.segments.iter().filter(|(_, it)| *it == is_frozen);
        let marks = segments.flat_map(|(state, _)| marks(state));
        chart = chart.with("", colour, marks.collect());
    }
    chart
}

/// A segment, and the lines beside it at a number of its standard deviations.
fn marks(state: &WallState) -> [Mark; 3] {
    let [from, to] = state.ends;
    let along = to - from;
    let normal = Vector::new(-along.y, along.x).scaled(1.0 / along.norm().max(1e-9));
    let [from_m, to_m] = state.across_m.map(Option::unwrap_or_default);
    let beside = |side: f64| {
        let ends = [(from, from_m), (to, to_m)];
        let moved = ends.map(|(end, sigma)| end + normal.scaled(side * BAND_SIGMAS * sigma));
        Mark::Line(moved.map(in_mm).to_vec(), 1.0)
    };
    let itself = Mark::Line([from, to].map(in_mm).to_vec(), 3.0);
    [beside(1.0), beside(-1.0), itself]
}

fn in_mm(place: Vector) -> (f64, f64) {
    (1e3 * place.x, 1e3 * place.y)
}
