//! Which poses a drive is read with.

use core::fmt;
use core::str::FromStr;

/// Which poses a drive is read with, where a recording carries several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PoseSource {
    /// Those of the robot's odometry.
    #[default]
    Odometry,
    /// Those that were matched to the recording afterwards.
    Matched,
    /// Those that cameras in the room measured.
    MotionCapture,
}

impl PoseSource {
    /// Every source.
    pub const ALL: [Self; 3] = [Self::Odometry, Self::Matched, Self::MotionCapture];

    /// Its name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Odometry => "odometry",
            Self::Matched => "matched",
            Self::MotionCapture => "mocap",
        }
    }
}

impl fmt::Display for PoseSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no source of poses has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there are {}", PoseSource::ALL.map(PoseSource::name).join(", "))]
pub struct UnknownPoseSource;

impl FromStr for PoseSource {
    type Err = UnknownPoseSource;

    fn from_str(name: &str) -> Result<Self, UnknownPoseSource> {
        let mut all = Self::ALL.into_iter();
        all.find(|source| source.name() == name)
            .ok_or(UnknownPoseSource)
    }
}
