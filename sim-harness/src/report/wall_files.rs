//! The wall segments of a run as files: a table, and lines for a map.

use std::io;
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use crate::drive::{KnownWall, KnownWalls, WallFate};
use crate::output::{self, WriteError};

/// The files of the wall segments; a run without walls messages has none.
pub const WALL_FILES: [&str; 2] = ["walls.csv", "walls.json"];

/// The columns of `walls.csv`.
const COLUMNS: [&str; 15] = [
    "id",
    "fate",
    "x0_m",
    "y0_m",
    "x1_m",
    "y1_m",
    "sigma_along_0_m",
    "sigma_across_0_m",
    "sigma_along_1_m",
    "sigma_across_1_m",
    "evidence",
    "first_step",
    "first_stamp_us",
    "last_step",
    "last_stamp_us",
];

/// A row of `walls.csv`, and the properties of a line in `walls.json`. Metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct WallRow {
    id: u16,
    fate: WallFate,
    x0_m: f64,
    y0_m: f64,
    x1_m: f64,
    y1_m: f64,
    sigma_along_0_m: Option<f64>,
    sigma_across_0_m: Option<f64>,
    sigma_along_1_m: Option<f64>,
    sigma_across_1_m: Option<f64>,
    evidence: f64,
    first_step: u32,
    first_stamp_us: Option<u64>,
    last_step: u32,
    last_stamp_us: Option<u64>,
}

/// Writes `walls.csv` and `walls.json` into a folder; removes those of an earlier run if
/// no walls message came.
///
/// The table has a row for each segment that was ever tracked, with its last state in the
/// world. The lines are those that were not given up.
///
/// # Errors
/// A file cannot be written or removed.
pub fn save_walls(walls: &KnownWalls, folder: &Path) -> Result<(), WriteError> {
    let [csv, json] = WALL_FILES.map(|name| folder.join(name));
    if walls.is_empty() {
        output::remove(&csv)?;
        return output::remove(&json);
    }
    output::write_with(&csv, |file| {
        let mut table = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(file);
        table.write_record(COLUMNS).map_err(io::Error::other)?;
        for wall in walls.all() {
            table.serialize(row(wall)).map_err(io::Error::other)?;
        }
        table.flush()
    })?;
    let lines: Vec<Value> = walls.standing().map(line).collect();
    let collection = json!({ "type": "FeatureCollection", "features": lines });
    output::write(&json, format!("{collection:#}\n").as_bytes())
}

fn row(wall: &KnownWall) -> WallRow {
    let [from, to] = wall.state.ends;
    let [along_0, along_1] = wall.state.along_m;
    let [across_0, across_1] = wall.state.across_m;
    let rounded = |sigma: Option<f64>| sigma.map(to_tenths_of_mm);
    WallRow {
        id: wall.id,
        fate: wall.fate,
        x0_m: to_tenths_of_mm(from.x),
        y0_m: to_tenths_of_mm(from.y),
        x1_m: to_tenths_of_mm(to.x),
        y1_m: to_tenths_of_mm(to.y),
        sigma_along_0_m: rounded(along_0),
        sigma_across_0_m: rounded(across_0),
        sigma_along_1_m: rounded(along_1),
        sigma_across_1_m: rounded(across_1),
        evidence: wall.state.evidence,
        first_step: wall.first.index,
        first_stamp_us: wall.first.stamp_us,
        last_step: wall.last.index,
        last_stamp_us: wall.last.stamp_us,
    }
}

fn line(wall: &KnownWall) -> Value {
    let row = row(wall);
    json!({
        "type": "Feature",
        "geometry": {
            "type": "LineString",
            "coordinates": [[row.x0_m, row.y0_m], [row.x1_m, row.y1_m]],
        },
        "properties": row,
    })
}

/// The messages hold half millimetres, which have four decimals in metres.
fn to_tenths_of_mm(metres: f64) -> f64 {
    // Plus 0 makes -0 a 0.
    (metres * 1e4).round() / 1e4 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::node::{TrackedWall, Walls};

    #[test]
    fn a_table_has_all_walls_and_the_lines_those_that_stand() {
        let wall = |id, evidence| TrackedWall {
            id,
            ends: [[0, 200], [401, 201]],
            along: [20, 255],
            across: [2, 3],
            evidence,
        };
        let mut known = KnownWalls::new(12.0);
        let first = [wall(1, 50), wall(2, 3)].into_iter().collect();
        let first = Walls {
            seen: first,
            ..Walls::default()
        };
        known.take(&first, Some(7));
        let second = Walls {
            index: 1,
            seen: [wall(1, 51)].into_iter().collect(),
            ..Walls::default()
        };
        known.take(&second, None);
        let folder = tempfile::tempdir().unwrap();
        save_walls(&known, folder.path()).unwrap();
        let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(
            read("walls.csv"),
            "id,fate,x0_m,y0_m,x1_m,y1_m,sigma_along_0_m,sigma_across_0_m,sigma_along_1_m,\
             sigma_across_1_m,evidence,first_step,first_stamp_us,last_step,last_stamp_us\n\
             1,tracked,0.0,0.1,0.2005,0.1005,0.01,0.001,,0.0015,51.0,0,7,1,\n\
             2,given_up,0.0,0.1,0.2005,0.1005,0.01,0.001,,0.0015,3.0,0,7,0,7\n"
        );
        let json: Value = serde_json::from_str(&read("walls.json")).unwrap();
        let lines = json["features"].as_array().unwrap();
        assert_eq!(lines.len(), 1);
        assert_eq!(
            lines[0]["geometry"]["coordinates"],
            json!([[0.0, 0.1], [0.2005, 0.1005]])
        );
        assert_eq!(lines[0]["properties"]["sigma_along_1_m"], Value::Null);
        // A run without walls leaves none of another run behind.
        save_walls(&KnownWalls::new(12.0), folder.path()).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
