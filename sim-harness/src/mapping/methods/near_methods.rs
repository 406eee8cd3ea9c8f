//! Methods for cones that are right near by only, and the rule of a navigation stack.

use super::{Method, SensorChoice};
use crate::mapping::{BearingBinMapper, NearRangeMapper, RangeLayerMapper, RangeLayerParameters};
use crate::sensors::SensorKind::{Cone, Infrared, Scanner};

const NEAR: &str = "this project: inverse sensor model within the range in which cones are right";
const BINS: &str = "this project: hits and passes of cones per bearing";
const NAV2: &str = "Nav2, range sensor layer, docs.nav2.org";

const CONES: SensorChoice = SensorChoice::FirstOf(&[Cone, Infrared]);

impl Method {
    /// Hits of near readings and passes of near cells.
    pub const ISM_NEAR: Self = Self::new("ism-near", NEAR, CONES, |s| {
        Box::new(NearRangeMapper::new(s.lattice, s.rig))
    });
    /// Hits and passes counted in bins of bearing, at every pose.
    pub const PGC: Self = Self {
        maps_every_pose: true,
        ..Self::new("pgc", BINS, CONES, |s| {
            Box::new(BearingBinMapper::new(s.lattice, s.rig))
        })
    };
    /// The range sensor layer of Nav2.
    pub const NAV2_RANGE: Self = Self::new(
        "nav2-range",
        NAV2,
        SensorChoice::FirstOf(&[Cone, Scanner, Infrared]),
        |s| {
            let parameters = RangeLayerParameters::NAV2.with(s.no_echo);
            Box::new(RangeLayerMapper::new(s.lattice, s.rig, parameters))
        },
    );
}
