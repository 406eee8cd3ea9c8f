//! Where the surfaces around a recorded drive are known from.

use std::path::Path;

use super::Scenario;
use crate::bounded::read_at_most;
use crate::escape::whole_escaped;
use crate::geometry::Vector;

/// Longest file of walls, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Most walls of a file.
const MAX_WALLS: usize = 10_000;

/// Largest coordinate of a wall, metres.
const MAX_M: f64 = 10_000.0;

/// Where the surfaces around a recorded drive are known from.
#[derive(Clone, Debug)]
pub enum TrueWorld {
    /// From the scanner of the recording itself, with the poses that the map is made with.
    Scanner,
    /// Walls between two places each.
    Walls(Vec<[Vector; 2]>),
    /// The scenario that the drive was simulated in.
    Scenario(Box<Scenario>),
}

/// As in `truth from its scanner`.
impl core::fmt::Display for TrueWorld {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Scanner => f.write_str("its scanner"),
            Self::Walls(walls) => write!(f, "{} walls", walls.len()),
            Self::Scenario(scenario) => write!(f, "its scenario {}", scenario.name),
        }
    }
}

/// Why a file of walls was refused.
#[derive(Debug, thiserror::Error)]
pub enum WallFileError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file's name, escaped.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// A row is no wall.
    #[error("{file}, line {line}: {reason}")]
    Row {
        /// The file's name, escaped.
        file: String,
        /// Number of the line, from 1.
        line: u64,
        /// What is wrong.
        reason: String,
    },
}

impl TrueWorld {
    /// Reads walls: CSV under the header `x1,y1,x2,y2`, metres in the world of the poses.
    ///
    /// # Errors
    /// The file cannot be read, is longer than 1 MiB, has no wall or more than 10 000, or a
    /// row is not four finite numbers within 10 km.
    pub fn load_walls(path: &Path) -> Result<Self, WallFileError> {
        let file = || whole_escaped(path.to_string_lossy().chars()).to_string();
        let refused = |line, reason: String| WallFileError::Row {
            file: file(),
            line,
            reason,
        };
        let text = read_at_most(path, MAX_BYTES).map_err(|source| WallFileError::Read {
            file: file(),
            source,
        })?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(text.as_slice());
        let header = reader
            .headers()
            .map_err(|error| refused(1, error.to_string()))?;
        if header != ["x1", "y1", "x2", "y2"].as_slice() {
            return Err(refused(1, "the header is not x1,y1,x2,y2".to_owned()));
        }
        let mut walls = Vec::new();
        for row in reader.records() {
            let row = row.map_err(|error| {
                let line = error.position().map_or(0, csv::Position::line);
                refused(line, "four numbers are expected".to_owned())
            })?;
            let line = row.position().map_or(0, csv::Position::line);
            let mut ends = [0.0; 4];
            for (end, text) in ends.iter_mut().zip(&row) {
                let metres = text.parse().ok().filter(|it: &f64| it.abs() <= MAX_M);
                *end = metres.ok_or_else(|| {
                    refused(line, format!("a number within {MAX_M} m is expected"))
                })?;
            }
            if walls.len() >= MAX_WALLS {
                return Err(refused(line, format!("more than {MAX_WALLS} walls")));
            }
            let [x1, y1, x2, y2] = ends;
            walls.push([Vector::new(x1, y1), Vector::new(x2, y2)]);
        }
        if walls.is_empty() {
            return Err(refused(1, "there is no wall".to_owned()));
        }
        Ok(Self::Walls(walls))
    }

    /// Whether most of the walls, by length, run along the borders of cells of a size, metres,
    /// that are counted from the world's origin: which cell beside such a wall is wall would
    /// be decided by rounding.
    #[must_use]
    pub fn lies_on_borders(&self, cell_m: f64) -> bool {
        let Self::Walls(walls) = self else {
            return false;
        };
        let is_border = |from: f64, to: f64| {
            let cells = from / cell_m;
            (from - to).abs() < 1e-6 && (cells - cells.round()).abs() < 1e-6
        };
        let (mut along_m, mut all_m) = (0.0, 0.0);
        for [from, to] in walls {
            let length_m = (*to - *from).norm();
            all_m += length_m;
            if is_border(from.x, to.x) || is_border(from.y, to.y) {
                along_m += length_m;
            }
        }
        all_m > 0.0 && 2.0 * along_m > all_m
    }
}
