//! Everything that stays the same during a run, with what can be prepared of it.

use super::visibility::Visibility;
use super::{FilterParameters, SurvivalRule, WallParameters};
use crate::geometry::Point;
use crate::model::{BeamPattern, DifferentialDrive, Mount, Photometry, Ring, SENSORS};

/// The robot, its sensors and the filter's choices, ready for stepping.
///
/// About 1.6 kB; built once a run. A model is `&self` in every step: changing
/// parameters means making another one, so a set can never meet half a change.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) parameters: FilterParameters,
    pub(crate) photometry: Photometry,
    pub(crate) drive: DifferentialDrive,
    pub(crate) mounts: [Mount; SENSORS],
    pub(crate) beam_pattern: BeamPattern,
    pub(crate) visibility: Visibility,
    /// For a filter over wall segments; the tables of its law are in the set.
    pub(crate) walls: Option<&'static WallParameters>,
}

impl Model {
    /// Prepares a model: the sensors' axes and the table of the beam pattern.
    #[must_use]
    pub fn new(
        parameters: FilterParameters,
        photometry: Photometry,
        ring: &Ring,
        drive: DifferentialDrive,
    ) -> Self {
        let mounts = core::array::from_fn(|index| ring.mount(index));
        let beam_pattern = BeamPattern::of(&photometry);
        Self {
            parameters,
            photometry,
            drive,
            mounts,
            visibility: Visibility::of(&mounts, &beam_pattern),
            walls: (parameters.survival == SurvivalRule::BernoulliOnWalls)
                .then_some(&WallParameters::WALL),
            beam_pattern,
        }
    }

    /// The photometric law in use.
    #[must_use]
    pub fn photometry(&self) -> &Photometry {
        &self.photometry
    }

    /// Whether the particles are weighed against wall segments (the profile `wall`).
    #[must_use]
    pub fn has_walls(&self) -> bool {
        self.walls.is_some()
    }

    /// Whether a position of the body frame lies outside the local radius.
    #[inline]
    pub(super) fn is_outside(&self, position: Point) -> bool {
        let radius_m = self.parameters.local_radius_m;
        position.norm_squared() > radius_m * radius_m
    }
}
