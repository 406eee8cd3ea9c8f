//! The ways to make a map that the figures compare.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;

use crate::figures::picture::Colour;
use crate::mapping::{CountingMapper, InverseSensorMapper, InverseSensorParameters, Mapper};

/// A way to make a map of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Method {
    /// The inverse sensor model with these parameters.
    InverseSensor(InverseSensorParameters),
    /// The inverse particle filter with this profile.
    Filter(Profile),
}

impl Method {
    /// The inverse sensor model with the usual evidence.
    pub(super) const ISM_STANDARD: Self = Self::InverseSensor(InverseSensorParameters::STANDARD);
    /// The inverse sensor model with the best evidence that was found.
    pub(super) const ISM_TUNED: Self = Self::InverseSensor(InverseSensorParameters::TUNED);
    /// The paper's filter.
    pub(super) const PAPER: Self = Self::Filter(Profile::Paper);
    /// Ours.
    pub(super) const PLUS: Self = Self::Filter(Profile::Plus);

    /// The four that are compared by numbers, with names and colours.
    pub(super) const COMPARED: [(Self, &'static str, Colour); 4] = [
        (Self::ISM_STANDARD, "ISM standard", [170, 170, 170]),
        (Self::ISM_TUNED, "ISM tuned", [110, 110, 110]),
        (Self::PAPER, "paper", [230, 140, 30]),
        (Self::PLUS, "plus", [30, 110, 200]),
    ];

    /// The profile whose run the map is made of; the inverse sensor model needs only
    /// the steps, which are the same in every run.
    pub(super) fn profile(self) -> Profile {
        match self {
            Self::InverseSensor(_) => Profile::Paper,
            Self::Filter(profile) => profile,
        }
    }

    /// An empty map of this kind.
    pub(super) fn mapper(self, cell_m: f64, config: &Config) -> Box<dyn Mapper> {
        match self {
            Self::InverseSensor(parameters) => {
                Box::new(InverseSensorMapper::new(cell_m, config, parameters))
            }
            Self::Filter(_) => Box::new(CountingMapper::new(cell_m)),
        }
    }
}
