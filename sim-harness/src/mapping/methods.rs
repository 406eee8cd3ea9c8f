//! The table of mapping methods.

use core::fmt;
use core::str::FromStr;

use amiro_ipf::filter::{Profile, SegmentParameters};

use super::{
    AllFreeMapper, BeamForm, BeamMapper, CountingMapper, FootprintMapper, InverseSensorMapper,
    InverseSensorParameters, Mapper, NoEcho, SegmentMapper, WallMapParameters, WallMapper,
};
use crate::drive::Keyframes;
use crate::geometry::Rectangle;
use crate::rig::Rig;

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
    /// Whether it takes the beams of range sensors, or the axes of cones as beams, and at
    /// every pose of a drive, not at keyframes.
    pub takes_beams: bool,
    /// Makes its mapper, with an empty map.
    pub build: fn(&Setup<'_>) -> Box<dyn Mapper>,
}

/// The arguments of a mapper's constructor.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The robot.
    pub rig: &'a Rig,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Whether the robot's footprint is free in the map (see [`FootprintMapper`]).
    pub footprint: bool,
    /// The rule for returns without an echo; `None` for the method's own rule.
    pub no_echo: Option<NoEcho>,
    /// The rectangle that [`Method::ALL_FREE`] maps; without one its map is empty.
    pub extent: Option<Rectangle>,
}

impl<'a> Setup<'a> {
    /// Cells of the given size, metres, for a robot; no footprint, no rectangle, and the
    /// method's own rule for returns without an echo.
    #[must_use]
    pub const fn new(rig: &'a Rig, cell_m: f64) -> Self {
        Self {
            rig,
            cell_m,
            footprint: false,
            no_echo: None,
            extent: None,
        }
    }
}

const PAPER: &str = "Korthals et al. 2016, algorithms 1 and 2, equations 3 and 4";
const OURS: &str = "this project: the paper's filter with additions, docs/decisions.md";
const LOBES: &str = "Thrun, Burgard and Fox 2005, table 4.2, over the lobes of proximity sensors";
const RANGES: &str = "Thrun, Burgard and Fox 2005, table 4.2";
const SEGMENTS: &str = "this project: wall segments fitted to the law of walls";
const DECAY: &str = "Carvalho and Ventura 2013, section II";
const BEAMS: &str = "Kleppe and Skavhaug 2013, with resampling for a robot that moves";
const BEAMS_PAPER: &str = "Kleppe and Skavhaug 2013, algorithm 2";
const WALLS: &str = "this project: walls with ends under Lambert's law, mapping/wall_map";

const STANDARD: InverseSensorParameters = InverseSensorParameters::STANDARD;
const TUNED: InverseSensorParameters = InverseSensorParameters::TUNED;
const RANGE: InverseSensorParameters = InverseSensorParameters::RANGE;

