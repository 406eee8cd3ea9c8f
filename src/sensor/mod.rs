//! The robot's proximity sensors: where they sit, what they measure, what it means.
//!
//! [`Ring`] is the geometry, [`Sample`] what a sensor delivers, [`Photometry`] the
//! law between counts and range (paper equation 5), [`Reading`] what the law makes
//! of a sample.

mod lobe;
mod photometry;
mod reading;
mod ring;

pub use lobe::Lobe;
pub use photometry::{Echo, Photometry};
pub use reading::{Reading, Sample};
pub use ring::{Mount, Ring, SENSORS, SensorMask};
