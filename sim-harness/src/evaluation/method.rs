//! The methods that are compared: a filter with a mapper, or the inverse sensor model.

use core::fmt;
use core::str::FromStr;

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;

use crate::mapping::{
    AllFreeMapper, CountingMapper, InverseSensorMapper, InverseSensorParameters, Mapper, MaxRange,
};
use crate::world::Scenario;

/// A way from readings to a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's filter.
    Paper,
    /// Our filter.
    Plus,
    /// Our filter; the map carves the sensors' lobes as well.
    PlusCarving,
    /// Inverse sensor model, usual parameters, nothing in range drawn free.
    IsmStandard,
    /// The same with tuned parameters.
    IsmTuned,
    /// Usual parameters, nothing in range dropped.
    IsmStandardDropped,
    /// Usual parameters, nothing in range taken as an object.
    IsmStandardObject,
    /// Tuned parameters, nothing in range dropped.
    IsmTunedDropped,
    /// Tuned parameters, nothing in range taken as an object.
    IsmTunedObject,
    /// No method: every cell of the scenario's rectangle is free.
    AllFree,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 10] = [
        Self::Paper,
        Self::Plus,
        Self::PlusCarving,
        Self::IsmStandard,
        Self::IsmTuned,
        Self::IsmStandardDropped,
        Self::IsmStandardObject,
        Self::IsmTunedDropped,
        Self::IsmTunedObject,
        Self::AllFree,
    ];

    /// The name, as in tables and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Plus => "plus",
            Self::PlusCarving => "plus-carving",
            Self::IsmStandard => "ism-standard",
            Self::IsmTuned => "ism-tuned",
            Self::IsmStandardDropped => "ism-standard-dropped",
            Self::IsmStandardObject => "ism-standard-object",
            Self::IsmTunedDropped => "ism-tuned-dropped",
            Self::IsmTunedObject => "ism-tuned-object",
            Self::AllFree => "all-free",
        }
    }

    /// The filter's profile; `None` for what needs no particles.
    #[must_use]
    pub const fn profile(self) -> Option<Profile> {
        match self {
            Self::Paper => Some(Profile::Paper),
            Self::Plus | Self::PlusCarving => Some(Profile::Plus),
            _ => None,
        }
    }

    /// A fresh mapper of a scenario for the sensors of a configuration.
    #[must_use]
    pub fn mapper(self, scenario: &Scenario, config: &Config) -> Box<dyn Mapper> {
        let cell_m = scenario.cell_m;
        let (standard, tuned) = (
            InverseSensorParameters::STANDARD,
            InverseSensorParameters::TUNED,
        );
        let parameters = match self {
            Self::Paper | Self::Plus => return Box::new(CountingMapper::new(cell_m)),
            Self::PlusCarving => return Box::new(CountingMapper::carving(cell_m, config)),
            Self::IsmStandard => standard,
            Self::IsmTuned => tuned,
            Self::IsmStandardDropped => standard.with(MaxRange::Dropped),
            Self::IsmStandardObject => standard.with(MaxRange::TakenAsObject),
            Self::IsmTunedDropped => tuned.with(MaxRange::Dropped),
            Self::IsmTunedObject => tuned.with(MaxRange::TakenAsObject),
            Self::AllFree => return Box::new(AllFreeMapper::new(cell_m, &scenario.extent)),
        };
        Box::new(InverseSensorMapper::new(cell_m, config, parameters))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that is no method's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {name}; there are {}", Method::ALL.map(Method::name).join(", "))]
pub struct UnknownMethod {
    /// The name.
    pub name: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let method = Self::ALL.into_iter().find(|method| method.name() == name);
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
            assert_eq!(method.name().parse(), Ok(method));
        }
        let error = "ism".parse::<Method>().unwrap_err().to_string();
        assert!(error.contains("ism; there are paper, plus"), "{error}");
    }
}
