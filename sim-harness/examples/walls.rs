//! Time of the report on walls over the length of a drive.
//!
//! A robot drives in lanes of 5 m, 0.6 m apart, with a wall 0.15 m to either side, and steps
//! every 10 mm: `cargo run --release -p sim-harness --example walls`.

use std::time::Instant;

use sim_harness::console;
use sim_harness::evaluation::{MappedPath, WallReport};
use sim_harness::mapping::{Belief, Map};

const STEP_M: f64 = 0.01;
const LANE_M: f64 = 5.0;
const APART_M: f64 = 0.6;
const WALL_M: f64 = 0.15;

fn main() {
    for length_m in [10.0, 20.0, 40.0, 80.0, 160.0, 288.0] {
        let (map, path) = drive(length_m);
        let begun = Instant::now();
        let surroundings = MappedPath::new(&map, &path);
        let legs = WallReport::by_leg(&surroundings);
        let whole = WallReport::of(&surroundings);
        console::print(format_args!(
            "{length_m:4} m: {:6.2} s, {} steps, {} cells, {} legs",
            begun.elapsed().as_secs_f64(),
            path.len(),
            whole.left.occupied + whole.right.occupied,
            legs.len()
        ));
    }
}

/// The map and the path of a drive of the given length.
fn drive(length_m: f64) -> (Map, Vec<(f64, f64)>) {
    let mut map = Map::unknown(STEP_M);
    let mut path = Vec::new();
    for step in 0..(length_m / STEP_M) as u32 {
        let way_m = STEP_M * f64::from(step);
        let lane = (way_m / LANE_M).floor();
        let along_m = way_m - LANE_M * lane;
        let back = lane % 2.0 > 0.5;
        let x = if back { LANE_M - along_m } else { along_m };
        let y = APART_M * lane;
        path.push((x, y));
        for wall_m in [-WALL_M, WALL_M] {
            let cell = map.cell_at(x, y + wall_m);
            if let Some(cell) = cell.and_then(|cell| map.reach(cell)) {
                *cell = Belief::of_probability(1.0);
            }
        }
    }
    (map, path)
}
