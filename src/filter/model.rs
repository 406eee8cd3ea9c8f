//! Everything that stays the same during a run, with what can be prepared of it.

use super::FilterParameters;
use crate::kinematics::DifferentialDrive;
use crate::sensor::{Lobe, Mount, Photometry, Ring, SENSORS};

/// The robot, its sensors and the filter's choices, ready for stepping.
///
/// About 600 bytes; built once a run. A model is `&self` in every step: changing
/// parameters means making another one, so a set can never meet half a change.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) parameters: FilterParameters,
    pub(crate) photometry: Photometry,
    pub(crate) drive: DifferentialDrive,
    pub(crate) mounts: [Mount; SENSORS],
    pub(crate) lobe: Lobe,
}

impl Model {
    /// Prepares a model: the sensors' axes and the lobe's table.
    #[must_use]
    pub fn new(
        parameters: FilterParameters,
        photometry: Photometry,
        ring: &Ring,
        drive: DifferentialDrive,
    ) -> Self {
        Self {
            parameters,
            photometry,
            drive,
            mounts: core::array::from_fn(|index| ring.mount(index)),
            lobe: Lobe::of(&photometry),
        }
    }

    /// The photometric law in use.
    #[must_use]
    pub fn photometry(&self) -> &Photometry {
        &self.photometry
    }
}
