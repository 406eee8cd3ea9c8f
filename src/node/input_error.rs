//! The reasons for which a node refuses an input.

use serde::{Deserialize, Serialize};

/// Why an input was refused. Variants are appended, never reordered: they go over the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InputError {
    /// A stamp lies before one of the same kind that was already taken.
    StampBackward,
    /// A coordinate or speed is NaN or infinite.
    NotFinite,
    /// A reading came before any odometry.
    NoPose,
    /// The odometry is too old, or too new, to give the pose of a reading.
    StalePose,
    /// A tick came before any reading.
    NoReading,
    /// A configuration has a parameter outside its range.
    BadParameter,
    /// A configuration has more particles than the capacity.
    TooManyParticles,
    /// A message arrived that is not an input.
    NotAnInput,
    /// A pose or a wheel's speed is farther from the one before than a robot can get.
    Implausible,
    /// A step was due, but no sensor in use had a reading: nothing was done.
    NoSensor,
    /// Readings or odometry came over the link, but the board reads its own.
    NotTheSource,
    /// The board is in its safe mode: it answers on the link and does nothing else.
    SafeMode,
}

impl InputError {
    /// Every fault, in the order of its code on the wire.
    pub const ALL: [Self; 12] = [
        Self::StampBackward,
        Self::NotFinite,
        Self::NoPose,
        Self::StalePose,
        Self::NoReading,
        Self::BadParameter,
        Self::TooManyParticles,
        Self::NotAnInput,
        Self::Implausible,
        Self::NoSensor,
        Self::NotTheSource,
        Self::SafeMode,
    ];
}

impl core::fmt::Display for InputError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::StampBackward => "stamp lies before an earlier one",
            Self::NotFinite => "number is not finite",
            Self::NoPose => "reading came before any odometry",
            Self::StalePose => "no odometry near the reading's time",
            Self::NoReading => "tick came before any reading",
            Self::BadParameter => "parameter is outside its range",
            Self::TooManyParticles => "more particles than the capacity",
            Self::NotAnInput => "message is not an input",
            Self::Implausible => "farther or faster than a robot can get",
            Self::NoSensor => "no sensor has anything to say",
            Self::NotTheSource => "the board reads its own sensors and odometry",
            Self::SafeMode => "the board is in its safe mode",
        })
    }
}

impl core::error::Error for InputError {}
