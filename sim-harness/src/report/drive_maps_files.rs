//! The files of a drive that was mapped by one method or by several.

use std::path::{Path, PathBuf};

use super::{CellWindow, ContactSheet, DRIVE_FILES, DriveMapSummary, MapPicture};
use crate::evaluation::drive_maps::{DriveMaps, MapRow, MapSettings, MethodMap, RecordedDrive};
use crate::mapping::Method;
use crate::output::{self, WriteError};

/// The files beside the maps of several methods.
const SHEET_FILES: [&str; 2] = ["contact_sheet.png", "truth.png"];

/// Where the maps of a drive go: the folder itself for one method, a folder per method and a
/// sheet of all for several.
#[derive(Clone, Debug)]
pub struct DriveMapsFiles {
    /// The folder.
    pub out: PathBuf,
    /// Whether there is one method.
    pub is_alone: bool,
}

impl DriveMapsFiles {
    /// The files that [`save`](Self::save) may write.
    #[must_use]
    pub fn names(&self, methods: &[Method]) -> Vec<PathBuf> {
        let of_method = |method: &Method| DRIVE_FILES.map(|name| self.folder(method).join(name));
        let mut files: Vec<PathBuf> = methods.iter().flat_map(of_method).collect();
        if !self.is_alone {
            files.extend(SHEET_FILES.map(|name| self.out.join(name)));
        }
        files
    }

    fn folder(&self, method: &Method) -> PathBuf {
        if self.is_alone {
            self.out.clone()
        } else {
            self.out.join(method.name)
        }
    }

    /// Writes all files; the rows label the small maps of the sheet.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn save(
        &self,
        drive: &RecordedDrive,
        settings: &MapSettings,
        maps: &DriveMaps,
        rows: &[MapRow],
    ) -> Result<(), WriteError> {
        output::create_folder(&self.out)?;
        for (method, made) in maps.made().filter(|it| *it.0 != Method::ALL_FREE) {
            let summary = summary_of(drive, settings, method, made);
            let folder = self.folder(method);
            output::create_folder(&folder)?;
            summary.save(&folder, &made.map, &drive.rig, &made.read)?;
        }
        if self.is_alone {
            Ok(())
        } else {
            save_sheet(&self.out, maps, rows)
        }
    }
}

/// The summary of one map of a drive.
#[must_use]
pub fn summary_of<'a>(
    drive: &'a RecordedDrive,
    settings: &MapSettings,
    method: &Method,
    made: &'a MethodMap,
) -> DriveMapSummary<'a> {
    let words = [drive.dataset.name(), method.name, settings.poses.name()];
    DriveMapSummary::of(words, &drive.rig, &made.read, &made.map)
}

/// All maps on one sheet, and the truth.
fn save_sheet(out: &Path, maps: &DriveMaps, rows: &[MapRow]) -> Result<(), WriteError> {
    // A scanner looks farther than the sensors of the other methods.
    let window_of = |splits: bool| {
        let made = maps.made().filter(|(_, made)| made.splits == splits);
        let known = made.filter_map(|(_, made)| CellWindow::known(&made.map));
        known.reduce(CellWindow::joined)
    };
    let Some(window) = window_of(false).or_else(|| window_of(true)) else {
        return Ok(());
    };
    let (path, jumps) = (&maps.survey.path, &maps.survey.jumps);
    let mut sheet = ContactSheet::new(window, path, jumps);
    if let Some(truth) = &maps.truth {
        let map = truth.cells.as_map();
        sheet.add("truth".to_owned(), &map);
        let picture = MapPicture {
            title: Some("truth"),
            path,
            jumps,
            ..MapPicture::default()
        };
        picture.render(&map).save_png(&out.join("truth.png"))?;
    }
    for (method, made) in maps.made().filter(|it| *it.0 != Method::ALL_FREE) {
        let row = rows.iter().find(|row| row.method == method.name);
        let label = row.map_or_else(|| method.name.to_owned(), MapRow::label);
        sheet.add(label, &made.map);
    }
    sheet.render().save_png(&out.join("contact_sheet.png"))
}
