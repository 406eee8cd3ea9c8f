//! A map as the two files that ROS's `map_server` loads.

use std::path::Path;

use crate::lattice::{Cell, Lattice};
use crate::mapping::{Map, Occupancy};
use crate::output::{self, WriteError};

use super::CellWindow;

/// Name of the picture in its folder.
const PICTURE: &str = "map.pgm";

/// Name of the description in its folder.
const DESCRIPTION: &str = "map.yaml";

/// Above this a loader takes p = (255 - grey) / 255 for occupied.
const OCCUPIED_THRESHOLD: f64 = 0.65;

/// Below this a loader takes p = (255 - grey) / 255 for free.
///
/// Unknown is grey 205: p = 50 / 255 = 0.19608, which must not be below. The common
/// 0.25 loads every unknown cell as free.
const FREE_THRESHOLD: f64 = 0.196;

/// The grey of a cell, as `map_saver` writes it.
fn grey(occupancy: Occupancy) -> u8 {
    match occupancy {
        Occupancy::Free => 254,
        Occupancy::Occupied => 0,
        Occupancy::Unknown => 205,
    }
}

/// `map.pgm` and `map.yaml`, cut to the known cells, one pixel per cell.
///
/// Trinary: a cell's class survives, its probability does not. A map without a known
/// cell gives one unknown pixel at the world's origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapServerPair {
    /// The picture: PGM P5, the first row is the largest y; 0 occupied, 254 free, 205 unknown.
    pub pgm: Vec<u8>,
    /// The description: cell size, lower left corner, thresholds.
    pub yaml: String,
}

impl MapServerPair {
    /// The pair for a map.
    #[must_use]
    pub fn new(map: &Map) -> Self {
        let window = CellWindow::known(map).unwrap_or(CellWindow::of(Cell { row: 0, column: 0 }));
        Self {
            pgm: pgm(map, &window),
            yaml: yaml(map.lattice(), window.low()),
        }
    }

    /// Saves both files into a folder that exists.
    ///
    /// Each file is whole or untouched. The picture comes first, so that no description
    /// stands without one; a run killed in between leaves it beside the old description.
    ///
    /// # Errors
    /// If a file cannot be written; the error names it.
    pub fn save(&self, folder: &Path) -> Result<(), WriteError> {
        output::write(&folder.join(PICTURE), &self.pgm)?;
        output::write(&folder.join(DESCRIPTION), self.yaml.as_bytes())
    }
}

fn pgm(map: &Map, window: &CellWindow) -> Vec<u8> {
    let (columns, rows) = (window.columns(), window.rows());
    let mut greys = vec![grey(Occupancy::Unknown); columns * rows];
    for (cell, belief) in map.iter() {
        let Some((column, row)) = window.offset(cell) else {
            continue;
        };
        if let Some(pixel) = greys.get_mut((rows - 1 - row) * columns + column) {
            *pixel = grey(belief.occupancy());
        }
    }
    let mut file = format!("P5\n{columns} {rows}\n255\n").into_bytes();
    file.append(&mut greys);
    file
}

