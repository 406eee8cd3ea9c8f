//! The files that a mapped run leaves behind.

use std::fmt;
use std::path::Path;

use amiro_ipf::node::Config;
use serde::Serialize;
use sim_harness::device::Verdict;
use sim_harness::evaluation::{MappedPath, ScoreRecord, WallReport};
use sim_harness::geometry::Pose2;
use sim_harness::output::{self, WriteError};
use sim_harness::report::{CellWindow, MapPicture, MapServerPair, Picture, outlines};
use sim_harness::world::Scenario;
use sim_harness::{RunRecord, RunStatistics};

/// `summary.json`: nothing in it depends on when or where it was made.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    /// How the recording was written.
    pub(super) format: String,
    /// Lines or frames that were refused.
    pub(super) refused: u64,
    /// Where the filter ran.
    pub(super) ran_on: &'static str,
    /// The configuration in force.
    pub(super) config: Config,
    /// The run in figures.
    pub(super) figures: RunStatistics,
    /// The map against the truth, where the recording carries one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) scores: Option<ScoreRecord>,
    /// Walls beside the path, where there is no truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) walls: Option<Walls>,
    /// The board's run, or the recorded one, against this host's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) comparison: Option<Verdict>,
}

/// Walls beside the whole path, and beside each of its legs if it bends.
#[derive(Debug, Serialize)]
pub(super) struct Walls {
    whole: WallReport,
    legs: Vec<WallReport>,
}

impl Walls {
    /// Looks beside the path of a survey.
    pub(super) fn of(survey: &RunRecord) -> Self {
        let (map, path) = (survey.map(), survey.path());
        let surroundings = MappedPath {
            map: &map,
            counted: &survey.counted_map(),
            path: &path,
            jumps: survey.jumps(),
        };
        let legs = WallReport::by_leg(&surroundings);
        Self {
            whole: WallReport::of(&surroundings),
            legs: if legs.len() > 1 { legs } else { Vec::new() },
        }
    }
}

impl fmt::Display for Walls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.whole)?;
        for (number, leg) in (1..).zip(&self.legs) {
            write!(f, "\nleg {number} of {} by itself\n{leg}", self.legs.len())?;
        }
        Ok(())
    }
}

impl Summary {
    /// Writes the summary.
    pub(super) fn save(&self, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let mut json = serde_json::to_string_pretty(self)?;
        json.push('\n');
        output::write(&folder.join("summary.json"), json.as_bytes())?;
        Ok(())
    }
}

/// The picture of a survey, with the outlines of a known world in red.
pub(super) fn picture(
    survey: &RunRecord,
    title: &str,
    scenario: Option<&Scenario>,
    window: Option<CellWindow>,
) -> Picture {
    let path = survey.path();
    let outlines = scenario.map(outlines).unwrap_or_default();
    let heading = survey.poses().last().map(Pose2::heading_rad);
    MapPicture {
        robot_radius_m: None,
        title: Some(title),
        path: &path,
        jumps: survey.jumps(),
        final_heading_rad: heading,
        outlines: &outlines,
        window,
    }
    .render(&survey.map())
}

/// The files of a mapped run.
pub(super) const FILES: [&str; 5] = [
    "map.png",
    "map.pgm",
    "map.yaml",
    "summary.json",
    "stream.ipf",
];

/// Writes `map.png`, `map.pgm` and `map.yaml`.
pub(super) fn save_map(
    survey: &RunRecord,
    picture: &Picture,
    folder: &Path,
) -> Result<(), WriteError> {
    picture.save_png(&folder.join("map.png"))?;
    MapServerPair::new(&survey.map()).save(folder)
}
