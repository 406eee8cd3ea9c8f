//! The profiles of the inverse particle filter as mapping methods.

use amiro_ipf::filter::Profile;

use super::{Method, SensorChoice};
use crate::mapping::CountingMapper;
use crate::sensors::SensorKind;

const PAPER: &str = "Korthals et al. 2016, algorithms 1 and 2, equations 3 and 4";
const OURS: &str = "this project: the paper's filter with additions, docs/decisions.md";
const SEGMENTS: &str = "this project: wall segments fitted to the law of walls";

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

    /// [`PAPER`](Self::PAPER) under its name among the methods of recorded drives.
    pub const IPF_PAPER: Self = Self::named("ipf-paper", Self::PAPER);
    /// [`PLUS`](Self::PLUS) likewise.
    pub const IPF_PLUS: Self = Self::named("ipf-plus", Self::PLUS);
    /// [`WALL`](Self::WALL) likewise.
    pub const IPF_WALL: Self = Self::named("ipf-wall", Self::WALL);

    const fn filter(name: &'static str, source: &'static str, profile: Profile) -> Self {
        let infrared = SensorChoice::Each(&[SensorKind::Infrared]);
        let method = Self::new(name, source, infrared, |setup| {
            Box::new(CountingMapper::new(setup.lattice))
        });
        Self {
            profile: Some(profile),
            ..method
        }
    }
}