fn yaml(lattice: Lattice, low: Cell) -> String {
    // To the nanometre: -0.29, not -0.29000000000000004.
    let rounded = |metres: f64| (metres * 1e9).round() / 1e9;
    let (x, y) = lattice.corner(low);
    let (x, y) = (rounded(x), rounded(y));
    let cell_m = lattice.cell_m();
    format!(
        "image: {PICTURE}\n\
         mode: trinary\n\
         resolution: {cell_m}\n\
         origin: [{x:?}, {y:?}, 0.0]\n\
         negate: 0\n\
         occupied_thresh: {OCCUPIED_THRESHOLD}\n\
         free_thresh: {FREE_THRESHOLD}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Belief;

    /// What a loader makes of the pair: class, row and column of every pixel.
    fn load(pair: &MapServerPair) -> Vec<(Cell, Occupancy)> {
        let value = |key: &str| {
            let line = pair.yaml.lines().find_map(|line| line.strip_prefix(key));
            line.map(str::trim).expect(key).to_owned()
        };
        let number = |key: &str| value(key).parse::<f64>().unwrap();
        let (occupied, free) = (number("occupied_thresh:"), number("free_thresh:"));
        let resolution = number("resolution:");
        let origin: Vec<f64> = value("origin:")
            .trim_matches(['[', ']'])
            .split(',')
            .map(|number| number.trim().parse().unwrap())
            .collect();
        assert_eq!(value("image:"), "map.pgm");
        assert_eq!(value("mode:"), "trinary");
        assert_eq!(value("negate:"), "0");

        let mut parts = pair.pgm.splitn(4, |byte| *byte == b'\n');
        let mut line = || parts.next().unwrap().to_vec();
        assert_eq!(line(), b"P5");
        let size = String::from_utf8(line()).unwrap();
        let (columns, rows) = size.split_once(' ').unwrap();
        let (columns, rows): (usize, usize) = (columns.parse().unwrap(), rows.parse().unwrap());
        assert_eq!(line(), b"255");
        let pixels = line();
        assert_eq!(pixels.len(), columns * rows);
        let class = |grey: u8| {
            // map_server's words, and Nav2's; then with the precision of a float.
            let p = (255.0 - f64::from(grey)) / 255.0;
            let nav2 = 1.0 - f64::from(grey) / 255.0;
            let coarse = f64::from((255.0 - f32::from(grey)) / 255.0);
            let (coarse_occupied, coarse_free) =
                (f64::from(occupied as f32), f64::from(free as f32));
            let of = |p, occupied, free| {
                if p > occupied {
                    Occupancy::Occupied
                } else if p < free {
                    Occupancy::Free
                } else {
                    Occupancy::Unknown
                }
            };
            assert_eq!(of(p, occupied, free), of(nav2, occupied, free));
            assert_eq!(
                of(p, occupied, free),
                of(coarse, coarse_occupied, coarse_free)
            );
            of(p, occupied, free)
        };
        pixels
            .iter()
            .enumerate()
            .map(|(index, grey)| {
                let from_below = rows - 1 - index / columns;
                let row = (origin[1] / resolution).round() as i32 + from_below as i32;
                let column = (origin[0] / resolution).round() as i32 + (index % columns) as i32;
                (Cell { row, column }, class(*grey))
            })
            .collect()
    }

    #[test]
    fn a_loader_gets_every_cells_class_back() {
        for cell_m in [0.01, 0.05, f64::from(0.01_f32), 0.002_5] {
            let mut map = Map::unknown(cell_m);
            for row in -29..40 {
                for column in -7..90 {
                    // Every class, and probabilities next to the border between them.
                    let p = [0.0, 0.499, 0.5, 0.501, 1.0, f32::NAN];
                    let kind = (row * row + 3 * column) as usize % p.len();
                    *map.reach(Cell { row, column }).unwrap() = Belief::of_probability(p[kind]);
                }
            }
            let loaded = load(&MapServerPair::new(&map));
            assert_eq!(loaded.len(), 69 * 97);
            for (cell, class) in loaded {
                assert_eq!(class, map.occupancy(cell), "{cell:?} of {cell_m} m");
            }
        }
    }

    #[test]
    fn the_first_row_is_the_largest_y() {
        let mut map = Map::unknown(0.01);
        *map.reach(Cell {
            row: -3,
            column: -29,
        })
        .unwrap() = Belief::of_probability(0.0);
        *map.reach(Cell {
            row: -2,
            column: -28,
        })
        .unwrap() = Belief::of_probability(1.0);
        let pair = MapServerPair::new(&map);
        assert_eq!(pair.pgm, b"P5\n2 2\n255\n\xcd\x00\xfe\xcd");
        assert_eq!(
            pair.yaml,
            "image: map.pgm\nmode: trinary\nresolution: 0.01\norigin: [-0.29, -0.03, 0.0]\n\
             negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        );
    }

    #[test]
    fn maps_without_a_known_cell_load_as_unknown() {
        let mut map = Map::unknown(0.01);
        let origin = Cell { row: 0, column: 0 };
        assert_eq!(
            load(&MapServerPair::new(&map)),
            [(origin, Occupancy::Unknown)]
        );
        *map.reach(Cell { row: 70, column: 9 }).unwrap() = Belief::of_probability(0.5);
        assert_eq!(
            load(&MapServerPair::new(&map)),
            [(origin, Occupancy::Unknown)]
        );
    }

    #[test]
    fn both_files_land_in_the_folder() {
        let folder = std::env::temp_dir().join(format!("ipf-map-server-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut map = Map::unknown(0.01);
        *map.reach(Cell { row: 1, column: 1 }).unwrap() = Belief::of_probability(0.7);
        let pair = MapServerPair::new(&map);
        pair.save(&folder).unwrap();
        assert_eq!(std::fs::read(folder.join("map.pgm")).unwrap(), pair.pgm);
        assert_eq!(
            std::fs::read_to_string(folder.join("map.yaml")).unwrap(),
            pair.yaml
        );
        std::fs::remove_dir_all(&folder).unwrap();
        let message = pair.save(&folder).unwrap_err().to_string();
        assert!(message.contains("map.pgm"), "{message}");
    }
}
