//! Recorded drives of robots: one file of code per file format.
//!
//! A [`Dataset`] recognises its format and reads a drive row by row into [`Record`]s, in
//! bounded memory. A row that cannot be used is refused with its place and the reason, and
//! the rows around it are kept.

mod amiro;
mod error;
mod fields;
mod kcma;
mod lines;
mod nano_swarm;
mod number_rows;
mod player;
mod pose_source;
mod sharp_ir;

pub use amiro::Amiro;
pub use error::{DatasetError, RefusedRow, RefusedRows};
pub use kcma::Kcma;
pub use nano_swarm::NanoSwarm;
pub use player::Player;
pub use pose_source::{PoseSource, UnknownPoseSource};
pub use sharp_ir::SharpIr;

use std::path::Path;

use error::shown;

use amiro_ipf::filter::Profile;

use crate::drive::{Keyframes, Record, RingCalibration};
use crate::rig::Rig;
use crate::world::TrueWorld;

/// The formats that are known, in the order in which they are tried.
pub const DATASETS: [&dyn Dataset; 5] = [&Kcma, &NanoSwarm, &Player, &SharpIr, &Amiro];

/// A drive to be read.
#[derive(Clone, Copy, Debug)]
pub struct DriveFile<'a> {
    /// The file or folder.
    pub path: &'a Path,
    /// The robot.
    pub rig: &'a Rig,
    /// Which poses are wanted.
    pub poses: PoseSource,
    /// Alpha and gains of the sensors of an AMiRo, in place of those of the recording.
    pub calibration: Option<RingCalibration>,
    /// The profile of the inverse particle filter whose outcomes are wanted between the
    /// scans; a format of other robots than the AMiRo has none to give.
    pub profile: Option<Profile>,
}

/// What a drive of a format is mapped with where nothing else is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UsualMapping {
    /// Which poses are mapped.
    pub keyframes: Keyframes,
    /// Side of a cell, millimetres.
    pub cell_mm: u16,
}

/// What was read of a drive.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadRows {
    /// Rows that were used.
    pub used: u64,
    /// Rows that were not.
    pub refused: RefusedRows,
    /// What else the user should know, a line each.
    pub notes: Vec<String>,
}

/// A format of recorded drives.
pub trait Dataset: Sync {
    /// The format's name.
    fn name(&self) -> &'static str;

    /// What a path of this format leads to, as an error lists it.
    fn looks_for(&self) -> &'static str;

    /// How a drive is mapped where nothing else is asked for.
    fn usual(&self) -> UsualMapping;

    /// The robot that the recordings of this format usually are of, as the text of a rig
    /// file; `None` if there is no usual one.
    fn usual_rig(&self) -> Option<&'static str> {
        None
    }

    /// Where the surfaces around this drive are known from, as far as the recording itself or
    /// the files beside it tell.
    ///
    /// # Errors
    /// What should tell is there and cannot be used.
    fn true_world(&self, _path: &Path) -> Result<Option<TrueWorld>, DatasetError> {
        Ok(None)
    }

    /// Whether the file or folder is of this format; reads names and heads only.
    fn recognises(&self, path: &Path) -> bool;

    /// Reads a drive and hands on its records in order, stamps never decreasing.
    ///
    /// `on_bytes` gets the bytes read so far and how many there are to read, where that is
    /// known. Gives how many rows were used, and what was refused on the way.
    ///
    /// # Errors
    /// [`DatasetError`] for a file that cannot be read or holds no usable row of the
    /// format, and for a rig that has other sensors than the recording.
    fn read(
        &self,
        drive: &DriveFile<'_>,
        on_bytes: &mut dyn FnMut(u64, Option<u64>),
        take: &mut dyn FnMut(&Record),
    ) -> Result<ReadRows, DatasetError>;
}

/// The format of a file or folder.
///
/// # Errors
/// [`DatasetError::Read`] if nothing is there; [`DatasetError::UnknownFormat`], with what
/// each of [`DATASETS`] looks for.
pub fn recognise(path: &Path) -> Result<&'static dyn Dataset, DatasetError> {
    let file = shown(path);
    if let Err(source) = check_readable(path) {
        return Err(DatasetError::Read { file, source });
    }
    let mut all = DATASETS.into_iter();
    all.find(|dataset| dataset.recognises(path))
        .ok_or_else(|| DatasetError::UnknownFormat {
            file,
            looked_for: DATASETS
                .map(|dataset| format!("{} ({})", dataset.looks_for(), dataset.name()))
                .join("; or "),
        })
}

/// Whether a drive's file or folder can be opened; a file must hold something.
fn check_readable(path: &Path) -> std::io::Result<()> {
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return std::fs::read_dir(path).map(drop);
    }
    if !found.is_file() {
        return Err(std::io::Error::other("is neither a file nor a folder"));
    }
    std::fs::File::open(path)?;
    if found.len() == 0 {
        return Err(std::io::Error::other("is empty"));
    }
    Ok(())
}
