//! The table of mapping methods.

use core::fmt;
use core::str::FromStr;

use amiro_ipf::filter::Profile;

use super::{
    AllFreeMapper, CountingMapper, FootprintMapper, InverseSensorMapper, InverseSensorParameters,
    Mapper, NoEcho,
};
use crate::geometry::Rectangle;
use crate::rig::Rig;

/// One way to make a map of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Its name on the command line, in tables and files.
    pub name: &'static str,
    /// Where it comes from: paper and section.
    pub source: &'static str,
    kind: Kind,
}

/// What a method maps.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// The outcomes of the inverse particle filter with this profile.
    Outcomes(Profile),
    /// Ranges, by the inverse sensor model.
    Ranges(InverseSensorParameters),
    /// Nothing.
    AllFree,
}

/// What a method is built for.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The robot.
    pub rig: &'a Rig,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Whether the robot's footprint is free in the map (see [`FootprintMapper`]).
    pub footprint: bool,
    /// The rectangle that [`Method::ALL_FREE`] maps; without one its map is empty.
    pub extent: Option<Rectangle>,
}

const PAPER: &str = "Korthals et al. 2016, algorithms 1 and 2, equations 3 and 4";
const OURS: &str = "this project: the paper's filter with additions, docs/decisions.md";
const ISM: &str = "Thrun, Burgard and Fox 2005, table 4.2, over the lobes of proximity sensors";
const RANGES: &str = "Thrun, Burgard and Fox 2005, table 4.2";
const DECAY: &str = "Carvalho and Ventura 2013, section II";

const STANDARD: InverseSensorParameters = InverseSensorParameters::STANDARD;
const TUNED: InverseSensorParameters = InverseSensorParameters::TUNED;

impl Method {
    /// The paper's filter.
    pub const PAPER: Self = Self::outcomes("paper", PAPER, Profile::Paper);
    /// Our filter.
    pub const PLUS: Self = Self::outcomes("plus", OURS, Profile::Plus);
    /// Inverse sensor model, usual parameters, nothing in range counted as free.
    pub const ISM_STANDARD: Self = Self::ranges("ism-standard", ISM, STANDARD);
    /// The same with tuned parameters.
    pub const ISM_TUNED: Self = Self::ranges("ism-tuned", ISM, TUNED);
    /// Usual parameters, nothing in range dropped.
    pub const ISM_STANDARD_DROPPED: Self =
        Self::ranges("ism-standard-dropped", ISM, STANDARD.with(NoEcho::Dropped));
    /// Usual parameters, nothing in range taken as an object.
    pub const ISM_STANDARD_OBJECT: Self =
        Self::ranges("ism-standard-object", ISM, STANDARD.with(NoEcho::Object));
    /// Tuned parameters, nothing in range dropped.
    pub const ISM_TUNED_DROPPED: Self =
        Self::ranges("ism-tuned-dropped", ISM, TUNED.with(NoEcho::Dropped));
    /// Tuned parameters, nothing in range taken as an object.
    pub const ISM_TUNED_OBJECT: Self =
        Self::ranges("ism-tuned-object", ISM, TUNED.with(NoEcho::Object));
    /// Inverse sensor model of range sensors.
    pub const ISM: Self = Self::ranges("ism", RANGES, InverseSensorParameters::RANGE);
    /// The same; an echo's weight decays to nothing over 5 m.
    pub const ISM_DECAY: Self = Self::ranges(
        "ism-decay",
        DECAY,
        InverseSensorParameters {
            decay_m: Some(5.0),
            ..InverseSensorParameters::RANGE
        },
    );
    /// No method: every cell of a rectangle is free, whatever is measured.
    pub const ALL_FREE: Self = Self {
        name: "all-free",
        source: "the row beside which an overall error is read",
        kind: Kind::AllFree,
    };

    /// Every method.
    pub const ALL: [Self; 11] = [
        Self::PAPER,
        Self::PLUS,
        Self::ISM_STANDARD,
        Self::ISM_TUNED,
        Self::ISM_STANDARD_DROPPED,
        Self::ISM_STANDARD_OBJECT,
        Self::ISM_TUNED_DROPPED,
        Self::ISM_TUNED_OBJECT,
        Self::ISM,
        Self::ISM_DECAY,
        Self::ALL_FREE,
    ];

    const fn outcomes(name: &'static str, source: &'static str, profile: Profile) -> Self {
        let kind = Kind::Outcomes(profile);
        Self { name, source, kind }
    }

    const fn ranges(
        name: &'static str,
        source: &'static str,
        parameters: InverseSensorParameters,
    ) -> Self {
        let kind = Kind::Ranges(parameters);
        Self { name, source, kind }
    }

    /// Profile of the inverse particle filter whose outcomes the method maps; `None` for
    /// a method that needs no filter.
    #[must_use]
    pub const fn profile(&self) -> Option<Profile> {
        match self.kind {
            Kind::Outcomes(profile) => Some(profile),
            Kind::Ranges(_) | Kind::AllFree => None,
        }
    }

    /// The same method with returns without an echo counted as free, where it maps ranges.
    #[must_use]
    pub const fn with_no_echo_free(self) -> Self {
        match self.kind {
            Kind::Ranges(parameters) => {
                let kind = Kind::Ranges(parameters.with(NoEcho::Free));
                Self { kind, ..self }
            }
            Kind::Outcomes(_) | Kind::AllFree => self,
        }
    }

    /// An empty map of this method.
    #[must_use]
    pub fn mapper(&self, setup: &Setup<'_>) -> FootprintMapper<Box<dyn Mapper>> {
        let cell_m = setup.cell_m;
        let mapper: Box<dyn Mapper> = match self.kind {
            Kind::Outcomes(_) => Box::new(CountingMapper::new(cell_m)),
            Kind::Ranges(parameters) => {
                Box::new(InverseSensorMapper::new(cell_m, setup.rig, parameters))
            }
            Kind::AllFree => Box::new(AllFreeMapper::new(cell_m, setup.extent.as_ref())),
        };
        let radius_m = setup.footprint.then_some(setup.rig.radius_m);
        FootprintMapper::new(mapper, cell_m, radius_m)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name)
    }
}

/// A name that no method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {name}; there are {}", Method::ALL.map(|method| method.name).join(", "))]
pub struct UnknownMethod {
    /// The name.
    pub name: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let method = Self::ALL.into_iter().find(|method| method.name == name);
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
            assert_eq!(method.name.parse(), Ok(method));
        }
        let error = "isn".parse::<Method>().unwrap_err().to_string();
        assert!(error.contains("isn; there are paper, plus"), "{error}");
    }
}
