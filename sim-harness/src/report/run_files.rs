//! The files that a mapped run leaves behind.

use std::fmt;
use std::path::Path;

use super::{CellWindow, MapPicture, MapServerPair, Picture, outlines, save_walls};
use crate::device::Verdict;
use crate::evaluation::{MappedPath, ScoreRecord, WallReport};
use crate::geometry::Pose2;
use crate::output::{self, WriteError};
use crate::world::Scenario;
use crate::{RunRecord, RunStatistics};
use amiro_ipf::node::Config;
use serde::Serialize;

/// `summary.json`: nothing in it depends on when or where it was made.
#[derive(Debug, Serialize)]
pub struct RunSummary {
    /// How the recording was written.
    pub format: String,
    /// Lines or frames that were refused.
    pub refused: u64,
    /// Where the filter ran.
    pub ran_on: &'static str,
    /// The configuration in force.
    pub config: Config,
    /// The run in figures.
    pub figures: RunStatistics,
    /// The map against the truth, where the recording carries one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scores: Option<ScoreRecord>,
    /// Walls beside the path, where there is no truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walls: Option<WallReports>,
    /// The wall segments that were not given up, where there are walls messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_segments: Option<WallCount>,
    /// The board's run, or the recorded one, against this host's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Verdict>,
}

/// Walls beside the whole path, and beside each of its legs if it bends.
#[derive(Debug, Serialize)]
pub struct WallReports {
    whole: WallReport,
    legs: Vec<WallReport>,
}

impl WallReports {
    /// The walls beside the path of a run.
    #[must_use]
    pub fn of(run_record: &RunRecord) -> Self {
        let (map, path) = (run_record.map(), run_record.path());
        let surroundings = MappedPath {
            map: &map,
            counted: &run_record.counted_map(),
            path: &path,
            jumps: run_record.jumps(),
        };
        let legs = WallReport::by_leg(&surroundings);
        Self {
            whole: WallReport::of(&surroundings),
            legs: if legs.len() > 1 { legs } else { Vec::new() },
        }
    }
}

impl fmt::Display for WallReports {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.whole)?;
        for (number, leg) in (1..).zip(&self.legs) {
            write!(f, "\nleg {number} of {} by itself\n{leg}", self.legs.len())?;
        }
        Ok(())
    }
}

/// The wall segments of a run that were not given up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallCount {
    /// Number of them.
    pub standing: u64,
    /// Their length together, metres.
    pub length_m: f64,
    /// Segments that were not kept because there are too many.
    pub refused: u64,
}

impl WallCount {
    /// The segments of a run; `None` without walls messages.
    #[must_use]
    pub fn of(run_record: &RunRecord) -> Option<Self> {
        let walls = run_record.known_walls();
        let lengths = walls.standing().map(|wall| {
            let [from, to] = wall.state.ends;
            (to - from).norm()
        });
        (!walls.is_empty()).then(|| Self {
            standing: walls.standing().count() as u64,
            length_m: lengths.fold(0.0, |sum, length_m| sum + length_m),
            refused: walls.refused(),
        })
    }
}

impl RunSummary {
    /// Writes the summary into a folder.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, folder: &Path) -> Result<(), WriteError> {
        let path = folder.join("summary.json");
        let json = serde_json::to_string_pretty(self);
        let mut json = json.map_err(|error| WriteError {
            path: path.clone(),
            cause: error.into(),
        })?;
        json.push('\n');
        output::write(&path, json.as_bytes())
    }
}

/// The picture of a run, with the outlines of a known world in red and the wall segments
/// of its messages in orange.
#[must_use]
pub fn run_picture(
    run_record: &RunRecord,
    title: &str,
    scenario: Option<&Scenario>,
    window: Option<CellWindow>,
) -> Picture {
    let path = run_record.path();
    let outlines = scenario.map(outlines).unwrap_or_default();
    let walls: Vec<_> = run_record
        .known_walls()
        .standing()
        .map(|wall| wall.state)
        .collect();
    let heading = run_record.poses().last().map(Pose2::heading_rad);
    MapPicture {
        robot_radius_m: None,
        title: Some(title),
        path: &path,
        jumps: run_record.jumps(),
        final_heading_rad: heading,
        outlines: &outlines,
        walls: &walls,
        window,
    }
    .render(&run_record.map())
}

/// The files of a mapped run.
pub const RUN_FILES: [&str; 5] = [
    "map.png",
    "map.pgm",
    "map.yaml",
    "summary.json",
    "stream.ipf",
];

/// Writes `map.png`, `map.pgm` and `map.yaml` into a folder, and the files of the wall
/// segments ([`WALL_FILES`](super::WALL_FILES)) if the run has any.
///
/// # Errors
/// A file cannot be written.
pub fn save_run_map(
    run_record: &RunRecord,
    picture: &Picture,
    folder: &Path,
) -> Result<(), WriteError> {
    picture.save_png(&folder.join("map.png"))?;
    MapServerPair::new(&run_record.map()).save(folder)?;
    save_walls(run_record.known_walls(), folder)
}
