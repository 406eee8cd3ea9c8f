//! The drives of `map`, and where their maps go.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};

use sim_harness::datasets::{Amiro, Dataset};
use sim_harness::evaluation::drive_maps::{MapSettings, RecordedDrive};
use sim_harness::output;
use sim_harness::report::DriveMapsFiles;

use super::arguments;
use super::map_arguments::MapCommand;

impl MapCommand {
    /// The drives with their robots and truths, and where their maps go.
    pub(super) fn recorded_drives(
        &self,
        settings: &MapSettings,
    ) -> Result<Vec<(RecordedDrive, DriveMapsFiles)>, Box<dyn Error>> {
        let mut names = BTreeSet::new();
        let mut drives = Vec::new();
        for path in &self.drives {
            let mut drive = RecordedDrive::open(path, self.rig.as_deref(), self.walls.as_deref())?;
            if let Some(calibration) = &settings.calibration {
                if drive.dataset.name() != Amiro.name() {
                    let path = path.display();
                    return Err(format!("--gains: {path} is no recording of an AMiRo").into());
                }
                drive.rig.set_alpha(calibration.alpha_counts_m2);
            }
            let mounts = &drive.rig.mounts;
            for name in &self.sensors {
                if !mounts.iter().any(|mount| mount.name.starts_with(name)) {
                    let known: Vec<_> = mounts.iter().map(|it| it.name.as_str()).collect();
                    let (rig, known) = (&drive.rig.name, known.join(", "));
                    return Err(format!("--sensors {name}: rig {rig} has {known}").into());
                }
            }
            let mut out = self.out.clone();
            if self.drives.len() > 1 {
                let name = folder_name(path);
                if !names.insert(name.clone()) {
                    let name = path.display();
                    return Err(format!("{name}: another drive has the same two last names").into());
                }
                out.push(name);
            }
            let is_alone = settings.methods.len() == 1;
            drives.push((drive, DriveMapsFiles { out, is_alone }));
        }
        Ok(drives)
    }

    /// Checks that no output replaces what is read, or another output.
    pub(super) fn check_outputs(
        &self,
        drives: &[(RecordedDrive, DriveMapsFiles)],
        settings: &MapSettings,
    ) -> Result<(), Box<dyn Error>> {
        let files = drives
            .iter()
            .flat_map(|(_, files)| files.names(&settings.methods));
        let files: Vec<PathBuf> = files.chain(self.json.clone()).collect();
        let read: Vec<PathBuf> = drives.iter().flat_map(|(drive, _)| drive.files()).collect();
        let inputs = read.iter().chain(&self.rig).chain(&self.gains);
        let inputs: Vec<&Path> = inputs.chain(&self.walls).map(PathBuf::as_path).collect();
        output::check(&files, &inputs)?;
        if let Some(path) = &self.json {
            let absolute = |path: &PathBuf| std::path::absolute(path).ok();
            let mut maps = files.iter().rev().skip(1);
            if maps.any(|file| absolute(file) == absolute(path)) {
                return Err(format!("--json: {} is a file of a map", path.display()).into());
            }
            arguments::check_file("--json", path)?;
        }
        Ok(())
    }
}

/// The name of a drive's folder of output: its own two last names.
fn folder_name(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let names = path.components().rev().take(2);
    let names = names.map(|part| part.as_os_str().to_string_lossy().replace('/', ""));
    let mut names: Vec<String> = names.collect();
    names.reverse();
    names.join("-")
}
