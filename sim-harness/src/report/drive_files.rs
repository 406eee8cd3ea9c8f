//! The files of a drive that was mapped from its records.

use std::path::Path;

use serde::Serialize;

use super::{MapPicture, MapServerPair};
use crate::mapping::{Map, Occupancy};
use crate::output::{self, WriteError};
use crate::pipeline::{DriveFigures, DriveSummary};
use crate::rig::Rig;

/// The files of a mapped drive.
pub const DRIVE_FILES: [&str; 4] = ["map.png", "map.pgm", "map.yaml", "summary.json"];

/// `summary.json`: nothing in it depends on when or where it was made.
#[derive(Clone, Debug, Serialize)]
pub struct DriveMapSummary<'a> {
    /// The recording's format.
    pub format: &'a str,
    /// The rig's name.
    pub rig: &'a str,
    /// The method's name.
    pub method: &'a str,
    /// Which poses were used.
    pub poses: &'a str,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// The drive in numbers.
    pub figures: &'a DriveFigures,
    /// Occupied cells of the map.
    pub cells_occupied: u64,
    /// Free cells of the map.
    pub cells_free: u64,
    /// Updates of cells that were refused; above zero, the map is cut.
    pub cells_refused: u64,
}

impl<'a> DriveMapSummary<'a> {
    /// The summary of a map, of a recording in a format under a method with poses of a kind.
    #[must_use]
    pub fn of(
        [format, method, poses]: [&'a str; 3],
        rig: &'a Rig,
        drive: &'a DriveSummary,
        map: &Map,
    ) -> Self {
        let count = |wanted| map.count(wanted) as u64;
        Self {
            format,
            rig: &rig.name,
            method,
            poses,
            cell_m: map.cell_m(),
            figures: &drive.figures,
            cells_occupied: count(Occupancy::Occupied),
            cells_free: count(Occupancy::Free),
            cells_refused: map.refused(),
        }
    }

    /// Writes the files of [`DRIVE_FILES`] into a folder.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn save(
        &self,
        folder: &Path,
        map: &Map,
        rig: &Rig,
        drive: &DriveSummary,
    ) -> Result<(), WriteError> {
        let title = format!("{}, {}", self.rig, self.method);
        let picture = MapPicture {
            title: Some(&title),
            path: &drive.path,
            jumps: &drive.jumps,
            robot_radius_m: Some(rig.radius_m),
            ..MapPicture::default()
        };
        picture.render(map).save_png(&folder.join("map.png"))?;
        MapServerPair::new(map).save(folder)?;
        let path = folder.join("summary.json");
        let json = serde_json::to_string_pretty(self).map_err(|error| WriteError {
            path: path.clone(),
            cause: error.into(),
        })?;
        output::write(&path, format!("{json}\n").as_bytes())
    }
}
