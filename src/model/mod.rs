//! The models of the robot: sensor ring, photometric law, inverse kinematics.
//!
//! [`Ring`] is the geometry of the sensors, [`Sample`] is what one of them delivers,
//! [`Photometry`] is the law between counts and range (paper equation 5), [`Reading`]
//! is a sample interpreted by that law, [`Gain`] is that of one sensor of the ring.
//! [`TabulatedWallLaw`] is the law of walls, which fill the lobe. [`DifferentialDrive`] and
//! [`InverseMotion`] are the kinematics of section 4.4.

mod beam_pattern;
mod gain;
mod inverse_kinematics;
mod photometry;
mod reading;
mod ring;
mod wall_law;

pub use beam_pattern::BeamPattern;
pub use gain::Gain;
pub use inverse_kinematics::{
    DifferentialDrive, InverseMotion, TravelNoise, WheelSpeeds, WheelTravel,
};
pub use photometry::{Photometry, RangeEstimate};
pub use reading::{Reading, Sample};
pub use ring::{Mount, Ring, SENSORS, SensorMask};
#[cfg(test)]
pub(crate) use wall_law::evaluations;
pub use wall_law::{MAX_WALLS, TabulatedWallLaw, Wall, WallReturn};
