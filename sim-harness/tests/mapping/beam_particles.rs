//! The inverted particle filter for range beams, on recordings with exact walls.

use std::fs;
use std::path::Path;

use sim_harness::datasets::{Dataset, DriveFile, NanoSwarm, PoseSource};
use sim_harness::drive::{RangeScan, Record, Return};
use sim_harness::geometry::Vector;
use sim_harness::lattice::Cell;
use sim_harness::mapping::{Grid, Map, Mapper, Method, Occupancy, Setup};
use sim_harness::rig::Rig;
use sim_harness::sensors::View;

use crate::common::{recordings, report_skipped, root};

const CELL_M: f64 = 0.05;

/// Half a cell: the walls lie on multiples of 0.5 m, and pass through centres with it.
const SHIFT: Vector = Vector::new(0.025, 0.025);

/// The scans of a recording, moved by [`SHIFT`].
fn scans(folder: &Path, rig: &str) -> (Rig, Vec<Record>) {
    let rig = Rig::load(&root().join("rigs").join(rig)).unwrap();
    let drive = DriveFile {
        path: folder,
        rig: &rig,
        poses: PoseSource::MotionCapture,
        calibration: None,
        profile: None,
    };
    let mut records = Vec::new();
    let mut take = |record: &Record| {
        let mut record = record.clone();
        if let Record::Scan(scan) = &mut record {
            scan.world_from_body.position = scan.world_from_body.position + SHIFT;
        }
        records.push(record);
    };
    NanoSwarm.read(&drive, &mut |_, _| {}, &mut take).unwrap();
    (rig, records)
}

/// The cells that an echo of these scans looks at.
fn mark(mask: &mut Grid<bool>, rig: &Rig, records: &[Record]) {
    for record in records {
        let Record::Scan(RangeScan {
            world_from_body,
            returns,
            ..
        }) = record
        else {
            continue;
        };
        let mut returns = returns.iter();
        for mount in &rig.mounts {
            let model = mount.sensor.model();
            for (index, measured) in returns.by_ref().take(model.returns()).enumerate() {
                if !matches!(measured, Return::Echo { .. }) {
                    continue;
                }
                let view = View {
                    index,
                    measured: *measured,
                    world_from_sensor: *world_from_body * mount.body_from_sensor,
                    tolerance_m: CELL_M,
                    lattice: mask.lattice(),
                };
                model.footprint(&view, &mut |seen| {
                    *mask.reach(seen.cell).unwrap() = true;
                });
            }
        }
    }
}

/// The cells with a wall, and those that are connected with the drones' places.
fn truth(walls: &Path, records: &[Record]) -> Grid<Option<bool>> {
    let mut truth = Grid::new(CELL_M, None);
    let text = fs::read_to_string(walls).unwrap();
    let walls: Vec<[Vector; 2]> = text
        .lines()
        .skip(1)
        .map(|line| {
            let ends: Vec<f64> = line
                .split(',')
                .map(|it| it.trim().parse().unwrap())
                .collect();
            [
                Vector::new(ends[0], ends[1]) + SHIFT,
                Vector::new(ends[2], ends[3]) + SHIFT,
            ]
        })
        .collect();
    let lattice = truth.lattice();
    let places = records.iter().filter_map(|record| match record {
        Record::Scan(scan) => Some(scan.world_from_body.position),
        _ => None,
    });
    let mut open: Vec<Cell> = places
        .filter_map(|it| lattice.cell_at(it.x, it.y))
        .collect();
    while let Some(cell) = open.pop() {
        let known = truth.reach(cell).unwrap();
        if known.is_some() {
            continue;
        }
        let (x, y) = lattice.centre(cell);
        let distance =
            |[from, to]: &[Vector; 2]| Vector::new(x, y).distance_from_segment(*from, *to);
        let is_wall = walls
            .iter()
            .any(|wall| distance(wall) <= 0.5 * CELL_M + 1e-9);
        *known = Some(is_wall);
        if !is_wall {
            for (row, column) in [(0, 1), (0, -1), (1, 0), (-1, 0)] {
                open.push(Cell {
                    row: cell.row + row,
                    column: cell.column + column,
                });
            }
        }
    }
    truth
}

/// Error, TPR, FPR, coverage of a map within the mask.
fn scores(map: &Map, truth: &Grid<Option<bool>>, mask: &Grid<bool>) -> [f64; 4] {
    let [mut occupied, mut free, mut hits, mut false_hits, mut known] = [0.0; 5];
    for (cell, is_wall) in truth.iter() {
        let (Some(is_wall), Some(true)) = (is_wall, mask.get(cell)) else {
            continue;
        };
        let found = map.occupancy(cell);
        known += f64::from(u8::from(found != Occupancy::Unknown));
        let hit = f64::from(u8::from(found == Occupancy::Occupied));
        if *is_wall {
            occupied += 1.0;
            hits += hit;
        } else {
            free += 1.0;
            false_hits += hit;
        }
    }
    let all = occupied + free;
    [
        (false_hits + occupied - hits) / all,
        hits / occupied,
        false_hits / free,
        known / all,
    ]
}

#[test]
fn maps_of_the_drones_are_as_good_as_an_independent_implementation_found() {
    let Some(folder) = recordings() else {
        report_skipped("the recordings of nano_swarm are missing");
        return;
    };
    let folder = folder.join("nano_swarm");
    let runs = [
        ("exp1/two-drones", "walls_env1a.csv"),
        ("exp1/four-drones", "walls_env1b.csv"),
        ("exp2/two-drones", "walls_env2.csv"),
        ("exp2/four-drones", "walls_env2.csv"),
    ];
    let methods = [Method::KLEPPE, Method::KLEPPE_PAPER];
    let mut means = [[0.0; 4]; 2];
    for (run, walls) in runs {
        let (rig, records) = scans(&folder.join(run), "nano_swarm.toml");
        let (wide, of_cones) = scans(&folder.join(run), "nano_swarm_wide.toml");
        let truth = truth(&folder.join(walls), &records);
        let mut mask = Grid::new(CELL_M, false);
        mark(&mut mask, &rig, &records);
        mark(&mut mask, &wide, &of_cones);
        for (method, mean) in methods.iter().zip(&mut means) {
            let mut mapper = method.mapper(&Setup::new(&rig, CELL_M));
            records.iter().for_each(|record| mapper.take(record));
            mapper.finish(&mut |_| {});
            for (sum, score) in mean.iter_mut().zip(scores(&mapper.map(), &truth, &mask)) {
                *sum += 0.25 * score;
            }
        }
    }
    // The bounds of particle methods: 0.015 in error and FPR, 0.05 in TPR and coverage.
    let expected = [[0.078, 0.671, 0.059, 0.76], [0.081, 0.371, 0.039, 0.34]];
    for (mean, expected) in means.iter().zip(expected) {
        for ((found, expected), within) in mean.iter().zip(expected).zip([0.015, 0.05, 0.015, 0.05])
        {
            assert!((found - expected).abs() < within, "{means:.3?}");
        }
    }
}
