//! The experiment of Lee: a laser and sonars on one robot, a layer each, fused.

use std::ops::Range;

use super::range_drive::{DriftingOdometry, poses_along, simulated_records};
use super::report::{ExperimentReport, MethodScores, map_of, rig, room, truth_of};
use super::{ExperimentCheck, ExperimentError};
use crate::evaluation::cell_truth::{CellScores, ScoredCells, TrueCell, TrueCells};
use crate::geometry::Vector;
use crate::lattice::Cell;
use crate::mapping::{Belief, Map, Method, Occupancy};

const LASER: &str = "laser";
const SONAR: &str = "sonar";
const PESSIMISTIC: &str = "pessimistic";
const MINMAX: &str = "minmax";
const METHODS: [&str; 4] = [LASER, SONAR, PESSIMISTIC, MINMAX];

/// A row of the table: the laser's layer with an odometry that drifts.
const DRIFTED: &str = "laser, odometry";

/// A floor of 25 x 20 m: hallways, a room with a door, a niche, a box.
const WALLS: [[f64; 4]; 16] = [
    [0.0, 2.0, 10.0, 2.0],
    [11.0, 2.0, 24.0, 2.0],
    [0.0, 2.0, 0.0, 4.2],
    [0.0, 4.2, 5.5, 4.2],
    [6.4, 4.2, 21.8, 4.2],
    [21.8, 4.2, 21.8, 18.0],
    [24.0, 2.0, 24.0, 18.0],
    [21.8, 18.0, 24.0, 18.0],
    [4.0, 4.2, 4.0, 8.0],
    [4.0, 8.0, 8.0, 8.0],
    [8.0, 8.0, 8.0, 4.2],
    [10.0, 2.0, 10.0, -1.0],
    [10.0, -1.0, 11.0, -1.0],
    [11.0, -1.0, 11.0, 2.0],
    [4.9, 8.0, 4.9, 7.5],
    [4.9, 7.5, 4.0, 7.5],
];

/// From the room through its door and along two hallways.
const WAY: [[f64; 2]; 4] = [[5.95, 6.8], [5.95, 3.1], [22.9, 3.1], [22.9, 16.0]];
const STEP_M: f64 = 0.06;
const TURN_DEG: f64 = 5.0;

/// Odometry that drifts: by 0.7 m over the way, and by 3.4 degrees.
const DRIFT: DriftingOdometry = DriftingOdometry {
    scale: 1.02,
    turn_rad_per_m: 0.1 / 180.0 * core::f64::consts::PI,
};

/// Sums over seeds that are no scores.
#[derive(Clone, Copy, Debug, Default)]
struct LayerFigures {
    /// Mean probability of free on free cells that the layer knows: laser, sonar.
    free: [f64; 2],
    /// Share of the cells that the laser supplied: pessimistic, MinMax.
    of_laser: [f64; 2],
    /// Share of the scored free cells that are free in the map, in the order of the methods.
    tnr: [f64; 4],
}

/// Drives the floor per seed, maps it with each layer and fusion, and checks what the paper
/// reports.
///
/// # Errors
/// A method that the program lacks.
pub fn two_sensors(seeds: &Range<u64>) -> Result<ExperimentReport, ExperimentError> {
    let (world, rig) = (room(&WALLS), rig("pioneer2dx_laser.toml")?);
    let way = WAY.map(|[x, y]| Vector::new(x, y));
    let poses = poses_along(&way, STEP_M, Some(TURN_DEG.to_radians()));
    let [laser, sonar, pessimistic, minmax] = METHODS.map(str::parse::<Method>);
    let methods = [laser?, sonar?, pessimistic?, minmax?];
    let mut scores = MethodScores::new(&[LASER, SONAR, PESSIMISTIC, MINMAX, DRIFTED]);
    let mut sums = LayerFigures::default();
    let mut shown = Vec::new();
    let count = (seeds.end - seeds.start) as f64;
    for seed in seeds.clone() {
        let exact = DriftingOdometry::EXACT;
        let records = simulated_records(&world, &rig, &poses, &exact, seed);
        let truth = truth_of(&world, &records);
        if seed == seeds.start {
            shown.push(("truth".to_owned(), truth.as_map()));
        }
        let maps = methods.map(|method| map_of(&method, &rig, &records));
        let [laser, sonar, pessimistic, minmax] = &maps;
        let scored = ScoredCells::known_in(&[laser, sonar], laser.lattice(), &rig);
        for (name, map) in METHODS.into_iter().zip(&maps) {
            let of_map = CellScores::of(map, &truth, &scored);
            scores.add(name, of_map);
            if seed == seeds.start {
                shown.push((of_map.label(name), map.clone()));
            }
        }
        if seed == seeds.start {
            for (name, fused) in [(PESSIMISTIC, pessimistic), (MINMAX, minmax)] {
                let label = format!("source of {name}\nblack: laser\nwhite: sonars");
                shown.push((label, source_map(fused, [laser, sonar])));
            }
        }
        for (sum, map) in sums.tnr.iter_mut().zip(&maps) {
            *sum += true_negatives(&truth, map, [laser, sonar]) / count;
        }
        for (sum, map) in sums.free.iter_mut().zip([laser, sonar]) {
            *sum += mean_free(&truth, map) / count;
        }
        for (sum, fused) in sums.of_laser.iter_mut().zip([pessimistic, minmax]) {
            *sum += laser_share(&truth, fused, [laser, sonar]) / count;
        }
        let drifted = simulated_records(&world, &rig, &poses, &DRIFT, seed);
        let drifted = map_of(&methods[0], &rig, &drifted);
        scores.add(DRIFTED, CellScores::of(&drifted, &truth, &scored));
    }
    let title = "Hallways, laser of 181 beams and sixteen sonars (004)";
    let mut lines = scores.lines(title, seeds);
    let [laser, sonar] = sums.free;
    let [pessimistic, minmax] = sums.of_laser;
    lines.push(format!(
        "mean probability of free on known free cells: laser {laser:.3}, sonar {sonar:.3}"
    ));
    let [of_laser, of_sonar, of_pessimistic, of_minmax] = sums.tnr;
    lines.push(format!(
        "share of the free cells that are free: laser {of_laser:.3}, sonar {of_sonar:.3}, \
         pessimistic {of_pessimistic:.3}, minmax {of_minmax:.3}"
    ));
    lines.push(format!(
        "share of cells from the laser: pessimistic {pessimistic:.3}, minmax {minmax:.3}"
    ));
    Ok(ExperimentReport {
        lines,
        checks: checks(&scores, &sums),
        maps: shown,
        curves: Vec::new(),
    })
}

