//! One way to make a map of a drive.

use core::fmt;
use core::str::FromStr;

use amiro_ipf::filter::Profile;

use super::{SensorChoice, Setup};
use crate::drive::Keyframes;
use crate::mapping::{FootprintMapper, Mapper};

/// One way to make a map of a drive: a row of the table [`Method::ALL`].
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name on the command line, in tables and files.
    pub name: &'static str,
    /// Where it comes from: paper and section.
    pub source: &'static str,
    /// Profile of the inverse particle filter whose outcomes it maps; `None` for a method
    /// that needs no filter.
    pub profile: Option<Profile>,
    /// Whether it fits the signals of infrared sensors by the law of extended surfaces: it
    /// needs such sensors, and the gain of that law.
    pub fits_signals: bool,
    /// The sensors that it maps.
    pub sensors: SensorChoice,
    /// Whether it maps the scans of every pose of a drive, not of keyframes only.
    pub maps_every_pose: bool,
    /// Whether it maps the even keyframes alone where a scanner of the recording makes the
    /// truth: the truth is then that of the odd ones.
    pub splits_keyframes: bool,
    /// Makes its mapper, with an empty map.
    pub build: fn(&Setup<'_>) -> Box<dyn Mapper>,
}

impl Method {
    /// Every method.
    pub const ALL: &[Self] = &[
        Self::PAPER,
        Self::PLUS,
        Self::ARCS,
        Self::WALL,
        Self::ISM_STANDARD,
        Self::ISM_TUNED,
        Self::ISM_STANDARD_DROPPED,
        Self::ISM_STANDARD_OBJECT,
        Self::ISM_TUNED_DROPPED,
        Self::ISM_TUNED_OBJECT,
        Self::ISM,
        Self::ISM_DECAY,
        Self::ISM_CESP,
        Self::ISM_DECAY_CESP,
        Self::FSM,
        Self::FSM_HARD,
        Self::FSM_CESP,
        Self::MAL,
        Self::CEMAL,
        Self::WALL_MAP,
        Self::SEGMENTS,
        Self::KLEPPE,
        Self::KLEPPE_PAPER,
        Self::BAYES,
        Self::DS,
        Self::FUZZY,
        Self::BAYES_BOX,
        Self::DS_BOX,
        Self::FUZZY_BOX,
        Self::LASER,
        Self::SONAR,
        Self::PESSIMISTIC,
        Self::MINMAX,
        Self::ISM_NEAR,
        Self::PGC,
        Self::NAV2_RANGE,
        Self::ALL_FREE,
    ];

    /// The methods of recorded drives, by the names that tables of them have.
    pub const OF_DRIVES: &[Self] = &[
        Self::ALL_FREE,
        Self::ISM,
        Self::ISM_DECAY,
        Self::ISM_CESP,
        Self::ISM_DECAY_CESP,
        Self::FSM,
        Self::FSM_HARD,
        Self::FSM_CESP,
        Self::MAL,
        Self::CEMAL,
        Self::BAYES,
        Self::DS,
        Self::FUZZY,
        Self::BAYES_BOX,
        Self::DS_BOX,
        Self::FUZZY_BOX,
        Self::LASER,
        Self::SONAR,
        Self::PESSIMISTIC,
        Self::MINMAX,
        Self::NAV2_RANGE,
        Self::ISM_NEAR,
        Self::PGC,
        Self::KLEPPE,
        Self::KLEPPE_PAPER,
        Self::IPF_PAPER,
        Self::IPF_PLUS,
        Self::IPF_WALL,
        Self::SEGMENTS,
        Self::WALL_MAP,
        Self::ISM_PROXIMITY,
    ];

    /// The method of recorded drives of a name.
    #[must_use]
    pub fn of_drives(name: &str) -> Option<Self> {
        let mut all = Self::OF_DRIVES.iter().copied();
        all.find(|method| method.name == name)
    }

    /// A method of keyframes, without a filter.
    pub(super) const fn new(
        name: &'static str,
        source: &'static str,
        sensors: SensorChoice,
        build: fn(&Setup<'_>) -> Box<dyn Mapper>,
    ) -> Self {
        Self {
            name,
            source,
            profile: None,
            fits_signals: false,
            sensors,
            maps_every_pose: false,
            splits_keyframes: false,
            build,
        }
    }

    /// The same method under another name.
    pub(super) const fn named(name: &'static str, method: Self) -> Self {
        Self { name, ..method }
    }

    /// The keyframes of a drive whose format usually has those given.
    #[must_use]
    pub const fn keyframes(&self, usual: Keyframes) -> Keyframes {
        if self.maps_every_pose {
            Keyframes::new(0.0, 0.0)
        } else {
            usual
        }
    }

    /// An empty map of this method, with the robot's footprint if the setup wants it.
    #[must_use]
    pub fn mapper(&self, setup: &Setup<'_>) -> FootprintMapper<Box<dyn Mapper>> {
        let radius_m = setup.footprint.then_some(setup.rig.radius_m);
        FootprintMapper::new((self.build)(setup), setup.lattice, radius_m)
    }
}

/// Methods are equal if they have the same name.
impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Method {}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name)
    }
}

/// A name that no method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {name}; there are {}", Method::ALL.iter().map(|method| method.name).collect::<Vec<_>>().join(", "))]
pub struct UnknownMethod {
    /// The name.
    pub name: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let method = Self::ALL.iter().copied().find(|method| method.name == name);
        method.ok_or_else(|| UnknownMethod {
            name: name.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_back_to_its_method() {
        for method in Method::ALL {
            assert_eq!(method.name.parse(), Ok(*method));
        }
        let error = "isn".parse::<Method>().unwrap_err().to_string();
        assert!(error.contains("isn; there are paper, plus"), "{error}");
    }
}
