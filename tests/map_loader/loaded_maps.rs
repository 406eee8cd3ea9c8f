//! The map of a drive, as another project's loader reads it from `map.pgm` and `map.yaml`.
//!
//! `costmap` is a pure Rust alternative to Nav2's costmaps. It has the thresholds of a
//! file inclusive, where `map_server` has them exclusive, and computes in single
//! precision.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use costmap::types::{FREE, OCCUPIED, UNKNOWN};
use costmap::{OccupancyGrid, RosMapLoader};
use glam::{UVec2, Vec2};
use sim_harness::datasets::{DriveFile, Kcma, PoseSource};
use sim_harness::drive::Keyframes;
use sim_harness::lattice::{Cell, Lattice};
use sim_harness::mapping::{Belief, Map, Mapper, Method, Occupancy, Setup};
use sim_harness::pipeline::{self, DriveOptions, KeyframeShare};
use sim_harness::report::MapServerPair;
use sim_harness::rig::Rig;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The map of the committed sonar drive by a method.
fn map_of(name: &str, lattice: Lattice) -> Map {
    let method = Method::of_drives(name).unwrap();
    let rig = Rig::load(&root().join("rigs/kcma.toml")).unwrap();
    let drive = DriveFile {
        path: &root().join("sim-harness/tests/data/robond"),
        rig: &rig,
        poses: PoseSource::default(),
        calibration: None,
        profile: None,
    };
    let allowed: Vec<bool> = rig
        .mounts
        .iter()
        .map(|it| it.name.starts_with("sonar"))
        .collect();
    let options = DriveOptions {
        keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
        share: KeyframeShare::All,
        mounts: method.sensors.mounts(&rig, &allowed).unwrap(),
    };
    let mut mapper = method.mapper(&Setup::new(&rig, lattice));
    let source = |take: &mut dyn FnMut(&_)| {
        pipeline::dataset_records(&Kcma, &drive, &options, &mut |_, _| {}, take)
    };
    pipeline::run(source, &mut mapper, &mut |_, _| {}).unwrap();
    mapper.map()
}

/// The pair of a map in a folder, loaded.
fn loaded(map: &Map) -> OccupancyGrid {
    let folder = tempfile::tempdir().unwrap();
    MapServerPair::new(map).save(folder.path()).unwrap();
    RosMapLoader::load_from_yaml(folder.path().join("map.yaml")).unwrap()
}

fn value(occupancy: Occupancy) -> i8 {
    match occupancy {
        Occupancy::Free => FREE,
        Occupancy::Occupied => OCCUPIED,
        Occupancy::Unknown => UNKNOWN,
    }
}

/// Compares both ways: every known cell of the map at its place in the grid, and every cell
/// of the grid at its place in the map. Gives the number of cells of the grid.
fn compare(map: &Map, grid: &OccupancyGrid, name: &str) -> usize {
    let lattice = map.lattice();
    // A hundredth of a cell, and single precision at 100 m.
    let within_m = 0.01 * lattice.cell_m() as f32 + 1e-5;
    let mut known = 0;
    for (cell, belief) in map
        .iter()
        .filter(|it| it.1.occupancy() != Occupancy::Unknown)
    {
        let (x, y) = lattice.centre(cell);
        let place = grid.world_to_map(Vec2::new(x as f32, y as f32));
        let place = place.unwrap_or_else(|| panic!("{name}: {cell:?} is out of the grid"));
        let found = grid.get(place).copied();
        assert_eq!(found, Some(value(belief.occupancy())), "{name}: {cell:?}");
        known += 1;
    }
    let mut cells = BTreeSet::new();
    for (place, found) in grid.indexed_iter() {
        let centre = grid.map_to_world(place);
        let cell = lattice
            .cell_at(f64::from(centre.x), f64::from(centre.y))
            .unwrap();
        assert_eq!(
            *found,
            value(map.occupancy(cell)),
            "{name}: {cell:?} at {place}"
        );
        let (x, y) = lattice.centre(cell);
        let off = (centre - Vec2::new(x as f32, y as f32)).abs().max_element();
        assert!(off < within_m, "{name}: {cell:?} is {off} m off");
        assert!(cells.insert(cell), "{name}: {cell:?} twice");
    }
    let found = grid.indexed_iter().filter(|it| *it.1 != UNKNOWN).count();
    assert_eq!(found, known, "{name}: known cells");
    cells.len()
}

#[test]
fn maps_of_a_recorded_drive_load_cell_by_cell_in_class_and_place() {
    // Cells of the recording's usual size, smaller ones, and both moved by half a cell.
    for cell_m in [0.1, 0.05] {
        let lattice = Lattice::new(cell_m);
        for lattice in [lattice, lattice.moved_by_half_a_cell()] {
            for name in ["ism", "cemal", "bayes", "fsm"] {
                let map = map_of(name, lattice);
                for class in [Occupancy::Occupied, Occupancy::Free] {
                    assert!(
                        map.count(class) > 50,
                        "{name}: {} {class:?}",
                        map.count(class)
                    );
                }
                let cells = compare(&map, &loaded(&map), name);
                assert!(cells > 1_000, "{name}: {cells}");
            }
        }
    }
}

#[test]
fn each_class_alone_and_a_map_without_a_known_cell_load() {
    for (p_occ, class) in [(0.0, FREE), (1.0, OCCUPIED), (0.5, UNKNOWN)] {
        let mut map = Map::unknown(0.05);
        let cell = Cell {
            row: -40,
            column: 7,
        };
        *map.reach(cell).unwrap() = Belief::of_probability(p_occ);
        let grid = loaded(&map);
        assert_eq!((grid.width(), grid.height()), (1, 1), "{p_occ}");
        assert_eq!(grid.get(UVec2::ZERO), Some(&class), "{p_occ}");
        assert_eq!(compare(&map, &grid, "one cell"), 1);
    }
}
