//! Recorded drives of other robots: one file of code per file format.
//!
//! A [`Dataset`] recognises its format and reads a drive row by row into [`Record`]s, in
//! bounded memory. A row that cannot be used is refused with its line and the reason, and
//! the rows around it are kept.

mod error;
mod kcma;
mod lines;

pub use error::{DatasetError, RefusedRow, RefusedRows};
pub use kcma::Kcma;

use std::path::Path;

use crate::drive::Record;
use crate::rig::Rig;

/// The formats that are known, in the order in which they are tried.
pub const DATASETS: [&dyn Dataset; 1] = [&Kcma];

/// Which poses a drive is read with, where a recording carries several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PoseSource {
    /// Those of the robot's odometry.
    #[default]
    Odometry,
    /// Those that somebody matched to the recording afterwards.
    Matched,
}

/// A format of recorded drives.
pub trait Dataset: Sync {
    /// The format's name on the command line.
    fn name(&self) -> &'static str;

    /// Whether the file or folder is of this format; reads names and heads only.
    fn recognises(&self, path: &Path) -> bool;

    /// Reads a drive and hands on its records in order, stamps never decreasing.
    ///
    /// Gives what was refused on the way.
    ///
    /// # Errors
    /// [`DatasetError`] for a file that cannot be read or holds no row of the format, and
    /// for a rig that has other sensors than the recording.
    fn read(
        &self,
        path: &Path,
        rig: &Rig,
        poses: PoseSource,
        take: &mut dyn FnMut(&Record),
    ) -> Result<RefusedRows, DatasetError>;
}

/// The format of a file or folder; `None` if it is of none in [`DATASETS`].
#[must_use]
pub fn recognise(path: &Path) -> Option<&'static dyn Dataset> {
    DATASETS
        .into_iter()
        .find(|dataset| dataset.recognises(path))
}
