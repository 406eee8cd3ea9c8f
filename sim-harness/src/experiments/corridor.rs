//! The experiment of Ivanjko, Petrovic and Macek 2003: a corridor, three calculi, the box.

use std::ops::Range;

use super::range_drive::{DriftingOdometry, poses_along, simulated_records};
use super::report::{
    ExperimentReport, MethodScores, map_of, part_of, rig, room, scored_cells, truth_of,
};
use super::{ExperimentCheck, ExperimentError};
use crate::evaluation::cell_truth::{CellScores, TrueCell, TrueCells};
use crate::geometry::{Pose2, Vector};
use crate::mapping::{Map, Method, Occupancy};

/// Each calculus without and with the box.
const METHODS: [&str; 6] = ["bayes", "bayes-box", "ds", "ds-box", "fuzzy", "fuzzy-box"];

/// 14 x 2 m with closed ends, and two openings 1 m wide and 1.5 m deep.
const WALLS: [[f64; 4]; 12] = [
    [0.0, 0.0, 0.0, 2.0],
    [14.0, 0.0, 14.0, 2.0],
    [0.0, 2.0, 4.0, 2.0],
    [5.0, 2.0, 14.0, 2.0],
    [0.0, 0.0, 8.0, 0.0],
    [9.0, 0.0, 14.0, 0.0],
    [4.0, 2.0, 4.0, 3.5],
    [4.0, 3.5, 5.0, 3.5],
    [5.0, 3.5, 5.0, 2.0],
    [8.0, 0.0, 8.0, -1.5],
    [8.0, -1.5, 9.0, -1.5],
    [9.0, -1.5, 9.0, 0.0],
];

/// From the left end to the right one, a cycle of the sonars per 0.1 m.
const WAY: [[f64; 2]; 2] = [[0.6, 1.0], [12.5, 1.0]];
const STEP_M: f64 = 0.1;

/// Cycles of the local map at the start.
const LOCAL_CYCLES: usize = 5;

/// Drives the corridor per seed, maps it with each method, and checks what the paper reports.
///
/// # Errors
/// A method that the program lacks.
pub fn corridor(seeds: &Range<u64>) -> Result<ExperimentReport, ExperimentError> {
    let (world, rig) = (room(&WALLS), rig("pioneer2dx.toml")?);
    let poses = poses_along(&WAY.map(|[x, y]| Vector::new(x, y)), STEP_M, None);
    let standing = vec![Pose2::new(WAY[0][0], WAY[0][1], 0.0); LOCAL_CYCLES];
    let (mut whole, mut corners) = (MethodScores::new(&METHODS), MethodScores::new(&METHODS));
    let mut local = MethodScores::new(&METHODS);
    let mut openings = METHODS.map(|_| 0.0);
    let mut maps = Vec::new();
    let count = (seeds.end - seeds.start) as f64;
    for seed in seeds.clone() {
        let exact = DriftingOdometry::EXACT;
        let records = simulated_records(&world, &rig, &poses, &exact, seed);
        let (truth, scored) = (truth_of(&world, &records), scored_cells(&rig, &records));
        let ends = part_of(&truth, is_at_end);
        if seed == seeds.start {
            maps.push(("truth".to_owned(), truth.as_map()));
        }
        let at_start = simulated_records(&world, &rig, &standing, &exact, seed);
        let start_scored = scored_cells(&rig, &at_start);
        for (name, opening) in METHODS.into_iter().zip(&mut openings) {
            let method: Method = name.parse()?;
            let map = map_of(&method, &rig, &records);
            let of_whole = CellScores::of(&map, &truth, &scored);
            whole.add(name, of_whole);
            corners.add(name, CellScores::of(&map, &ends, &scored));
            *opening += closed_cells(&truth, &map) as f64 / count;
            if seed == seeds.start {
                maps.push((of_whole.label(name), map));
            }
            let map = map_of(&method, &rig, &at_start);
            local.add(name, CellScores::of(&map, &truth, &start_scored));
        }
    }
    let title = "Corridor with two openings, sixteen sonars (002)";
    let mut lines = whole.lines(title, seeds);
    lines.push(
        "method              TPR at the ends  occupied in openings  TPR at the start".to_owned(),
    );
    for (name, opening) in METHODS.into_iter().zip(openings) {
        let (ends, start) = (corners.of(name).tpr, local.of(name).tpr);
        lines.push(format!(
            "{name:<18}  {ends:>15.3}  {opening:>20.1}  {start:>16.3}"
        ));
    }
    Ok(ExperimentReport {
        lines,
        checks: checks(&whole, &corners, &local, &openings),
        maps,
        curves: Vec::new(),
    })
}

/// Whether a place is near one of the closed ends.
fn is_at_end(place: Vector) -> bool {
    place.x < 1.6 || place.x > 12.6
}

/// Free cells within 0.2 m of the mouths of the openings that a map has as occupied, of some
/// 80.
fn closed_cells(truth: &TrueCells, map: &Map) -> usize {
    let is_mouth = |(x, y): (f64, f64)| {
        let upper = (4.0..5.0).contains(&x) && (y - 2.0).abs() < 0.2;
        let lower = (8.0..9.0).contains(&x) && y.abs() < 0.2;
        upper || lower
    };
    let closed = truth.iter().filter(|(cell, is)| {
        **is == TrueCell::Free
            && is_mouth(truth.centre(*cell))
            && map.occupancy(*cell) == Occupancy::Occupied
    });
    closed.count()
}

fn checks(
    whole: &MethodScores,
    corners: &MethodScores,
    local: &MethodScores,
    openings: &[f64; 6],
) -> Vec<ExperimentCheck> {
    let mut checks = Vec::new();
    let pairs = [
        ("bayes", "bayes-box"),
        ("ds", "ds-box"),
        ("fuzzy", "fuzzy-box"),
    ];
    for (plain, boxed) in pairs {
        let (without, with) = (corners.of(plain), corners.of(boxed));
        checks.push(ExperimentCheck::at_least(
            &format!("TPR at the ends with the box, {plain}"),
            with.tpr,
            without.tpr,
        ));
    }
    let [bayes, bayes_box, ds, ds_box, fuzzy, fuzzy_box] = *openings;
    for (name, without, with) in [
        ("bayes", bayes, bayes_box),
        ("ds", ds, ds_box),
        ("fuzzy", fuzzy, fuzzy_box),
    ] {
        let name = format!("occupied in openings with the box, {name}");
        checks.push(ExperimentCheck::at_least(&name, with, without));
    }
    checks.push(ExperimentCheck::at_least(
        "more of them for fuzzy than for bayes",
        fuzzy_box - fuzzy,
        bayes_box - bayes,
    ));
    for (plain, boxed) in &pairs[..2] {
        checks.push(ExperimentCheck::at_most(
            &format!("OE with the box, {plain}"),
            whole.of(boxed).oe,
            whole.of(plain).oe,
        ));
    }
    let start = METHODS.map(|name| local.of(name).tpr);
    for (name, calculi) in [("without", [0, 2, 4]), ("with", [1, 3, 5])] {
        let values = calculi.map(|index| start[index]);
        let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = values.into_iter().fold(f64::INFINITY, f64::min);
        let name = format!("spread of the three calculi at the start, {name} the box");
        checks.push(ExperimentCheck::at_most(&name, most - least, 0.05));
    }
    checks
}