fn free_cells(truth: &TrueCells) -> impl Iterator<Item = Cell> {
    let free = truth.iter().filter(|(_, is)| **is == TrueCell::Free);
    free.map(|(cell, _)| cell)
}

fn is_known(map: &Map, cell: Cell) -> bool {
    map.occupancy(cell) != Occupancy::Unknown
}

fn p_occ(map: &Map, cell: Cell) -> f64 {
    map.get(cell)
        .map_or(0.5, |belief| f64::from(belief.p_occ()))
}

/// Mean probability of free on the free cells that a map knows.
fn mean_free(truth: &TrueCells, map: &Map) -> f64 {
    let known = free_cells(truth).filter(|cell| is_known(map, *cell));
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), cell| {
        (sum + 1.0 - p_occ(map, cell), count + 1.0)
    });
    sum / count
}

/// Share of the free cells that a layer knows which a map has as free.
fn true_negatives(truth: &TrueCells, map: &Map, layers: [&Map; 2]) -> f64 {
    let is_scored = |cell: &Cell| layers.iter().any(|layer| is_known(layer, *cell));
    let scored: Vec<Cell> = free_cells(truth).filter(is_scored).collect();
    let free = scored
        .iter()
        .filter(|cell| map.occupancy(**cell) == Occupancy::Free);
    free.count() as f64 / scored.len() as f64
}

/// Share of the cells that a layer knows in which a fused map has the laser's value; of equal
/// values the laser's counts, as the first.
fn laser_share(truth: &TrueCells, fused: &Map, layers: [&Map; 2]) -> f64 {
    let (mut of_laser, mut all) = (0.0, 0.0);
    for (cell, is) in truth.iter() {
        if *is == TrueCell::Outside {
            continue;
        }
        if let Some(is_of_laser) = is_of_laser(cell, fused, layers) {
            all += 1.0;
            of_laser += f64::from(u8::from(is_of_laser));
        }
    }
    of_laser / all
}

/// Whether a fused map has the laser's value in a cell; `None` if no layer knows the cell.
fn is_of_laser(cell: Cell, fused: &Map, [laser, sonar]: [&Map; 2]) -> Option<bool> {
    let [value, by_laser, by_sonar] = [fused, laser, sonar].map(|map| p_occ(map, cell));
    let is_of_laser = (value - by_laser).abs() <= (value - by_sonar).abs();
    (is_known(laser, cell) || is_known(sonar, cell)).then_some(is_of_laser)
}

/// The layer that supplied each cell, as a map: occupied for the laser's, free for the
/// sonars'.
fn source_map(fused: &Map, layers: [&Map; 2]) -> Map {
    let mut source = Map::unknown(fused.lattice());
    for (cell, _) in fused.iter() {
        let is_of_laser = is_of_laser(cell, fused, layers);
        if let Some((held, is_of_laser)) = source.reach(cell).zip(is_of_laser) {
            *held = Belief::of_probability(f32::from(u8::from(is_of_laser)));
        }
    }
    source
}

fn checks(scores: &MethodScores, sums: &LayerFigures) -> Vec<ExperimentCheck> {
    let [laser, sonar, pessimistic, minmax] = METHODS.map(|name| scores.of(name));
    let [laser_tnr, _, pessimistic_tnr, minmax_tnr] = sums.tnr;
    let best = [laser, sonar, minmax].map(|it| it.tpr);
    let best = best.into_iter().fold(0.0, f64::max);
    let at_least = ExperimentCheck::at_least;
    vec![
        at_least(
            "probability of free, laser above sonar",
            sums.free[0],
            sums.free[1],
        ),
        at_least("TPR of pessimistic, the best", pessimistic.tpr, best),
        ExperimentCheck::at_most(
            "free cells that pessimistic has, not more than the laser",
            pessimistic_tnr,
            laser_tnr,
        ),
        at_least("TPR of minmax, that of the laser", minmax.tpr, laser.tpr),
        at_least(
            "free cells that minmax has, those of the laser",
            minmax_tnr,
            laser_tnr,
        ),
        at_least("share of minmax from the laser", sums.of_laser[1], 0.5),
        at_least(
            "OE of the laser with drift",
            scores.of(DRIFTED).oe,
            laser.oe,
        ),
    ]
}
