//! A recorded drive to be mapped: its format, robot and true world.

use std::path::{Path, PathBuf};

use crate::datasets::{Amiro, Dataset, DatasetError, DriveFile, PoseSource, recognise};
use crate::drive::RingCalibration;
use crate::mapping::Method;
use crate::pipeline::DriveSummary;
use crate::rig::{Rig, RigError};
use crate::world::{TrueWorld, WallFileError};

/// A recorded drive to be mapped.
pub struct RecordedDrive {
    /// The file or folder.
    pub path: PathBuf,
    /// Its format.
    pub dataset: &'static dyn Dataset,
    /// The robot.
    pub rig: Rig,
    /// Where the surfaces are, if that is known.
    pub world: Option<TrueWorld>,
}

/// Why a recorded drive cannot be mapped.
#[derive(Debug, thiserror::Error)]
pub enum RecordedDriveError {
    /// The recording.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The file of the robot.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The file of the walls.
    #[error("--walls: {0}")]
    Walls(#[from] WallFileError),
    /// The format has no usual robot.
    #[error("{drive}: recordings of {format} are of any robot: --rig names it")]
    NoRig {
        /// The recording.
        drive: String,
        /// Its format.
        format: &'static str,
    },
}

impl RecordedDrive {
    /// Recognises the format of a drive. The robot is that of the file, or the usual one of
    /// the format; the walls are those of the file, or what the recording tells.
    ///
    /// # Errors
    /// [`RecordedDriveError`]; the records of the drive are not read.
    pub fn open(
        path: &Path,
        rig: Option<&Path>,
        walls: Option<&Path>,
    ) -> Result<Self, RecordedDriveError> {
        let dataset = recognise(path)?;
        let rig = match (rig, dataset.usual_rig()) {
            (Some(file), _) => Rig::load(file)?,
            (None, Some(text)) => Rig::parse(dataset.name(), text)?,
            (None, None) => {
                return Err(RecordedDriveError::NoRig {
                    drive: path.display().to_string(),
                    format: dataset.name(),
                });
            }
        };
        let world = match walls {
            Some(walls) => Some(TrueWorld::load_walls(walls)?),
            None => dataset.true_world(path)?,
        };
        Ok(Self {
            path: path.to_owned(),
            dataset,
            rig,
            world,
        })
    }

    /// The files that mapping it may read: those of its folder, and tables beside the folder
    /// above, where the walls of some recordings are.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let listed = |folder: &Path| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            entries.map(|entry| entry.path()).collect::<Vec<_>>()
        };
        if !self.path.is_dir() {
            return vec![self.path.clone()];
        }
        let path = self
            .path
            .canonicalize()
            .unwrap_or_else(|_| self.path.clone());
        let mut files = listed(&path);
        let above = path.parent().and_then(Path::parent).map(listed);
        let is_table = |file: &PathBuf| file.extension().is_some_and(|it| it == "csv");
        files.extend(above.unwrap_or_default().into_iter().filter(is_table));
        files
    }

    /// The drive as a dataset reads it, with the outcomes of a method's filter if it has one.
    pub(super) fn file(
        &self,
        method: Option<&Method>,
        poses: PoseSource,
        calibration: Option<RingCalibration>,
    ) -> DriveFile<'_> {
        DriveFile {
            path: &self.path,
            rig: &self.rig,
            poses,
            calibration,
            profile: method.and_then(|method| method.profile),
        }
    }

    /// The mounts that a method maps, of those with names that begin so and with data, or why
    /// it cannot.
    pub(super) fn mounts(
        &self,
        method: &Method,
        survey: &DriveSummary,
        names: &[String],
    ) -> Result<Vec<bool>, String> {
        let is_of_ring = method.profile.is_some() || method.fits_signals;
        if is_of_ring && self.dataset.name() != Amiro.name() {
            return Err("needs infrared sensors: signals of an AMiRo's ring".to_owned());
        }
        if method.profile.is_some() && !names.is_empty() {
            return Err(
                "the filter takes the whole ring: `replay --mask` leaves sensors out".to_owned(),
            );
        }
        let mounts = self.rig.mounts.iter().zip(self.rig.mounts_named(names));
        let allowed: Vec<bool> = mounts
            .map(|(mount, is_named)| is_named && !survey.mounts_without_data.contains(&mount.name))
            .collect();
        let mounts = method.sensors.mounts(&self.rig, &allowed);
        mounts.map_err(|missing| missing.to_string())
    }
}
