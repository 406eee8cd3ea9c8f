//! The experiment of Carvalho and Ventura 2013: a lap in a room with specular walls.

use std::ops::Range;

use super::range_drive::{DriftingOdometry, poses_along, simulated_records};
use super::report::{ExperimentReport, MethodScores, map_of, rig, room, scored_cells, truth_of};
use super::{ExperimentCheck, ExperimentError};
use crate::evaluation::cell_truth::{CellScores, receiver_operating_characteristic};
use crate::geometry::Vector;
use crate::mapping::Method;

/// The paper's six maps, MAL alone, and the map without a method.
const METHODS: [&str; 8] = [
    "all-free",
    "ism",
    "ism-decay",
    "ism-cesp",
    "fsm",
    "fsm-cesp",
    "cemal",
    "mal",
];

/// The six that the paper compares.
const COMPARED: [&str; 6] = ["ism", "ism-decay", "ism-cesp", "fsm", "fsm-cesp", "cemal"];

/// Those behind the filter of contradicting echoes.
const FILTERED: [&str; 3] = ["ism-cesp", "fsm-cesp", "cemal"];

/// 10 x 7 m, a block inside, and three pillars at the walls.
const WALLS: [[f64; 4]; 17] = [
    [0.0, 0.0, 10.0, 0.0],
    [10.0, 0.0, 10.0, 7.0],
    [10.0, 7.0, 0.0, 7.0],
    [0.0, 7.0, 0.0, 0.0],
    [2.0, 2.0, 8.0, 2.0],
    [8.0, 2.0, 8.0, 5.0],
    [8.0, 5.0, 2.0, 5.0],
    [2.0, 5.0, 2.0, 2.0],
    [4.2, 0.0, 4.2, 0.4],
    [4.2, 0.4, 4.8, 0.4],
    [4.8, 0.4, 4.8, 0.0],
    [10.0, 3.0, 9.5, 3.0],
    [9.5, 3.0, 9.5, 3.6],
    [9.5, 3.6, 10.0, 3.6],
    [1.0, 7.0, 1.0, 6.5],
    [1.0, 6.5, 1.6, 6.5],
    [1.6, 6.5, 1.6, 7.0],
];

/// The lap; a cycle of the sonars per 0.15 m: 0.6 m/s at 4 Hz.
const LAP: [[f64; 2]; 5] = [[1.0, 1.0], [9.0, 1.0], [9.0, 6.0], [1.0, 6.0], [1.0, 1.15]];
const STEP_M: f64 = 0.15;

/// Drives a lap per seed, maps it with each method, and checks what the paper reports.
///
/// # Errors
/// A method that the program lacks.
pub fn specular_room(seeds: &Range<u64>) -> Result<ExperimentReport, ExperimentError> {
    let (world, rig) = (room(&WALLS), rig("pioneer3at.toml")?);
    let lap = LAP.map(|[x, y]| Vector::new(x, y));
    let poses = poses_along(&lap, STEP_M, None);
    let mut scores = MethodScores::new(&METHODS);
    let (mut maps, mut curves) = (Vec::new(), Vec::new());
    for seed in seeds.clone() {
        let records = simulated_records(&world, &rig, &poses, &DriftingOdometry::EXACT, seed);
        let (truth, scored) = (truth_of(&world, &records), scored_cells(&rig, &records));
        if seed == seeds.start {
            maps.push(("truth".to_owned(), truth.as_map()));
        }
        for name in METHODS {
            let method: Method = name.parse()?;
            if method == Method::ALL_FREE {
                scores.add(name, CellScores::of_all_free(&truth, &scored));
                continue;
            }
            let map = map_of(&method, &rig, &records);
            let of_method = CellScores::of(&map, &truth, &scored);
            scores.add(name, of_method);
            if seed == seeds.start {
                let curve = receiver_operating_characteristic(&map, &truth, &scored);
                curves.push((name.to_owned(), curve));
                maps.push((of_method.label(name), map));
            }
        }
    }
    let title = "Room with specular walls, eight sonars, 1400 readings (001)";
    Ok(ExperimentReport {
        lines: scores.lines(title, seeds),
        checks: checks(&scores),
        maps,
        curves,
    })
}

fn checks(scores: &MethodScores) -> Vec<ExperimentCheck> {
    let error = |name: &str| scores.of(name).oe;
    let (ism, fsm) = (error("ism"), error("fsm"));
    let filtered = FILTERED.map(error);
    let most = filtered.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let least = filtered.into_iter().fold(f64::INFINITY, f64::min);
    let cesp = scores.of("ism-cesp").tpr;
    let others = COMPARED.iter().filter(|name| **name != "ism-cesp");
    let best = others.map(|name| scores.of(name).tpr).fold(0.0, f64::max);
    let false_positives = |name: &str| scores.of(name).fpr;
    let (cemal, plain) = (false_positives("cemal"), false_positives("ism"));
    vec![
        ExperimentCheck::at_most("OE without filter: fsm, below ism", fsm, ism),
        ExperimentCheck::at_most("largest OE with filter, 0.6 of ism", most, 0.6 * ism),
        ExperimentCheck::at_most("spread of OE with filter", most - least, 0.03),
        ExperimentCheck::at_least("TPR of ism-cesp, best of the six", cesp, best),
        ExperimentCheck::at_most("FPR of cemal, below ism", cemal, plain),
    ]
}