impl Method {
    /// The paper's filter.
    pub const PAPER: Self = Self::filter("paper", PAPER, Profile::Paper);
    /// Our filter.
    pub const PLUS: Self = Self::filter("plus", OURS, Profile::Plus);
    /// Our filter with readings as upper bounds, without wall segments.
    pub const ARCS: Self = Self {
        fits_signals: true,
        ..Self::filter("arcs", OURS, Profile::Arcs)
    };
    /// Our filter over tracked wall segments.
    pub const WALL: Self = Self {
        fits_signals: true,
        ..Self::filter("wall", SEGMENTS, Profile::Wall)
    };
    /// Inverse sensor model, usual parameters, nothing in range counted as free.
    pub const ISM_STANDARD: Self = Self::new("ism-standard", LOBES, |s| ism(s, STANDARD));
    /// The same with tuned parameters.
    pub const ISM_TUNED: Self = Self::new("ism-tuned", LOBES, |s| ism(s, TUNED));
    /// Usual parameters, nothing in range dropped.
    pub const ISM_STANDARD_DROPPED: Self = Self::new("ism-standard-dropped", LOBES, |s| {
        ism(s, STANDARD.with(NoEcho::Dropped))
    });
    /// Usual parameters, nothing in range taken as an object.
    pub const ISM_STANDARD_OBJECT: Self = Self::new("ism-standard-object", LOBES, |s| {
        ism(s, STANDARD.with(NoEcho::Object))
    });
    /// Tuned parameters, nothing in range dropped.
    pub const ISM_TUNED_DROPPED: Self = Self::new("ism-tuned-dropped", LOBES, |s| {
        ism(s, TUNED.with(NoEcho::Dropped))
    });
    /// Tuned parameters, nothing in range taken as an object.
    pub const ISM_TUNED_OBJECT: Self = Self::new("ism-tuned-object", LOBES, |s| {
        ism(s, TUNED.with(NoEcho::Object))
    });
    /// Inverse sensor model of range sensors.
    pub const ISM: Self = Self::new("ism", RANGES, |s| ism(s, RANGE));
    /// The same; an echo's weight decays to nothing over 5 m.
    pub const ISM_DECAY: Self = Self::new("ism-decay", DECAY, |s| {
        let decay_m = Some(5.0);
        ism(s, InverseSensorParameters { decay_m, ..RANGE })
    });
    /// Straight walls fitted to all signals of a drive at once.
    pub const WALL_MAP: Self = Self {
        fits_signals: true,
        ..Self::new("wall-map", WALLS, |s| {
            let parameters = WallMapParameters::STANDARD;
            Box::new(WallMapper::new(s.cell_m, s.rig, parameters))
        })
    };
    /// Wall segments tracked over all readings of the last steps.
    pub const SEGMENTS: Self = Self {
        fits_signals: true,
        ..Self::new("segments", SEGMENTS, |s| {
            // Three stations of 50 mm, not the filter's four: 2.0 false cells per recorded
            // series, not 4.5. Drives with steps of 10 mm give the same map.
            let parameters = SegmentParameters {
                window_m: 0.125,
                ..SegmentParameters::STEPS
            };
            Box::new(SegmentMapper::new(
                s,
                parameters,
                WallMapParameters::STANDARD,
            ))
        })
    };
    /// The inverted particle filter for range beams, for a robot that moves.
    pub const KLEPPE: Self = Self {
        takes_beams: true,
        ..Self::new("kleppe", BEAMS, |s| beams(s, BeamForm::Moving))
    };
    /// The same with the resampling and re-entry of its paper.
    pub const KLEPPE_PAPER: Self = Self {
        takes_beams: true,
        ..Self::new("kleppe-paper", BEAMS_PAPER, |s| beams(s, BeamForm::Paper))
    };
    /// No method: every cell of a rectangle is free, for any measurement.
    pub const ALL_FREE: Self = Self::new("all-free", "the row to compare scores with", |s| {
        Box::new(AllFreeMapper::new(s.cell_m, s.extent.as_ref()))
    });

    /// Every method.
    pub const ALL: [Self; 17] = [
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
        Self::WALL_MAP,
        Self::SEGMENTS,
        Self::KLEPPE,
        Self::KLEPPE_PAPER,
        Self::ALL_FREE,
    ];

    const fn new(
        name: &'static str,
        source: &'static str,
        build: fn(&Setup<'_>) -> Box<dyn Mapper>,
    ) -> Self {
        Self {
            name,
            source,
            profile: None,
            fits_signals: false,
            takes_beams: false,
            build,
        }
    }

    const fn filter(name: &'static str, source: &'static str, profile: Profile) -> Self {
        Self {
            name,
            source,
            profile: Some(profile),
            fits_signals: false,
            takes_beams: false,
            build: |setup| Box::new(CountingMapper::new(setup.cell_m)),
        }
    }

    /// The keyframes of a drive whose format usually has those given.
    #[must_use]
    pub const fn keyframes(&self, usual: Keyframes) -> Keyframes {
        if self.takes_beams {
            Keyframes::new(0.0, 0.0)
        } else {
            usual
        }
    }

    /// An empty map of this method, with the robot's footprint if the setup wants it.
    #[must_use]
    pub fn mapper(&self, setup: &Setup<'_>) -> FootprintMapper<Box<dyn Mapper>> {
        let radius_m = setup.footprint.then_some(setup.rig.radius_m);
        FootprintMapper::new((self.build)(setup), setup.cell_m, radius_m)
    }
}

fn ism(setup: &Setup<'_>, parameters: InverseSensorParameters) -> Box<dyn Mapper> {
    let no_echo = setup.no_echo.unwrap_or(parameters.no_echo);
    let parameters = parameters.with(no_echo);
    Box::new(InverseSensorMapper::new(
        setup.cell_m,
        setup.rig,
        parameters,
    ))
}

fn beams(setup: &Setup<'_>, form: BeamForm) -> Box<dyn Mapper> {
    Box::new(BeamMapper::new(setup.cell_m, setup.rig, form))
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
